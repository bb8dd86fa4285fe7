# SPDX-License-Identifier: Apache-2.0
"""Random small missions that come round, and random walks in the chart that runs them.

Rule: a mission and a walk are made from a number, so each can be made again.
"""

from __future__ import annotations

import random
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.step import Ask, CallService, CancelGoal, Handover, StartGoal, Step
from rai_missions.event import Event, Tick
from rai_missions.mission.mission import Mission

__all__ = ("Walk", "walkable")

Json = dict[str, Any]
KEYS: Json = {
    "battery": {"type": "number", "source": "robot", "max_age_s": 5},
    "clear": {"type": "boolean", "source": "robot", "max_age_s": 3},
    "n": {"type": "integer", "initial": 0},
    "armed": {"type": "boolean", "initial": False},
}
EVENTS = ("go", "stop")
VALUES: dict[str, list[Any]] = {"battery": [0.05, 0.3, 0.9], "clear": [True, False]}
SPANS = (1, 2, 3, 5)
FAILED = ["failed", "timed_out", "rejected", "unverified"]
SILENT = 600
"""So many instants of silence, and a mission that has not come to rest goes round."""
LONG = 200
"""Microsteps of a step after which a walk goes no further: a circle takes ten thousand at an instant, each time."""


class Drawn:
    """A mission drawn from a random generator."""

    def __init__(self, seed: int) -> None:
        self.r = random.Random(seed)
        self.names = [f"s{number}" for number in range(self.r.randint(1, 4))]

    def guard(self) -> Json:
        r = self.r
        guards: list[Json] = [
            {"key": "battery", r.choice(["<", ">="]): 0.2}, {"key": "clear", "==": r.random() < 0.5},
            {"key": "n", r.choice(["<", ">=", "=="]): r.randint(0, 3)}, {"key": "armed", "==": r.random() < 0.5},
            {"fresh": r.choice(["battery", "clear"])}, {"not": {"fresh": r.choice(["battery", "clear"])}},
            {"in": r.choice(self.names)}, {"elapsed_s": r.choice(SPANS)},
            {"held": {"key": "clear", "==": True}, "for_s": 2},
        ]  # fmt: skip
        return r.choice(guards)

    def do(self) -> list[Json]:
        r = self.r
        known: list[Json] = [
            {"set": "n", "add": 1}, {"set": "n", "value": 0}, {"set": "armed", "value": r.random() < 0.5},
            {"publish": "lamp", "message": {}}, {"call": "horn"},
            {"raise": "go", "after_s": r.choice(SPANS), "id": "x"},
        ]  # fmt: skip
        return [r.choice(known)] if r.random() < 0.3 else []

    def target(self) -> str:
        return self.r.choice([*self.names, *self.names, "over", "done"])

    def transition(self, given: Json, *, stays: bool = False) -> Json:
        do = self.do()
        if stays:
            return {**given, "do": do or [{"log": "stays"}]}
        return {**given, "to": self.target(), **({"do": do} if do else {})}

    def transitions(self, ends: list[Json]) -> list[Json]:
        r, transitions = self.r, [self.transition(end) for end in ends]
        seen = {repr(end) for end in ends}
        for _ in range(r.randint(0, 2)):
            kind: Json = r.choice([{"on": "go"}, {"on": "stop"}, {"after_s": r.choice(SPANS)}])
            if repr(kind) in seen or ("after_s" in kind and "after_s" in repr(seen)):
                continue  # `check` refuses a transition that another one hides
            seen.add(repr(kind))
            guarded = {**kind, "when": self.guard()} if r.random() < 0.4 else kind
            transitions.append(self.transition(guarded, stays=r.random() < 0.2))
        if r.random() < 0.2:
            transitions.append({"when": self.guard(), "to": r.choice(["over", "done"])})
        return transitions

    def node(self, depth: int) -> Json:
        r = self.r
        leaves: list[Json] = [
            {"wait_s": r.choice(SPANS)}, {"wait_s": r.choice(SPANS)}, {"call": "horn", "timeout_s": r.choice(SPANS)},
            {"action": "lift", "timeout_s": r.choice(SPANS)}, {"check": self.guard()}, {"set": "n", "add": 1},
            {"publish": "lamp", "message": {}},
        ]  # fmt: skip
        if not depth or r.random() < 0.25:
            return r.choice(leaves)
        word = r.choice(["sequence", "sequence", "selector", "parallel", "repeat", "retry", "timeout", "inverter",
                         "failure_is_success", "failure_is_running", "forever"])  # fmt: skip
        if word in ("sequence", "selector"):
            return {word: [self.node(depth - 1) for _ in range(r.randint(1, 3))], "memory": r.random() < 0.7}
        if word == "parallel":
            return {word: [self.node(depth - 1) for _ in range(2)]}
        if word in ("repeat", "retry"):
            return {word: r.choice([2, 3, 20]), "child": self.node(depth - 1)}
        if word == "forever":
            return {"repeat": -1, "child": {"sequence": [{"wait_s": r.choice(SPANS)}, self.node(depth - 1)]}}
        return (
            {"timeout": r.choice([2.5, 7.5]), "child": self.node(depth - 1)}
            if word == "timeout"
            else {word: self.node(depth - 1)}
        )

    def state(self, depth: int = 1) -> Json:
        r = self.r
        ends: list[Json] = [{"on": "succeeded"}, {"on": FAILED[:1]}]
        kind = r.choice(["wait", "wait", "tree", "tree", "tree", "call", "action", "decision", "parallel"])
        made: Json = {"entry": entry} if (entry := self.do()) else {}
        if kind == "parallel" and not depth:
            kind = "wait"
        if kind == "wait":
            transitions = self.transitions([r.choice([{"on": "go"}, {"after_s": r.choice(SPANS)}])])
            return {**made, "transitions": transitions}
        if kind == "tree":
            timeout = {"timeout_s": r.choice([4, 9])} if r.random() < 0.3 else {}
            ends += [{"on": "timed_out"}] if timeout else []
            return {**made, "tree": self.node(3), **timeout, "transitions": self.transitions(ends)}
        if kind == "call":
            return {**made, "call": "horn", "timeout_s": r.choice(SPANS), "transitions": self.transitions(
                [{"on": "succeeded"}, {"on": FAILED[:3]}])}  # fmt: skip
        if kind == "action":
            return {**made, "action": r.choice(["lift", "drive"]), "timeout_s": r.choice(SPANS),
                    "transitions": self.transitions([{"on": "succeeded"}, {"on": FAILED[:3]}])}  # fmt: skip
        if kind == "decision":
            asked = {"question": "What now?", "options": {"one": {}, "two": {}}, "ask": ["agent"],
                     "deadline_s": r.choice(SPANS), "fallback": "one"}  # fmt: skip
            return {**made, "decision": asked, "transitions": self.transitions([{"on": "one"}, {"on": "two"}])}
        regions = {}
        for number in range(2):
            name = f"r{number}{len(self.names)}{r.randint(0, 10**6)}"
            inner = [f"{name}a", f"{name}b"]
            regions[name] = {
                "initial": inner[0],
                "states": {
                    each: {"transitions": [{**r.choice([{"on": "go"}, {"after_s": r.choice(SPANS)}]), "to": other}]}
                    for each, other in zip(inner, reversed(inner), strict=True)
                },
            }
        return {**made, "parallel": regions, "transitions": self.transitions([{"on": "stop"}])}

    def mission(self) -> Json:
        r = self.r
        states = {name: self.state() for name in self.names}
        words: Json = {}
        if r.random() < 0.5:
            there: Json = {"all": [{"in": r.choice(self.names)}, {"key": r.choice(["clear", "armed"]), "==": True}]}
            words["invariants"] = {"few": r.choice([{"key": "n", "<": r.randint(1, 4)}, {"not": there}])}
        if r.random() < 0.5:
            words["transitions"] = [{"on": "stop", "to": "over"}]
        done: Json = {"final": "succeeded", "requires": {"key": "clear", "==": True}}
        states |= {"over": {"final": "aborted"}, "done": done}
        events = self.reach(states)
        return {
            "format": 1,
            "name": "walk",
            "version": "1.0.0",
            "blackboard": KEYS,
            "events": {event: {} for event in (*EVENTS, *events)},
            "initial": self.names[0],
            "states": states,
            **words,
        }

    def reach(self, states: Json) -> list[str]:
        """Have every state be entered from one before it, by an event of its own where nothing leads there."""
        events = []
        for number, name in enumerate(list(states)[1:], 1):
            earlier = [state for each, state in list(states.items())[:number] if "final" not in state]
            if not any(transition.get("to") == name for state in earlier for transition in state["transitions"]):
                event = f"to_{name}"
                self.r.choice(earlier)["transitions"].append({"on": event, "to": name})
                events.append(event)
        return events


