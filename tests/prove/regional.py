# SPDX-License-Identifier: Apache-2.0
"""Random small missions with regions side by side, which share little, much or nothing.

Rule: a mission is made from a number, so each can be made again.
"""

from __future__ import annotations

import random
from typing import Any

from rai_missions.engine.robot_facts import RobotFacts

__all__ = ("FACTS", "regional")

Json = dict[str, Any]
KEYS: Json = {
    "battery": {"type": "number", "source": "robot", "max_age_s": 5},
    "clear": {"type": "boolean", "source": "robot", "max_age_s": 3},
    "docked": {"type": "boolean", "source": "robot"},
    "where": {"type": "string", "source": "argument"},
    "n": {"type": "integer", "initial": 0},
    "m": {"type": "integer", "initial": 0},
    "armed": {"type": "boolean", "initial": False},
    "mark": {"type": "string", "initial": "none"},
}
ACTIONS = ("lift", "drive", "look")
FACTS = RobotFacts(
    uses={"lift": frozenset(["arm"]), "drive": frozenset(["wheels"]), "look": frozenset(["camera"])},
    keep=frozenset(["look"]),
)
FAILED = ["failed", "timed_out", "rejected", "unverified"]


class Regional:
    """A mission drawn from a random generator.

    Args:
        seed: The seed of the generator.
        apart: Its regions share little or nothing, nothing takes time, and an event ends it.
    """

    def __init__(self, seed: int, *, apart: bool = False) -> None:
        self.r, self.apart = random.Random(seed), apart
        r = self.r
        self.many = r.choice([2, 2, 2, 3])
        self.states = [
            [f"r{region}{letter}" for letter in "abc"[: r.choice([2, 3, 3] if apart else [1, 2, 2, 3])]]
            for region in range(self.many)
        ]
        self.sharing = r.random() * r.random()
        """How likely it is that a region looks at what is another's."""
        self.busy = r.choice([0.0, 0.0, 0.2, 0.4])
        """How likely it is that a state runs something."""
        self.facts = r.choice([0.0, 0.0, 0.3])
        """How likely it is that a guard looks at the robot's keys."""
        if apart:
            self.busy = self.facts = 0.0
        self.keys: list[list[str]] = [[] for _ in range(self.many)]
        for key in ("battery", "clear", "docked", "where"):
            self.keys[r.randrange(self.many)].append(key)

    def other(self, region: int) -> int:
        """The region, or another."""
        if self.apart and self.r.random() < 0.997:
            return region
        return self.r.randrange(self.many) if self.r.random() < self.sharing else region

    def guard(self, region: int) -> Json:
        r = self.r
        own: list[Json] = [
            {"key": "n", r.choice(["<", ">=", "=="]): r.randint(0, 2)}, {"key": "armed", "==": r.random() < 0.5},
            {"key": "m", "<": r.randint(1, 2)}, {"key": "mark", "==": r.choice(["none", "some"])},
        ]  # fmt: skip
        facts: dict[str, Json] = {
            "battery": {"key": "battery", r.choice(["<", ">="]): 0.2},
            "clear": {"key": "clear", "==": r.random() < 0.5},
            "docked": {"key": "docked", "==": True}, "where": {"key": "where", "==": "home"},
        }  # fmt: skip
        known = self.keys[self.other(region)]
        if known and r.random() < self.facts:
            key = r.choice(known)
            fresh: Json = {"fresh": key}
            found = facts[key] if r.random() < 0.7 or key == "where" else r.choice([fresh, {"not": fresh}])
        elif self.apart:
            found = r.choice([own[0], {"in": r.choice(self.states[self.other(region)])}])
        elif r.random() < 0.2:
            found = r.choice([{"elapsed_s": r.choice([1, 3])}, {"in": r.choice(self.states[self.other(region)])}])
        else:
            found = r.choice(own)
        if r.random() < 0.15:
            return r.choice([{"all": [found, r.choice(own)]}, {"any": [found, r.choice(own)]}, {"not": found}])
        if r.random() < 0.08 and not self.apart:
            return {"held": found, "for_s": 2}
        return found

    def do(self, region: int, likely: float = 0.3) -> list[Json]:
        r = self.r
        known: list[Json] = [
            {"set": "n", "add": 1}, {"set": "n", "value": 0}, {"set": "armed", "value": r.random() < 0.5},
            {"set": "m", "add": r.choice([1, -1])}, {"set": "mark", "value": r.choice(["none", "some"])},
            {"publish": "lamp", "message": {}}, {"call": "horn"}, {"raise": f"e{self.other(region)}"},
            {"raise": f"e{self.other(region)}", "after_s": 2, "id": "x"}, {"drop": "x"}, {"set": "m", "from": "n"},
        ]  # fmt: skip
        return [r.choice(known)] if r.random() < (0.003 if self.apart else likely) else []

    def transition(self, region: int, given: Json) -> Json:
        r, do = self.r, self.do(region)
        if r.random() < 0.1:
            return {**given, "do": do or [{"log": "stays"}]}
        names = self.states[region if r.random() < 0.97 else self.other(region)]
        target = (
            r.choice([*names, *names, *names, f"r{region}end"]) if r.random() < 0.95 else r.choice(["over", "after"])
        )
        return {**given, "to": target, **({"do": do} if do else {})}

    def transitions(self, region: int, ends: list[Json]) -> list[Json]:
        r, found = self.r, [self.transition(region, end) for end in ends]
        seen = {repr(end) for end in ends}
        for _ in range(3 if self.apart else r.randint(1, 2)):
            event = r.choice([f"e{region}", f"f{region}", f"e{self.other(region)}", "all"])
            kind: Json = r.choice([{"on": event}, {"on": event}, {"on": event}, {"after_s": r.choice([1, 2])}])
            if self.apart:
                kind = {"on": r.choice([f"e{region}", f"f{region}"])}
            if repr(kind) in seen or ("after_s" in kind and "after_s" in repr(seen)):
                continue
            seen.add(repr(kind))
            guarded = {**kind, "when": self.guard(region)} if r.random() < (0.15 if self.apart else 0.4) else kind
            found.append(self.transition(region, guarded))
        if r.random() < 0.15:
            found.append(self.transition(region, {"when": self.guard(region)}))
        return found

    def tree(self, region: int, depth: int) -> Json:
        r = self.r
        leaves: list[Json] = [
            {"wait_s": r.choice([1, 2])}, {"action": r.choice(ACTIONS), "timeout_s": 4}, {"check": self.guard(region)},
            {"set": "n", "add": 1}, {"call": "horn", "timeout_s": 2},
        ]  # fmt: skip
        if not depth or r.random() < 0.3:
            return r.choice(leaves)
        word = r.choice(["sequence", "selector", "parallel", "retry", "inverter"])
        if word in ("sequence", "selector"):
            return {word: [self.tree(region, depth - 1) for _ in range(2)], "memory": r.random() < 0.7}
        if word == "parallel":
            return {word: [self.tree(region, depth - 1) for _ in range(2)]}
        return (
            {"retry": 2, "child": self.tree(region, depth - 1)}
            if word == "retry"
            else {word: self.tree(region, depth - 1)}
        )

    def state(self, region: int, depth: int = 1) -> Json:
        r = self.r
        made: Json = {}
        if entry := self.do(region, 0.2):
            made["entry"] = entry
        if exits := self.do(region, 0.1):
            made["exit"] = exits
        ends: list[Json] = [{"on": "succeeded"}, {"on": FAILED[:3]}]
        if r.random() >= self.busy:
            if depth and r.random() < 0.05:
                name = f"r{region}in{r.randint(0, 10**6)}"
                regions = {
                    f"{name}{side}": {
                        "initial": f"{name}{side}a",
                        "states": {
                            f"{name}{side}a": {"transitions": [{"on": f"e{region}", "to": f"{name}{side}b"}]},
                            f"{name}{side}b": {"final": "succeeded"},
                        },
                    }
                    for side in "xy"
                }
                return {**made, "parallel": regions, "transitions": self.transitions(region, [{"on": "succeeded"}])}
            return {**made, "transitions": self.transitions(region, [])}
        kind = r.choice(["tree", "call", "action", "action", "decision"])
        if kind == "tree":
            return {
                **made,
                "tree": self.tree(region, 2),
                "transitions": self.transitions(region, [{"on": "succeeded"}, {"on": "failed"}]),
            }
        if kind == "call":
            return {**made, "call": "horn", "timeout_s": 2, "transitions": self.transitions(region, ends)}
        if kind == "action":
            action = r.choice(ACTIONS) if r.random() < self.sharing else ACTIONS[region]
            achieved = {"achieved": self.guard(region)} if r.random() < 0.2 else {}
            return {
                **made,
                "action": action,
                "timeout_s": 3,
                **achieved,
                "transitions": self.transitions(region, [*ends, *([{"on": "unverified"}] if achieved else [])]),
            }
        asked = {"question": "What now?", "options": {f"one{region}": {}, f"two{region}": {"when": self.guard(region)}},
                 "ask": ["agent"], "deadline_s": 3, "fallback": f"one{region}"}  # fmt: skip
        return {
            **made,
            "decision": asked,
            "transitions": self.transitions(region, [{"on": f"one{region}"}, {"on": f"two{region}"}]),
        }

    def mission(self) -> Json:
        r = self.r
        regions: Json = {}
        for region, names in enumerate(self.states):
            states = {name: self.state(region) for name in names}
            final: Json = {"final": r.choice(["succeeded", "succeeded", "failed"])}
            if r.random() < 0.2:
                final["requires"] = self.guard(region)
            states[f"r{region}end"] = final
            regions[f"r{region}"] = {"initial": names[0], "states": states}
        outer = [{"on": "succeeded", "to": r.choice(["over", "done", "after"])}, {"on": "failed", "to": "over"}]
        for _ in range(0 if self.apart else r.randint(0, 2)):
            kind: Json = r.choice([{"on": "stop"}, {"on": "all"}, {"after_s": 9}, {"on": "stop"}])
            if any(each.get("on") == kind.get("on", "") or ("after_s" in kind and "after_s" in each) for each in outer):
                continue
            guarded = {**kind, "when": self.guard(r.randrange(self.many))} if r.random() < 0.4 else kind
            do = self.do(0, 0.4)
            outer.append(
                {**guarded, "to": r.choice(["over", "after", "work"])}
                if r.random() < 0.7 or not do
                else {**guarded, "do": do}
            )
        if self.apart:
            outer.append({"on": "all", "to": r.choice(["after", "work", "over"])})
        if r.random() < 0.1 and not self.apart:
            outer.append({"when": self.guard(r.randrange(self.many)), "to": "over"})
        work: Json = {"parallel": regions, "transitions": outer}
        if exits := self.do(0, 0.2):
            work["exit"] = exits
        after: Json = {"transitions": [{"on": "stop", "to": r.choice(["over", "done"])}, {"on": "all", "to": "work"}]}
        words: Json = {}
        if r.random() < (0.05 if self.apart else 0.4):
            names = [r.choice(self.states[region]) for region in range(2)]
            words["invariants"] = {
                "few": r.choice(
                    [
                        {"key": "n", "<": r.randint(1, 4)},
                        {"not": {"all": [{"in": each} for each in names]}},
                        {"any": [{"not": {"in": names[0]}}, {"key": "armed", "==": False}]},
                    ]
                )
            }
        if r.random() < 0.5 or self.apart:
            words["transitions"] = [{"on": "stop", "to": "over"}]
        if r.random() < 0.2:
            words["on_cancel"] = "after"
        robots = [] if self.apart else [{"key": "clear", "==": True}]
        done: Json = {"final": "succeeded", "requires": r.choice([*robots, {"key": "n", ">": 0}])}
        keys = {name: key for name, key in KEYS.items() if not self.apart or key.get("source") != "robot"}
        events = [*(f"{letter}{region}" for region in range(self.many) for letter in "ef"), "stop", "all"]
        return {
            "format": 1,
            "name": "regional",
            "version": "1.0.0",
            "blackboard": keys,
            "events": {event: {} for event in events},
            "initial": "work",
            "states": {"work": work, "after": after, "over": {"final": "aborted"}, "done": done},
            **words,
        }


def regional(seed: int, *, apart: bool = False) -> Json:
    """A small mission with regions, which may share little or nothing."""
    return Regional(seed, apart=apart).mission()
