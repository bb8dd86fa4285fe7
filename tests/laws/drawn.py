# SPDX-License-Identifier: Apache-2.0
"""Whole missions and what happens to them, drawn from a number: every kind of guard, state, effect and event.

Rule: all times are multiples of `GRID_S`, so that anyone who looks at each of them misses no instant.
"""

from __future__ import annotations

import random
from typing import Any, NamedTuple

from pydantic import TypeAdapter

from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.guards import Guard
from rai_missions.model import AnyOf
from tests.laws.linked import link
from tests.rigs.charts import Drawn
from tests.strategies import SIGHTS

__all__ = ("EVENTS", "GRID_S", "KEYS", "REQUESTS", "DrawnEvent", "document", "happenings", "is_far", "robot_facts")

Json = dict[str, Any]
GRID_S = 0.25
KEYS: Json = {
    "n": {"type": "integer", "initial": 0}, "m": {"type": "integer", "initial": 1},
    "flag": {"type": "boolean", "initial": False}, "item": {"type": "string", "initial": ""},
    "stops": {"type": "list", "source": "argument", "initial": ["a", "b"]},
    "home": {"type": "pose", "source": "argument", "initial": {"x": 0.0, "y": 0.0}},
    "given": {"type": "integer", "source": "answer", "initial": 0},
    "fact": {"type": "integer", "source": "robot", "max_age_s": 1.0, "optional": True},
    "clear": {"type": "boolean", "source": "robot", "max_age_s": 2.0, "optional": True},
    "count": {"type": "integer", "source": "robot", "optional": True},
    "pose": {"type": "pose", "source": "robot", "max_age_s": 1.5, "optional": True},
    "request": {"type": "string", "source": "argument", "initial": "put the red cube on the blue cube"},
    "objects": {"type": "object", "source": "robot", "max_age_s": 1.5, "optional": True},
    "reading": {"type": "object"}, "plan": {"type": "object"},
}  # fmt: skip
EVENTS = ("a", "b", "c")
SPANS = (0.25, 0.5, 1.0, 1.0, 1.5, 3.0)
"""Durations, short enough that several end within a script."""
OPTIONS = ("left", "right", "wait_here")
REQUESTS = (
    *("put the red cube on the blue cube",) * 4, *("swap the two cubes",) * 2,
    "put the red cube on the blue or the green one", "put the cube on the cube",
    "the second", "the red one", "stack the cubes", "smash the red cube", "what is that",
    "stell den roten Würfel auf den blauen", "put the green cube on the red one", "",
)  # fmt: skip
"""Requests that are clear, unclear, answers to what was asked, refused, impossible, and in another language."""
SEEN: Json = {"type": "object", "source": "robot", "max_age_s": 6.0, "optional": True}
"""What is seen, where requests are read: it is known for longer."""
GOALS: list[Json] = [
    {"goal": "reading.goal", "over": "objects"}, {"goal": "reading.goal", "over": "objects", "is": "feasible"},
    {"goal": "reading.goal", "is": "said", "in": "request"},
]  # fmt: skip
GUARD: TypeAdapter[Guard] = TypeAdapter(AnyOf[Guard])
RESULTS = ("succeeded", "succeeded", "failed", "canceled", "rejected")


def is_far(known: Json, margin: int) -> bool | None:
    """A predicate of the user's program, pure."""
    return None if "fact" not in known else bool(known["fact"] > margin)