def walkable(seed: int) -> Json:
    """A small mission that can come round."""
    return Drawn(seed).mission()


class Walk:
    """A run of the chart in which anything happens, then silence.

    Args:
        mission: The mission.
        seed: Of what happens.
        chart: The chart, if not one of a robot of which nothing is known.
    """

    def __init__(self, mission: Mission, seed: int, chart: Chart | None = None) -> None:
        self.mission, self.r = mission, random.Random(seed)
        self.chart = chart if chart is not None else Chart(mission)
        self.goals: dict[int, bool] = {}
        """Number of a goal that has not ended → whether it was asked to end, or is as soon as it is accepted."""
        self.calls: list[int] = []
        self.questions: list[int] = []
        self.wanted: list[str] = []
        self.entered: set[str] = set()
        self.is_tired = False
        """A step was so long that the walk ends there."""
        self.broken: dict[str, str] = {}
        """Claim → how it was seen broken."""

    def take(self, step: Step) -> None:
        for effect in step.effects:
            is_open = isinstance(effect, CancelGoal) and effect.number in self.goals
            if isinstance(effect, StartGoal) or is_open:
                self.goals[effect.number] = True
            elif isinstance(effect, CallService):
                self.calls.append(effect.number)
            elif isinstance(effect, Ask):
                self.questions.append(effect.question.number)
            elif isinstance(effect, Handover):
                self.wanted.append(effect.to)
        self.entered.update(step.entered)
        self.is_tired = self.is_tired or len(step.moves) > LONG
        if self.chart.cause == "cycle":
            self.broken["comes to rest"] = step.why
        if step.resting and step.wake_at != step.at:
            self.broken["comes to rest"] = f"{step.resting} rest at a limit"
        if self.chart.cause == "invariant" and self.chart.paused_at is None:
            self.broken.setdefault("invariants", step.why)

    def go(self, many: int) -> None:
        """So many things happen."""
        chart, r = self.chart, self.r
        for key, values in VALUES.items():
            if r.random() < 0.7:
                chart.write(key, r.choice(values), 0.0)
        self.take(chart.start(0.0))
        for _ in range(many):
            if chart.outcome is not None or self.is_tired:
                return
            at = chart.at + r.choice([0.0, 0.0, 0.5, 1.0, 2.0, 6.0])
            if r.random() < 0.3 and chart.wake_at is not None:
                at = chart.wake_at
            self.take(chart.send(self.event(max(at, chart.at))))

    def event(self, at: float) -> Event:
        r, kinds = self.r, ["event", "write", "write", "tick"]
        kinds += ["goal"] * 2 if self.goals else []
        kinds += ["call"] * 2 if self.calls else []
        kinds += ["answer"] * 2 if self.questions else []
        kind = r.choice(kinds)
        if kind == "event":
            return Event(r.choice(sorted(self.mission.events)), at)
        if kind == "write":
            key = r.choice(sorted(VALUES))
            return Event(key, at, {"value": r.choice(VALUES[key])}, "write")
        if kind == "goal":
            number = r.choice(sorted(self.goals))
            if r.random() < 0.4:
                self.goals[number] = False
                return Event("accepted", at, {}, "accepted", number)
            self.goals.pop(number)
            return Event(r.choice(["succeeded", "failed", "canceled", "rejected"]), at, {}, "result", number)
        if kind == "call":
            number = self.calls.pop(r.randrange(len(self.calls)))
            return Event(r.choice(["succeeded", "failed", "timed_out", "unavailable"]), at, {}, "result", number)
        if kind == "answer":
            return Event("agent", at, {"option": r.choice(["one", "two", "three"])}, "proposal", self.questions[-1])
        return Tick(at)

    def be_silent(self) -> None:
        """No one reports anything any more."""
        chart = self.chart
        for _ in range(SILENT):
            if chart.outcome is not None or chart.wake_at is None or self.is_tired:
                return
            self.take(chart.send(Tick(chart.wake_at)))
        self.broken.setdefault("comes to rest", f"{SILENT} instants, and no rest in {sorted(chart.active)}")

    def order(self, command: str, many: int) -> None:
        """A cancel, or an e-stop, and so many instants."""
        chart = self.chart
        if chart.outcome is not None or self.is_tired:
            return
        self.take(chart.send(Event(command, chart.at, {"by": "operator"}, "command")))
        for _ in range(many):
            if chart.outcome is None and chart.wake_at is not None and not self.is_tired:
                self.take(chart.send(Tick(chart.wake_at)))
        if self.is_tired:
            return
        if chart.outcome is None:
            self.broken["stop" if command == "kill" else command] = f"still in {sorted(chart.active)}"
        elif unreported := [number for number, is_reported in self.goals.items() if not is_reported]:
            self.broken["stopped"] = f"goals {unreported} were never ended"
