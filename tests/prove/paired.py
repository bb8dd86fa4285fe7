# SPDX-License-Identifier: Apache-2.0
"""Small missions of few values, drawn from pairs of dimensions, and runs of theirs in which anything happens.

Rule: each key has so few values, or is compared in so few ways, that a proof represents them all.
"""

from __future__ import annotations

import random
from collections.abc import Callable, Iterator
from typing import Any

__all__ = ("DIMENSIONS", "Paired")

Json = dict[str, Any]
SPANS = (0.5, 1.0, 1.0, 2.0, 3.0)
FAILED = ["failed", "timed_out", "rejected", "unverified", "canceled", "aborted"]
OPTIONS = ("left", "right", "stay")
WORDS = ("x", "y", "z", "")
DIMENSIONS = (
    "readings", "objects", "counters", "lists", "decisions", "history", "regions", "timers", "trees", "handover",
    "actions", "events", "copies", "enums", "ages", "invariants", "limits", "finals", "replies", "robots",
    "places", "named", "quoted",
)  # fmt: skip


class Paired:
    """A mission as it is drawn, of two dimensions or three.

    Args:
        seed: What it follows from.
        dimensions: Those that are drawn; two or three if there are none.
    """

    def __init__(self, seed: int, dimensions: tuple[str, ...] = ()) -> None:
        self.r = r = random.Random(seed)
        self.dimensions = dimensions or tuple(r.sample(DIMENSIONS, r.choice([2, 2, 3])))
        self.keys: dict[str, Json] = {}
        self.values: dict[str, list[Any]] = {}
        """Key of the robot or argument → what a run gives it."""
        self.fields: dict[str, list[Any]] = {}
        """Field of an event, a result or an answer → what a run brings in it."""
        self.guards: list[Callable[[], Json]] = []
        self.effects: list[Callable[[], Json]] = []
        self.passing: list[Callable[[], Json]] = []
        """Guards on what an event brings."""
        self.inner: list[str] = []
        """Kinds of states."""
        self.names: list[str] = []
        self.plain: list[str] = []
        self.words: Json = {}
        self.outside: list[str] = []
        """Words that the engine itself reports."""
        self.facts: Json = {}
        """What is known of the robot, as `RobotFacts` has it."""
        self.done: list[tuple[Json, str, list[str]]] = []
        for each in self.dimensions:
            getattr(self, f"_{each}")()
        if not self.guards or r.random() < 0.3:
            self._flag()
        if not self.effects:
            self._flag()

    def some(self, share: float) -> bool:
        return self.r.random() < share

    def pick(self, *given: Any) -> Any:
        return self.r.choice(given)

    # -- dimensions ---------------------------------------------------------------------------------------------------

    def _key(self, name: str, kind: str, values: list[Any], source: str = "robot", **words: Any) -> None:
        self.keys[name] = {"type": kind, "source": source, **words}
        self.values[name] = values

    def _flag(self) -> None:
        self.keys["flag"] = {"type": "boolean", "initial": False}
        self.guards.append(lambda: {"key": "flag", "==": self.some(0.5)})
        self.effects.append(lambda: {"set": "flag", "value": self.some(0.6)})

    def _readings(self) -> None:
        age = {"max_age_s": self.pick(1.0, 2.0)} if self.some(0.5) else {}
        low, high = sorted(self.r.sample(range(4), 2))
        self._key("level", "integer", [-1, 0, 1, 2, 3, 4], optional=self.some(0.7), **age)
        self.guards.append(lambda: {"key": "level", self.pick("<", ">=", "==", "!=", ">"): self.pick(low, high)})
        self.guards.append(lambda: {"fresh": "level"})
        if self.some(0.6):
            self._key("clear", "boolean", [True, False], optional=self.some(0.7), **age)
            self.guards.append(lambda: {"key": "clear", "==": self.some(0.5)})
        if self.some(0.4):
            self._key("mode", "string", list(WORDS), optional=True)
            self.guards.append(lambda: {"key": "mode", **self.pick({"in": ["x", "y"]}, {"==": "x"}, {"!=": "y"})})

    def _objects(self) -> None:
        age = {"max_age_s": self.pick(1.0, 2.0)} if self.some(0.4) else {}
        fields = {"kind": "string", "far": "integer", "alive": "boolean"}
        made = [
            {name: value for name, value in zip(fields, each, strict=True) if value is not None}
            for each in [("x", 0, True), ("y", 2, False), ("z", 1, None), (None, None, True), ("x", 3, False),
                         (None, 1, None), ("y", None, True), ("x", 2, None), ("x", 2, True), (None, None, None)]
        ]  # fmt: skip
        self._key("seen", "object", made, fields=fields, optional=self.some(0.7), **age)
        self.guards += [
            lambda: {"key": "seen.kind", self.pick("==", "!="): self.pick("x", "y")},
            lambda: {"key": "seen.far", self.pick("<", ">="): self.pick(1, 2)},
            lambda: {"key": "seen.alive", "==": self.some(0.5)},
            lambda: {"fresh": self.pick("seen", "seen.far", "seen.alive")},
            lambda: {"all": [{"key": "seen.kind", "==": "x"}, {"key": "seen.far", "<": 2}]},
        ]
        if self.some(0.3):
            self.keys["last"] = {"type": "object", "fields": fields}
            self.effects.append(lambda: {"set": "last", "from": "seen"})
            self.guards.append(lambda: {"key": "last.kind", "==": self.pick("x", "y")})
            self.guards.append(lambda: {"fresh": "last"})

    def _counters(self) -> None:
        self.keys["n"] = {"type": "integer", "initial": 0}
        most = self.r.randint(2, 4)
        self.effects += [lambda: {"set": "n", "add": 1}] * 2 + [lambda: {"set": "n", "value": 0}]
        self.guards += [lambda: {"key": "n", self.pick("<", ">=", "=="): self.r.randint(1, most)}] * 2
        if self.some(0.4):
            self.keys["m"] = {"type": "integer", "initial": most}
            self.effects += [lambda: {"set": "m", "add": self.pick(-1, -2)}]
            self.guards += [lambda: {"key": "m", self.pick("<", ">", "=="): self.r.randint(0, 2)}]
            if self.some(0.3):
                self.effects.append(lambda: {"set": "m", "value": most})

    def _limits(self) -> None:
        """A count up to an argument."""
        self.keys["n"] = {"type": "integer", "initial": 0}
        given = {"initial": 2} if self.some(0.5) else {}
        self._key("most", "integer", [1, 2, 3], "argument", minimum=1, maximum=3, **given)
        self.effects += [lambda: {"set": "n", "add": 1}] * 2 + [lambda: {"set": "n", "value": 0}]
        self.guards += [lambda: {"key": "n", self.pick("<", ">=", "==", ">"): {"key": "most"}}] * 2

    def _enums(self) -> None:
        self._key("word", "string", ["x", "y", "z"], "argument", enum=["x", "y", "z"], initial="x")
        self.guards.append(lambda: {"key": "word", **self.pick({"==": "x"}, {"!=": "z"}, {"in": ["y", "z"]})})
        if self.some(0.6):
            self.keys["kept"] = {"type": "string", "initial": ""}
            self.effects += [lambda: {"set": "kept", "from": "word"}, lambda: {"set": "kept", "value": "y"}]
            self.guards.append(
                lambda: {"key": "kept", **self.pick({"==": "x"}, {"==": {"key": "word"}}, {"!=": {"key": "word"}})}
            )
        if self.some(0.4):
            self._key("other", "string", ["x", "y", "z"], "argument", enum=["x", "y", "z"])
            self.guards.append(lambda: {"key": "other", self.pick("==", "!="): {"key": "word"}})

    def _copies(self) -> None:
        self._key("mode", "string", list(WORDS), optional=self.some(0.7))
        self.keys["old"] = {"type": "string", **({"initial": ""} if self.some(0.5) else {})}
        self.effects.append(lambda: {"set": "old", "from": "mode"})
        self.guards += [
            lambda: {"key": "old", self.pick("==", "!="): {"key": "mode"}},
            lambda: {"key": "old", "==": "x"}, lambda: {"key": "mode", "==": self.pick("x", "y")},
            lambda: {"fresh": self.pick("old", "mode")},
        ]  # fmt: skip
        if self.some(0.4):
            self.keys["older"] = {"type": "string", "initial": "x"}
            self.effects.append(lambda: {"set": "older", "from": "old"})
            self.guards.append(lambda: {"key": "older", "==": {"key": "old"}})

    def _ages(self) -> None:
        """A key of the mission that goes stale, and guards that count time."""
        if self.some(0.5):
            self.keys["mark"] = {"type": "boolean", "max_age_s": self.pick(1.0, 2.0), "initial": False}
            self.effects.append(lambda: {"set": "mark", "value": self.some(0.7)})
            self.guards += [lambda: {"key": "mark", "==": True}, lambda: {"not": {"fresh": "mark"}}]
        self.guards += [
            lambda: {"elapsed_s": self.pick(*SPANS)},
            lambda: {"held": self.base(), "for_s": self.pick(*SPANS)},
        ]

    def _lists(self) -> None:
        source, how = self.pick("argument", "argument", "robot", "mission"), self.pick("objects", "words", "numbers")
        items: list[Any] = [0, 1, 2, 3] if how == "numbers" else ["x", "y", "z"]
        kind = "integer" if how == "numbers" else "string"
        words: Json = {}
        if how == "objects":
            items = [{"kind": "x", "size": 1}, {"kind": "y", "size": 2}, {"size": 3}, {"kind": "x"}]
            kind, words = "object", {"fields": {"kind": "string", "size": "integer"}}
        made = [[], items[:1], items[1:2], items[:2], items[2:], items, items[::-1]]
        if source == "mission":
            self.keys["items"] = {"type": "list", "initial": self.pick(*made)}
            self.effects += [lambda: {"set": "items", "value": self.pick(*made)}]
        else:
            first = {"initial": []} if source == "argument" and self.some(0.5) else {}
            self._key("items", "list", made, source, **first, **({"optional": True} if source == "robot" else {}))
        self.keys["item"] = {"type": kind, **words}
        at = {"objects": lambda: self.pick({"key": "item.kind", "==": "x"}, {"key": "item.size", ">=": 2},
                                           {"fresh": "item.kind"}),
              "words": lambda: {"key": "item", self.pick("==", "!="): self.pick("x", "y")},
              "numbers": lambda: {"key": "item", self.pick("<", ">=", "=="): self.pick(1, 2)}}[how]  # fmt: skip
        self.guards += [at, at]
        if self.some(0.3):
            self.guards.append(lambda: {"fresh": "items"})
        self.inner += ["each", "each"]

    def _decisions(self) -> None:
        self.inner += ["decision", "decision"]
        if self.some(0.6):
            kind = self.pick("string", "integer", "boolean")
            self.keys["given"] = {"type": kind, "source": "answer"}
            values: list[Any] = {"string": ["x", "y", "z"], "integer": [0, 1, 2], "boolean": [True, False]}[kind]
            self.fields["given"] = values
            self.guards += [lambda: {"key": "given", self.pick("==", "!="): self.pick(*values)}]
            if self.some(0.5):
                self.guards.append(lambda: {"fresh": "given"})

    def _history(self) -> None:
        self.inner += ["remembering", "remembering"]

    def _regions(self) -> None:
        self.inner += ["parallel", "parallel"]

    def _timers(self) -> None:
        self.effects += [
            lambda: {"raise": self.pick("a", "b"), "after_s": self.pick(0.0, *SPANS), "id": self.pick("one", "two")},
            lambda: {"raise": "b", "after_s": self.pick(*SPANS)}, lambda: {"drop": self.pick("one", "two")},
            lambda: {"raise": self.pick("c", "d")},
        ]  # fmt: skip

    def _trees(self) -> None:
        self.inner += ["tree", "tree", "tree"]

    def _handover(self) -> None:
        """States need control."""

    def _replies(self) -> None:
        """What is done about calls that fail, goals that never end, and what an answer or a result brings."""
        self.inner += ["action", "call", "decision"]
        self.effects += [lambda: {"call": "horn"}]
        self.outside += ["call_failed", "orphaned", "uncertain"]
        self.keys["given"] = {"type": "integer", "source": "answer"}
        self.fields |= {"given": [0, 1, 2, 3], "g": [0, 1, 2, 3]}
        self.passing += [
            lambda: {"key": "answer.given", self.pick("==", ">="): self.pick(1, 2)},
            lambda: {"key": "event.g", self.pick("==", ">="): self.pick(1, 2)},
        ]  # fmt: skip
        if self.some(0.5):
            self.keys["kept"] = {"type": "integer"}
            self.effects += [lambda: {"set": "kept", "from": "given"}]
            self.guards += [lambda: {"key": "kept", self.pick("==", "<"): self.pick(1, 2)}]
        else:
            self.guards += [lambda: {"key": "given", self.pick("==", "<"): self.pick(1, 2)}]

    def _robots(self) -> None:
        """A robot of which something is known: actions side by side, some kept during a pause, one composed."""
        self.inner += ["action", "action", "tree"]
        base, arm = frozenset({"base"}), frozenset({"arm"})
        uses: Any = self.pick(
            {}, {"drive": base, "turn": base}, {"drive": base, "turn": arm}, {"drive": base, "turn": None}
        )
        keep = frozenset(self.r.sample(["drive", "turn"], self.r.randint(0, 2)))
        self._key("hits", "integer", [0, 1, 2, 3], optional=True, **({"max_age_s": 2.0} if self.some(0.4) else {}))
        ends: Json = {}
        if self.some(0.7):
            ends["succeeded"] = {"turn": {"key": "hits", ">=": 2}}
            ends["failed"] = {"turn": {"key": "hits", "==": 1}} if self.some(0.6) else {}
        self.facts = {"uses": uses, "keep": keep, **ends}
        self.guards.append(lambda: {"key": "hits", self.pick("<", ">=", "=="): self.pick(1, 2, 3)})

    def _places(self) -> None:
        at = [{"x": x, "y": 0.0} for x in (0.0, 0.3, 0.5, 0.6, 2.0, 3.0, 4.0)] + [{"x": 0.0, "y": 0.4}]
        frame = {"frame": "map"} if self.some(0.7) else {}
        at = [{**each, **frame} for each in at]
        self._key("pose", "pose", at, optional=True, **frame, **({"max_age_s": 1.5} if self.some(0.4) else {}))
        self._key("home", "pose", at, "argument", initial={**at[0]}, **frame)
        self.guards += [lambda: {"near": ["pose", "home"], "within_m": 0.5}] * 2
        if self.some(0.5):
            self._key("dock", "pose", at, "argument", initial={**at[4]}, **frame)
            self.guards += [lambda: {"near": ["pose", "dock"], "within_m": 0.5}] * 2
        elif self.some(0.5):
            self.keys["aim"] = {"type": "pose", **frame}
            self.effects.append(lambda: {"set": "aim", "from": "home"})
            self.guards += [lambda: {"near": ["pose", "aim"], "within_m": 0.5}]

    def _named(self) -> None:
        """A predicate of the user's program."""
        self._key("level", "integer", [-1, 0, 1, 2, 3, 4], optional=True)
        self.guards += [lambda: {"named": "is_high", "with": {"margin": self.pick(1, 2)}}] * 2

    def _quoted(self) -> None:
        """What a raised event brings is a key's value, and what an event brings is kept and compared."""
        self.keys |= {"flag": {"type": "boolean", "initial": False}, "w": {"type": "string", "initial": "x"}}
        self.effects += [
            lambda: {"set": "flag", "value": self.some(0.6)}, lambda: {"set": "w", "value": self.pick("x", "y")},
            lambda: {"raise": self.pick("c", "d"), "data": {"w": {"from": "w"}}, **self.pick({}, {"after_s": 1.0})},
        ]  # fmt: skip
        self.fields["w"] = ["x", "y", "z"]
        self.passing += [lambda: {"key": "event.w", self.pick("==", "!="): self.pick("x", "y", {"key": "w"})}]
        self.guards += [lambda: {"key": "w", "==": self.pick("x", "y")}]

    def _actions(self) -> None:
        self.inner += ["action", "action", "call"]
        if self.some(0.5):
            self.keys["got"] = {"type": "integer"}
            self.fields["g"] = [0, 1, 2]
            self.guards += [lambda: {"key": "got", self.pick("==", ">="): 1}, lambda: {"fresh": "got"}]
        if self.some(0.4):
            self._key("there", "boolean", [True, False], optional=True)
            self.guards.append(lambda: {"key": "there", "==": True})

    def _events(self) -> None:
        self.fields["k"] = [0, 1, 2, 3]
        self.passing.append(lambda: {"key": "event.k", self.pick("<", ">=", "=="): self.pick(1, 2)})
        if self.some(0.5):
            self.keys["k"] = {"type": "integer", **({"initial": 0} if self.some(0.5) else {})}
            self.guards.append(lambda: {"key": "k", self.pick("==", ">="): self.pick(1, 2)})
        self.effects.append(lambda: {"raise": self.pick("c", "d"), "data": {"k": self.pick(0, 1, 2)}})

    def _invariants(self) -> None:
        self.words["invariants"] = True

    def _finals(self) -> None:
        self.inner += ["final", "compound"]

    # -- guards and effects -------------------------------------------------------------------------------------------

    def base(self) -> Json:
        return self.pick(*self.guards)()

    def guard(self, depth: int = 2, *, passing: bool = False) -> Json:
        if depth and self.some(0.35):
            word = self.pick("all", "any", "not", "all", "any", "not", "possible")
            if word in ("all", "any"):
                return {word: [self.guard(depth - 1, passing=passing) for _ in range(2)]}
            return {word: self.guard(depth - 1, passing=passing)}
        if passing and self.passing and self.some(0.5):
            return self.pick(*self.passing)()
        if self.plain and self.some(0.12):
            return {"in": self.pick(*self.plain)}
        return self.base()

    def plain_guard(self) -> Json:
        """A guard in which nothing counts time."""
        while "held" in repr(found := self.guard()) or "elapsed_s" in repr(found):
            pass
        return found

    def do(self, most: int = 1) -> list[Json]:
        return [self.pick(*self.effects)() for _ in range(self.r.randint(0, most))]

    # -- states -------------------------------------------------------------------------------------------------------

    def name(self, *, is_plain: bool = True) -> str:
        name = f"s{len(self.names)}"
        self.names.append(name)
        if is_plain:
            self.plain.append(name)
        return name

    def room(self, depth: int, many: int, *, kinds: tuple[str, ...] = ()) -> Json:
        """States next to each other; each but a final has transitions once all are known."""
        room: Json = {}
        ahead: list[list[str]] = []
        wanted = [*kinds, *(self.pick("wait", *(self.inner if depth else []), *self.inner) for _ in range(many))]
        if not depth:
            flat = ("wait", "tree", "decision", "action", "call", "final")
            wanted = [each if each in flat else "wait" for each in wanted]
        wanted.sort(key=lambda each: each in ("final", "history"))
        for kind in wanted:
            name = self.name(is_plain=kind != "history")
            for later in ahead if kind != "history" else ():
                later.append(name)
            room[name] = getattr(self, f"_state_{kind}")(depth - 1)
            if kind not in ("final", "history"):
                ahead.append([])
                self.dress(room[name], kind, ahead[-1])
        return room

    def dress(self, state: Json, kind: str, later: list[str]) -> None:
        if self.some(0.25) and (found := self.do(2)):
            state["entry"] = found
        if self.some(0.15) and (found := self.do()):
            state["exit"] = found
        if "handover" in self.dimensions and self.some(0.5):
            state |= {"control": self.pick("autonomy", "agent"), "handover_s": self.pick(*SPANS)}
        share = 0.5 if "timers" in self.dimensions else 0.15
        if kind in ("action", "call", "tree", "decision", "remembering", "compound") and self.some(share):
            state["timeout_s"] = self.pick(*SPANS)
        self.done.append((state, kind, later))

    def _state_wait(self, depth: int) -> Json:
        return {}

    def _state_final(self, depth: int) -> Json:
        found: Json = {"final": self.pick("succeeded", "failed", "aborted")}
        if self.some(0.4):
            found["requires"] = self.plain_guard()
            if self.some(0.5):
                found["settle_s"] = self.pick(0.0, *SPANS)
        return found

    def _state_history(self, depth: int) -> Json:
        return {"history": self.pick("shallow", "deep")}

    def _state_compound(self, depth: int) -> Json:
        states = self.room(max(depth, 0), self.r.randint(1, 2), kinds=("final",) if self.some(0.6) else ())
        return {"initial": next(iter(states)), "states": states}

    def _state_remembering(self, depth: int) -> Json:
        states = self.room(max(depth, 0), self.r.randint(2, 3), kinds=("history",))
        return {"initial": next(iter(states)), "states": states}

    def _state_each(self, depth: int) -> Json:
        return {"each": "items", "as": "item", **self._state_compound(max(depth, 0))}

    def _state_parallel(self, depth: int) -> Json:
        regions: Json = {}
        for _ in range(2):
            name = self.name()
            regions[name] = self._state_compound(0) if self.some(0.6) else self._state_remembering(0)
            if self.some(0.5):
                self.done.append((regions[name], "region", []))
        return {"parallel": regions}

    def _state_action(self, depth: int) -> Json:
        state: Json = {"action": self.pick("drive", "turn")}
        if "got" in self.keys and self.some(0.6):
            state["result"] = {"got": "g"}
        if self.some(0.5):
            state["achieved"] = self.plain_guard()
            if self.some(0.5):
                state["settle_s"] = self.pick(*SPANS)
        return state

    def _state_call(self, depth: int) -> Json:
        return {"call": "horn", **({"result": {"got": "g"}} if "got" in self.keys and self.some(0.5) else {})}

    def asked(self) -> Json:
        options: Json = {name: {"about": name} for name in self.r.sample(OPTIONS, self.r.randint(2, 3))}
        first, *rest = options
        for name in rest:
            if self.some(0.6):
                options[name]["when"] = self.plain_guard()
            if "given" in self.keys and self.some(0.6):
                kind = self.keys["given"]["type"]
                schema: Json = {"type": kind}
                if kind == "string" and self.some(0.5):
                    schema["enum"] = self.r.sample(["x", "y", "z"], 2)
                if kind == "integer" and self.some(0.5):
                    schema |= {"minimum": 0, "maximum": self.pick(1, 2)}
                must = {"required": ["given"]} if self.some(0.5) else {}
                options[name]["parameters"] = {"type": "object", "properties": {"given": schema}, **must}
        until = {"deadline_s": self.pick(*SPANS, 4.0)} if self.some(0.7) else {}
        return {
            "question": "What now?", "options": options, "fallback": first,
            "ask": self.pick(["agent"], ["agent", "rules"]),
            "attempts": self.r.randint(1, 2), **until,
            **({"within_s": self.pick(*SPANS)} if self.some(0.2) else {}),
        }  # fmt: skip

    def _state_decision(self, depth: int) -> Json:
        return {"decision": self.asked()}

    def _state_tree(self, depth: int) -> Json:
        return {"tree": self.node(self.pick(1, 2, 2))}

    def node(self, depth: int) -> Json:
        r = self.r
        leaves: list[Callable[[], Json]] = [
            lambda: {"check": self.guard()}, lambda: {"check": self.guard()}, lambda: {"wait_s": self.pick(*SPANS)},
            lambda: {"action": self.pick("drive", "turn"), "timeout_s": self.pick(*SPANS)},
            lambda: {"call": "horn", "timeout_s": self.pick(*SPANS)},
            *([self.setting] if any("set" in each() for each in self.effects for _ in "ab") else []),
        ]  # fmt: skip
        if not depth or self.some(0.15):
            return self.pick(*leaves)()
        sub = lambda: self.node(depth - 1)  # noqa: E731
        paced = lambda: {"sequence": [{"wait_s": self.pick(*SPANS)}, sub()]}  # noqa: E731
        inner: list[Callable[[], Json]] = [
            lambda: {"sequence": [sub() for _ in range(r.randint(2, 3))], "memory": self.some(0.6)},
            lambda: {"selector": [sub() for _ in range(r.randint(2, 3))], "memory": self.some(0.6)},
            lambda: {"parallel": [sub(), sub()],
                     **self.pick({}, {"policy": "success_on_one"}, {"policy": [0]}, {"synchronise": False})},
            lambda: {"retry": self.pick(2, 3), "child": sub()}, lambda: {"repeat": self.pick(2, 3), "child": sub()},
            lambda: {"repeat": -1, "child": paced()}, lambda: {"timeout": self.pick(*SPANS), "child": sub()},
            lambda: {"inverter": sub()}, lambda: {"eternal_guard": self.guard(), "child": sub()},
            lambda: {self.pick("success_is_running", "failure_is_running"): sub()},
            lambda: {self.pick("running_is_failure", "running_is_success", "success_is_failure",
                               "failure_is_success"): sub()},
            lambda: {"condition": self.pick("success", "failure"), "child": sub()},
            lambda: {"one_shot": sub(), "policy": self.pick("on_completion", "on_successful_completion")},
        ]  # fmt: skip
        if "decisions" in self.dimensions:
            inner.append(self._then)
        return self.pick(*inner)()

    def setting(self) -> Json:
        """A leaf that writes."""
        while "set" not in (found := self.pick(*self.effects)()):
            pass
        return found

    def _then(self) -> Json:
        asked = self.asked()
        return {"decision": asked, "then": {name: self.node(0) for name in asked["options"] if self.some(0.6)}}

    # -- transitions --------------------------------------------------------------------------------------------------

    def transition(self, trigger: Json, targets: list[str], share: float = 0.4) -> Json:
        made = dict(trigger)
        if self.some(share) and "when" not in made:
            made["when"] = self.guard(passing="on" in trigger)
        if targets and self.some(0.85):
            made["to"] = self.pick(*targets)
        found = self.do(2) if self.some(0.5) else []
        if "k" in self.keys and "on" in trigger and trigger["on"] in ("a", "b", "c", "d") and self.some(0.4):
            found.append({"set": "k", "from": "event.k"})
        if "quoted" in self.dimensions and trigger.get("on") in ("a", "b", "c", "d") and self.some(0.3):
            found.append({"set": "w", "from": "event.w"})
        if "replies" in self.dimensions and "kept" in self.keys and "on" in trigger and self.some(0.2):
            found.append({"set": "kept", "from": self.pick("event.g", "answer.given")})
        if found or "to" not in made:
            made["do"] = found or [{"log": "stays"}]
        return made

    def transitions(self, kind: str, state: Json, later: list[str]) -> list[Json]:
        names = [*self.names, "over", "done"]
        heads = [name for name, each in self.tops.items() if {"action", "call", "tree"} & each.keys()]
        made = [self.transition({"on": self.pick("a", "b", "a", "b", "*")}, names) for _ in range(self.r.randint(0, 2))]
        made += [self.transition({"on": each}, names, 0.2) for each in self.outside if self.some(0.15)]
        if heads and kind in ("compound", "region", "parallel") and self.some(0.2):
            made.append(self.transition({"on": "succeeded", "of": self.pick(*heads)}, names, 0.2))
        if {"timers", "events", "quoted"} & {*self.dimensions}:
            made += [self.transition({"on": self.pick("c", "d")}, names) for _ in range(self.r.randint(0, 2))]
        if self.some(0.6 if "timers" in self.dimensions or "ages" in self.dimensions else 0.15):
            made += [self.transition({"after_s": self.pick(0.0, *SPANS)}, later or names)]
        if later and self.some(0.45):
            made.append({**self.transition({"when": self.guard()}, later), "to": self.pick(*later)})
        for option in state.get("decision", {}).get("options", ()):
            made.append(self.transition({"on": option}, names, 0.15))
        if kind in ("action", "call", "tree", "compound", "parallel", "each", "remembering", "region"):
            made.append(self.transition({"on": "succeeded"}, later or names, 0.2))
            if self.some(0.8):
                made.append({"on": self.pick(FAILED, FAILED[:1], FAILED[2:]), "to": self.pick(*names)})
        if "timeout_s" in state:
            made.append({"on": "timed_out", "to": self.pick(*names)})
        self.r.shuffle(made)
        return made

    def document(self) -> Json:
        """The mission."""
        r = self.r
        states = self.room(2 if self.some(0.3) else 1, r.randint(2, 3), kinds=tuple(dict.fromkeys(self.inner)))
        first = next(name for name, state in states.items() if "history" not in state)
        self.tops = dict(_walked(states))
        for state, kind, later in self.done:
            if found := self.transitions(kind, state, later):
                state["transitions"] = found
        done: Json = {"final": "succeeded"}
        if self.some(0.6):
            done["requires"] = self.plain_guard()
        states |= {"over": {"final": "aborted"}, "done": done}
        words: Json = {}
        if self.words.get("invariants") or self.some(0.1):
            words["invariants"] = {"kept": {"possible": self.plain_guard()} if self.some(0.3) else self.plain_guard()}
        if self.some(0.5):
            words["transitions"] = [{"on": "stop", "to": "over"}]
            if self.some(0.4):
                words["transitions"].append({**self.transition({"on": "a"}, self.names), "to": "over"})
        if self.some(0.2):
            words["on_cancel"] = self.pick(*[name for name in states if "history" not in states[name]])
        kinds = {name: kind for name, kind in {"k": "integer", "w": "string"}.items() if name in self.fields}
        fields = {"fields": kinds} if kinds else {}
        return {
            "format": 1, "name": "paired", "version": "1.0.0", "blackboard": self.keys,
            "events": {name: dict(fields) for name in "abcd"} | {"stop": {}}, "initial": first, "states": states,
            "settle_s": r.choice([0.0, 0.5, 2.0]), "cancel_s": 2.0, **words,
        }  # fmt: skip


def _walked(states: Json) -> Iterator[tuple[str, Json]]:
    """Every state, by its name."""
    for name, state in states.items():
        yield name, state
        yield from _walked({**state.get("states", {}), **state.get("parallel", {})})