class _Draft:
    """One mission as it is drawn."""

    def __init__(self, rng: random.Random, *, alone: bool, wishes: bool = False, trees: bool = False) -> None:
        self.rng, self.alone, self.wishes, self.trees = rng, alone, wishes, trees
        self.count = 0
        self.names: list[str] = []
        """States that a transition may name."""
        self.plain: list[str] = []
        """States that a guard may ask for."""
        self.done: list[tuple[Json, str, list[str]]] = []
        """States whose transitions are still to be drawn, with the word of their kind and their later siblings."""
        self.busy = rng.random() < 0.5
        """Every entry writes a key."""
        self.lean = rng.random() < 0.5
        """Mostly states that wait, so that time and facts alone move it."""

    def some(self, share: float) -> bool:
        return self.rng.random() < share

    def name(self, word: str) -> str:
        self.count += 1
        return f"{word}{self.count}"

    # -- guards -------------------------------------------------------------------------------------------------------

    def guard(self, depth: int = 2, *, held: bool = True, passing: str = "") -> Json:
        kinds = ["compare"] * (20 if self.lean else 4) + ["fresh", "near", "in", "in", "elapsed", "named", "goal"]
        if depth:
            kinds += ["held", "all", "any", "not", "possible"] if held else ["all", "any", "not", "possible"]
        kind = self.rng.choice(kinds)
        if kind in ("all", "any"):
            return {kind: [self.guard(depth - 1, held=held, passing=passing) for _ in range(self.rng.randint(1, 3))]}
        if kind in ("not", "possible"):
            return {kind: self.guard(depth - 1, held=held, passing=passing)}
        if kind == "held":
            return {"held": self.guard(depth - 1, held=False), "for_s": self.rng.choice(SPANS)}
        return self.plain_guard(kind, passing)

    def plain_guard(self, kind: str, passing: str) -> Json:
        rng = self.rng
        if kind == "fresh":
            return {"fresh": rng.choice(["fact", "clear", "pose"])}
        if kind == "near":
            return {"near": ["pose", "home"], "within_m": 0.5}
        if kind == "in" and self.plain:
            return {"in": rng.choice(self.plain)}
        if kind == "elapsed":
            return {"elapsed_s": rng.choice(SPANS)}
        if kind == "goal":
            return rng.choice(GOALS)
        if kind == "named":
            return {"named": "is_far", "with": {"margin": rng.choice([1, {"from": "m"}])}}
        if passing and self.some(0.3):
            return {"key": passing, ">=": 1}
        return rng.choice(
            [
                {
                    "key": rng.choice(["n", "m", "count", "given"]),
                    rng.choice(["==", "<", ">=", "!="]): rng.randint(0, 3),
                },
                {"key": rng.choice(["flag", "clear"]), "==": self.some(0.5)},
                {"key": "fact", rng.choice(["<", ">="]): rng.randint(0, 3)},
                {"key": "n", rng.choice(["<", ">="]): {"key": rng.choice(["m", "fact", "count"])}},
                {"key": "item", "in": ["a", "c"]},
            ]
        )

    # -- effects ------------------------------------------------------------------------------------------------------

    def effects(self, most: int = 2) -> list[Json]:
        rng = self.rng
        known: list[Json] = [
            {"set": "n", "add": 1}, {"set": "m", "add": 1}, {"set": "n", "value": 0}, {"set": "flag", "value": True},
            {"set": "flag", "value": False}, {"set": "m", "from": "fact"}, {"set": "n", "from": "count"},
            {"raise": "x"}, {"raise": "x", "data": {"k": {"from": "n"}}},
            {"raise": "y", "after_s": rng.choice(SPANS), "id": "one"}, {"drop": "one"},
            {"raise": "a", "after_s": rng.choice(SPANS), "id": "two"}, {"call": "horn"}, {"drop": "two"},
            {"raise": "c", "after_s": rng.choice(SPANS)}, {"set": "flag", "from": "clear"}, {"set": "n", "from": "m"},
            {"publish": "lamp", "message": {"n": {"from": "n"}}}, {"log": "noted"},
        ]  # fmt: skip
        if self.wishes:
            known += [{"set": "request", "value": rng.choice(REQUESTS)}] * len(known)
        known = [each for each in known if not (self.alone and each.keys() & {"call", "publish"})]
        return [rng.choice(known) for _ in range(rng.randint(0, most))]

    # -- states -------------------------------------------------------------------------------------------------------

    def room(self, depth: int, *, top: bool = False) -> Json:
        rng = self.rng
        kinds = ["wait"] if self.lean else ["wait", "wait", "decision", "tree", "read", "plan"]
        kinds += ["action", "call"] if not (self.lean or self.alone) else []
        kinds += ["read", "read", "plan"] * 3 * self.wishes + ["tree"] * 12 * self.trees
        chosen = [
            rng.choice(kinds + (["compound", "parallel", "each"] if depth else []))
            for _ in range(rng.randint(1 + self.lean, 3 + self.lean))
        ]
        if self.some((0.1 if self.lean else 0.4) if top else 0.6):
            chosen.append("final")
        if not top and self.some(0.3):
            chosen.append("history")
        room: Json = {}
        ahead: list[list[str]] = []
        for kind in chosen:
            name = self.name("s")
            if kind != "history":
                for later in ahead:
                    later.append(name)
            self.names.append(name)
            if kind != "history":
                self.plain.append(name)
            room[name] = getattr(self, f"_{kind}")(depth - 1)
            if kind not in ("final", "history"):
                ahead.append([])
                self.dress(room[name], kind, ahead[-1])
        return room

    def dress(self, state: Json, kind: str, later: list[str]) -> None:
        rng = self.rng
        if self.busy:
            state["entry"] = [{"set": "n", "add": 1}, *self.effects(1)]
        elif self.some(0.3):
            state["entry"] = self.effects()
        if self.some(0.2):
            state["exit"] = self.effects(1)
        if not self.alone and self.some(0.15):
            state |= {"control": rng.choice(["autonomy", "agent"]), "handover_s": rng.choice(SPANS)}
        lasting = ("action", "call", "tree", "decision", "compound", "wait")
        if (kind in lasting or self.wishes) and self.some(0.4):
            state["timeout_s"] = rng.choice([1.0, 2.0, 4.0])
        self.done.append((state, kind, later))

    def _wait(self, depth: int) -> Json:
        return {}

    def _action(self, depth: int) -> Json:
        state: Json = {"action": self.rng.choice(["drive", "turn", "composed"]), "cancel_s": self.rng.choice(SPANS)}
        if self.some(0.6):
            state["achieved"] = self.guard(held=False)
        if self.some(0.5):
            state["settle_s"] = self.rng.choice(SPANS)
        if self.some(0.4):
            state["result"] = {"m": "n"}
        if self.some(0.3):
            state["over_orphan"] = True
        if self.some(0.3):
            state["goal"] = {"n": {"from": self.rng.choice(["n", "fact"])}}
        return state

    def _call(self, depth: int) -> Json:
        return {"call": "horn", **({"result": {"m": "n"}} if self.some(0.4) else {})}

    def asked(self) -> Json:
        options: Json = {name: {"about": name} for name in self.rng.sample(OPTIONS, self.rng.randint(2, 3))}
        first, *rest = options
        for name in rest:
            if self.some(0.6):
                options[name]["when"] = self.guard(held=False)
            elif self.some(0.4):
                options[name]["parameters"] = {"type": "object", "properties": {"given": {"type": "integer"}}}
        return {
            "question": "What now?", "options": options, "fallback": first, "ask": ["agent", "rules"],
            "attempts": self.rng.randint(1, 2), "deadline_s": self.rng.choice([1.0, 2.0, 6.0]),
            **({"within_s": self.rng.choice(SPANS)} if self.some(0.4) else {}),
        }  # fmt: skip

    def _read(self, depth: int) -> Json:
        return {"read": "request", "over": "objects", "into": "reading"}

    def _plan(self, depth: int) -> Json:
        asked = {"asked": "request"} if self.wishes and self.some(0.5) else {}
        return {"plan": "reading.goal", "over": "objects", "into": "plan", **asked}

    def _decision(self, depth: int) -> Json:
        return {"decision": self.asked()}

    def node(self, depth: int) -> Json:
        rng = self.rng
        leaves = ["check", "check", "wait_s", "set", "decision"]
        leaves += ["publish", "call", "action"] if not self.alone else []
        inner = ["sequence", "selector", "memoryless", "parallel", "inverter", "eternal_guard", "timeout", "retry"]
        word = rng.choice(leaves + inner * 2 if depth else leaves)
        if depth and self.some(0.3):
            return self.decorated(depth)
        if word in ("sequence", "selector", "parallel"):
            return {word: [self.node(depth - 1) for _ in range(rng.randint(1, 3))]}
        if word == "memoryless":
            return {"sequence": [{"check": self.guard()}, self.node(depth - 1)], "memory": False}
        if word == "eternal_guard":
            return {"eternal_guard": self.guard(), "child": self.node(depth - 1)}
        if word == "inverter":
            return {word: self.node(depth - 1)}
        if word in ("timeout", "retry"):
            return {word: 2 if word == "retry" else rng.choice([1.0, 2.0]), "child": self.node(depth - 1)}
        return self.leaf(word)

    def decorated(self, depth: int) -> Json:
        """A node of a kind that goes round, that makes another status of one, or that asks what is to be done."""
        rng, child = self.rng, self.node(depth - 1)
        waits: Json = {"sequence": [{"wait_s": rng.choice(SPANS)}, child]}
        asked = self.asked()
        return rng.choice(
            [
                {"repeat": 2, "child": child},
                {"repeat": -1, "child": waits},
                {rng.choice(["success_is_running", "failure_is_running"]): rng.choice([child, waits])},
                {rng.choice(["running_is_failure", "success_is_failure", "failure_is_success"]): child},
                {"condition": rng.choice(["success", "failure"]), "child": child},
                {"one_shot": child, "policy": rng.choice(["on_completion", "on_successful_completion"])},
                {"status_to_blackboard": "item", "child": child},
                {
                    "parallel": [child, self.node(depth - 1)],
                    "policy": rng.choice(["success_on_one", [0], [1]]),
                    "synchronise": self.some(0.5),
                },
                {"selector": [child, self.node(depth - 1)], "memory": True},
                {"set": rng.choice(["m", "n"]), "from": rng.choice(["count", "fact", "n", "m"])},
                {
                    "decision": asked,
                    "then": {name: self.node(depth - 1) for name in asked["options"] if self.some(0.7)},
                },
            ]
        )

    def leaf(self, word: str) -> Json:
        if word == "check":
            return {"check": self.guard()}
        if word == "decision":
            return {"decision": self.asked()}
        if word == "action":
            return {"action": self.rng.choice(["drive", "turn", "composed"]), "timeout_s": self.rng.choice([1.0, 2.0])}
        given: dict[str, Json] = {
            "wait_s": {"wait_s": self.rng.choice(SPANS)}, "set": {"set": "m", "add": 1},
            "publish": {"publish": "lamp", "message": {"on": True}}, "call": {"call": "horn", "timeout_s": 1.0},
        }  # fmt: skip
        return given[word]

    def _tree(self, depth: int) -> Json:
        return {"tree": self.node(2)}

    def _compound(self, depth: int) -> Json:
        states = self.room(depth)
        return {"initial": self.first(states), "states": states}

    def first(self, states: Json) -> str:
        return next(name for name, state in states.items() if "history" not in state)

    def _each(self, depth: int) -> Json:
        return {"each": "stops", "as": "item", **self._compound(depth)}

    def _parallel(self, depth: int) -> Json:
        regions: Json = {}
        for _ in range(2):
            name = self.name("s")
            self.names.append(name)
            self.plain.append(name)
            regions[name] = self._compound(depth)
            if self.some(0.5):
                self.done.append((regions[name], "region", []))
        if self.some(0.4):
            name, kind = self.name("s"), self.rng.choice(["wait", "final", "decision", "tree", "each"])
            self.names.append(name)
            self.plain.append(name)
            regions[name] = getattr(self, f"_{kind}")(depth)
            if kind != "final":
                self.dress(regions[name], kind, [])
        return {"parallel": regions}

    def _final(self, depth: int) -> Json:
        requires: Json = {"requires": self.guard(held=False)} if self.some(0.4) else {}
        if requires and self.some(0.4):
            requires["settle_s"] = self.rng.choice([0.0, 0.5, 3.0])
        return {"final": self.rng.choice(["succeeded", "succeeded", "failed", "aborted", "canceled"]), **requires}

    def _history(self, depth: int) -> Json:
        return {"history": self.rng.choice(["shallow", "deep"])}

    # -- transitions --------------------------------------------------------------------------------------------------

    def transition(self, trigger: Json, later: list[str], *, at_once: bool = False) -> Json:
        """One transition; one that may fire without anything from outside mostly leads forward."""
        transition = dict(trigger)
        if "when" not in transition and self.some(0.4):
            transition["when"] = self.guard(passing="event.k" if "on" in transition else "")
        if at_once and not self.some(0.03):
            if later:
                transition["to"] = self.rng.choice(later)
        elif self.some(0.9) or "on" not in transition:
            transition["to"] = self.rng.choice(self.names)
        if self.some(0.4) or "to" not in transition:
            transition["do"] = self.effects(2 if "to" in transition and not at_once else 1) or [{"log": "stays"}]
        return transition

    def transitions(self, kind: str, state: Json, later: list[str]) -> list[Json]:
        rng = self.rng
        transitions = [self.transition({"on": rng.choice([*EVENTS, "*"])}, later) for _ in range(rng.randint(0, 2))]
        if self.some(0.3):
            transitions.append(self.transition({"on": rng.choice(["x", "y"])}, later, at_once=True))
        if self.some(0.6 if self.lean else 0.3):
            transitions.append(self.transition({"after_s": rng.choice(SPANS)}, later))
        if later and self.some(0.9 if self.lean else 0.6):
            transitions.append(self.transition({"when": self.guard()}, later, at_once=True))
        for option in state.get("decision", {}).get("options", ()):
            transitions.append(self.transition({"on": option}, later, at_once=True))
        if kind in ("action", "call", "tree", "compound", "parallel", "each", "read", "plan"):
            transitions.append(self.transition({"on": "succeeded"}, later, at_once=True))
            bad = ["failed", "rejected", "unverified", "canceled", "aborted", "unclear", "refused"]
            if self.some(0.9):
                transitions.append({"on": bad, "to": rng.choice(later or self.names)})
        if "timeout_s" in state:
            transitions.append({"on": "timed_out", "to": rng.choice(self.names)})
        rng.shuffle(transitions)
        return transitions


def wished(then: str) -> Json:
    """States in which something is seen, a request is read, and its moves are planned, before what comes then."""
    return {
        "looking": {"transitions": [{"when": {"fresh": "objects"}, "to": "wished"}, {"after_s": 3.0, "to": then}]},
        "wished": {"read": "request", "over": "objects", "into": "reading",
                   "transitions": [{"on": "succeeded", "to": "planned"},
                                   {"on": ["unclear", "refused", "rejected"], "to": then}]},
        "planned": {"plan": "reading.goal", "over": "objects", "into": "plan",
                    "transitions": [{"on": ["succeeded", "failed", "rejected"], "to": then}]},
    }  # fmt: skip


def document(rng: random.Random, *, alone: bool = False, wishes: bool = False, trees: bool = False) -> Json:
    """A mission as JSON has it.

    Args:
        rng: What it follows from.
        alone: It needs no robot, so that nothing comes back of what it does.
        wishes: It mostly reads requests, which change, and plans, once it sees something.
        trees: Most of its states run trees.
    """
    draft = _Draft(rng, alone=alone, wishes=wishes, trees=trees)
    states = draft.room(1 if draft.lean else 2, top=True)
    for state, kind, later in draft.done:
        if transitions := draft.transitions(kind, state, later):
            state["transitions"] = transitions
    keys = KEYS
    if wishes:
        states = {**wished(draft.first(states)), **states}
        keys = KEYS | {"request": {"type": "string", "initial": rng.choice(REQUESTS)}, "objects": SEEN}
    made: Json = {
        "name": "drawn", "blackboard": keys, "events": [*EVENTS, "x", "y"],
        "initial": draft.first(states), "states": states, "settle_s": rng.choice([0.0, 0.5, 3.0]), "cancel_s": 2.0,
    }  # fmt: skip
    if draft.some(0.5):
        made["transitions"] = draft.transitions("", {}, [])
    if draft.some(0.15):
        made["invariants"] = {"always": {"possible": draft.guard()}}
    if draft.some(0.3):
        made["on_cancel"] = rng.choice([name for name in states if "history" not in states[name]])
    link(rng, states)
    return made


def robot_facts(rng: random.Random) -> RobotFacts:
    """What is known of the robot: one action is composed, some exclude each other, some continue during a pause."""
    base, other = frozenset({"base"}), frozenset({"arm"})
    uses = rng.choice([{}, {"drive": base, "turn": base, "composed": other}, {"drive": base, "turn": other}])
    succeeded = GUARD.validate_python({"key": "count", ">=": 2})
    failed = GUARD.validate_python({"all": [{"fresh": "fact"}, {"key": "fact", ">=": 2}]})
    keep = frozenset({"turn"} if rng.random() < 0.5 else ())
    return RobotFacts(uses, keep, {"composed": succeeded}, {"composed": failed})


class DrawnEvent(NamedTuple):
    """One thing that happens, and when."""

    drawn: Drawn
    """As `tests.rigs.charts.ScriptedRobot.event` reads it."""
    at: float


def _values(rng: random.Random, *, wishes: bool) -> tuple[str, Any]:
    names = ["n", "m", "flag", "stops", "fact", "fact", "clear", "clear", "count", "count", "pose", "given", "objects"]
    names += ["objects"] * len(names) * wishes
    key = rng.choice(names)
    made: Json = {
        "flag": rng.random() < 0.5, "clear": rng.random() < 0.6, "stops": rng.choice([[], ["c"], ["a", "b"]]),
        "pose": {"x": rng.choice([0.1, 3.0]), "y": 0.0}, "objects": rng.choice(SIGHTS),
    }  # fmt: skip
    return key, made.get(key, rng.randint(0, 3))


def happenings(rng: random.Random, *, commands: bool = True, wishes: bool = False) -> list[DrawnEvent]:
    """What happens, in order of time; for a mission with `wishes` the robot often reports what it sees."""
    script, at, mostly_facts = [], 0.0, rng.random() < 0.5
    for _ in range(rng.randint(1, 14)):
        at += rng.choice([0.0, 0.25, 0.5, 1.0, 1.25, 2.0, 4.0])
        kind = rng.choice(
            ["event"] * 4
            + ["write"] * 8
            + ["accepted"] * 2
            + ["result"] * 3
            + ["proposal"] * 2
            + ["control", "doubt"]
            + (["command", "command"] if commands else [])
            + ["write"] * 40 * mostly_facts
        )
        words: tuple[Any, ...] = (rng.randint(0, 1),)
        if kind == "event":
            words = (rng.choice(EVENTS), rng.randint(0, 2))
        elif kind == "write":
            words = (*_values(rng, wishes=wishes), rng.choice([0.0, 0.0, 0.0, -0.25, -0.5, -1.0, 1.0]))
        elif kind == "result":
            words = (rng.randint(0, 1), rng.choice(RESULTS), rng.randint(0, 3))
        elif kind == "proposal":
            words = (rng.randint(0, 1), rng.choice(OPTIONS), rng.randint(0, 3))
        elif kind == "control":
            words = (rng.choice(["autonomy", "agent", "operator"]),)
            if rng.random() < 0.5:
                words = (rng.choice(["autonomy", "agent", "operator", "operator", "nobody"]), "operator")
        elif kind == "command":
            words = (rng.choice(["pause", "pause", "stop", "resume", "resume", "resume", "cancel"]),)
        script.append(DrawnEvent((kind, *words), at))
    return script
