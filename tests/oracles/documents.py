# SPDX-License-Identifier: Apache-2.0
"""Generated charts, as JSON has them, of what SCXML and a mission have in common, and scripts of what happens to them.

Rule: every entry, exit and transition logs itself, so that a trace shows each thing done and its order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

from hypothesis import strategies as st

__all__ = ("EVENTS", "Taste", "charts", "lineage", "scripts", "without_transitions")

Json = dict[str, Any]
EVENTS = ("a", "b", "c")
"""From outside."""
INNER = ("x", "y")
"""Raised by the chart."""
KEYS = ("n", "m")


@dataclass(frozen=True)
class Taste:
    """What a generated chart may have."""

    parallel: bool = True
    history: bool = True
    finals: bool = True
    outcomes: bool = False
    """Finals other than `succeeded`."""
    guards: bool = True
    eventless: bool = True
    raising: bool = True
    targetless: bool = True
    internal: bool = True
    several: bool = True
    """Several targets, and initials that are not children."""
    delayed: bool = False
    root_transitions: bool = False
    wildcard: bool = False
    end: bool = True
    """A top-level final."""
    nested_parallel: bool = True
    defaults: bool = False
    """Histories that state where they lead without memory, and some with which their parent begins."""
    depth: int = 3

    def without(self, **words: Any) -> Taste:
        return replace(self, **words)


class _Draft:
    def __init__(self, draw: st.DrawFn, taste: Taste) -> None:
        self.draw, self.taste, self.count = draw, taste, 0
        self.parents: dict[str, str] = {}
        self.states: dict[str, Json] = {}

    def some(self, *, of: int) -> bool:
        """True once in so many times."""
        return self.draw(st.integers(1, of)) == of

    def name(self) -> str:
        self.count += 1
        return f"s{self.count}"

    def kind(self, depth: int, *, region: bool) -> str:
        if depth <= 0 or self.count > 12:
            return "atomic"
        kinds = ["atomic", "compound", "compound"] if region else ["atomic", "atomic", "compound"]
        if self.taste.parallel and (self.taste.nested_parallel or not region):
            kinds.append("parallel")
        return self.draw(st.sampled_from(kinds))

    def state(self, parent: str, depth: int, *, region: bool = False) -> tuple[str, Json]:
        name = self.name()
        self.parents[name] = parent
        state: Json = {"entry": [{"log": f"+{name}"}], "exit": [{"log": f"-{name}"}]}
        kind = self.kind(depth, region=region)
        self.states[name] = state
        if kind == "parallel":
            regions = [self.state(name, depth - 1, region=True) for _ in range(self.draw(st.integers(2, 3)))]
            state["parallel"] = dict(regions)
        elif kind == "compound":
            state["states"] = self.inside(name, depth - 1)
        return name, state

    def inside(self, parent: str, depth: int) -> Json:
        room = dict(self.state(parent, depth) for _ in range(self.draw(st.integers(1, 3))))
        if self.taste.finals and self.some(of=2):
            room.update([self.leaf(parent, "final", self.ending())])
        if self.taste.history and parent and self.some(of=2):
            room.update([self.leaf(parent, "history", self.draw(st.sampled_from(["shallow", "deep"])))])
        names = list(room)
        if self.some(of=3):
            names.reverse()
        return {name: room[name] for name in names}

    def ending(self) -> str:
        return (
            self.draw(st.sampled_from(["succeeded", "failed", "aborted", "canceled"]))
            if self.taste.outcomes
            else "succeeded"
        )

    def leaf(self, parent: str, word: str, value: str) -> tuple[str, Json]:
        name = self.name()
        self.parents[name] = parent
        state: Json = {word: value}
        if word == "final":
            state |= {"entry": [{"log": f"+{name}"}], "exit": [{"log": f"-{name}"}]}
        self.states[name] = state
        return name, state

    # -- where things lead ----------------------------------------------------------------------------------------

    def ancestors(self, name: str) -> list[str]:
        found = []
        while name := self.parents[name]:
            found.append(name)
        return found

    def below(self, name: str) -> list[str]:
        return [each for each in self.states if name in self.ancestors(each)]

    def spread(self, parallel: str) -> list[str]:
        """One state in each of several regions."""
        regions = [each for each in self.states if self.parents[each] == parallel]
        chosen = [self.draw(st.sampled_from([region, *self.below(region)])) for region in regions]
        return chosen if self.some(of=2) else chosen[: max(2, len(chosen) - 1)]

    def targets(self) -> Any:
        parallels = [name for name, state in self.states.items() if "parallel" in state]
        if self.taste.several and parallels and self.some(of=4):
            return self.spread(self.draw(st.sampled_from(parallels)))
        return self.draw(st.sampled_from(list(self.states)))

    def initial(self, name: str, state: Json) -> Any:
        children = [each for each in self.states if self.parents[each] == name and "history" not in self.states[each]]
        waiting = [each for each in children if "final" not in self.states[each]]
        ways_back = [each for each in self.below(name) if self.states[each].keys() >= {"history", "transitions"}]
        if name and ways_back and self.some(of=3):
            return self.draw(st.sampled_from(ways_back))
        if self.taste.several and self.some(of=3):
            inner = self.below(name) if name else list(self.states)
            parallels = [each for each in inner if "parallel" in self.states[each]]
            if parallels and self.some(of=2):
                return self.spread(self.draw(st.sampled_from(parallels)))
            deep = [each for each in inner if not ("history" in self.states[each] and self.parents[each] == name)]
            return self.draw(st.sampled_from(deep))
        return self.draw(st.sampled_from(waiting or children))

    # -- transitions ----------------------------------------------------------------------------------------------

    def guard(self) -> Json:
        key, op = self.draw(st.sampled_from(KEYS)), self.draw(st.sampled_from(["==", "!=", "<", ">="]))
        compare: Json = {"key": key, op: self.draw(st.integers(0, 3))}
        choice = self.draw(st.integers(0, 5))
        if choice == 0:
            return {
                "in": self.draw(
                    st.sampled_from([name for name, state in self.states.items() if "history" not in state])
                )
            }
        if choice == 1:
            return {"not": compare}
        if choice == 2:
            return {"all": [compare, {"key": "n", "<": 3}]}
        return compare

    def effects(self) -> list[Json]:
        known: list[Json] = [{"set": "n", "add": 1}, {"set": "m", "add": 1}, {"set": "n", "value": 0}]
        known += [{"raise": name} for name in INNER] if self.taste.raising else []
        if self.taste.delayed:
            known += [{"raise": "x", "after_s": 1.0, "id": "one"}, {"raise": "a", "after_s": 2.0}, {"drop": "one"}]
            known += [{"raise": "y", "after_s": 1.0, "id": "two"}]
        return self.draw(st.lists(st.sampled_from(known), max_size=2)) if self.some(of=2) else []

    def transition(self, name: str, index: int) -> Json:
        transition: Json = {}
        state = self.states.get(name, {})
        kinds = ["event"] * 6
        kinds += ["eventless"] if self.taste.eventless and name else []
        kinds += ["done", "done"] if name and (state.keys() & {"states", "parallel"}) and self.reports(name) else []
        kinds += ["after"] if self.taste.delayed else []
        kind = self.draw(st.sampled_from(kinds))
        names = [*EVENTS, *(INNER if self.taste.raising else ()), *(["*"] if self.taste.wildcard else [])]
        if kind == "event":
            transition["on"] = self.draw(
                st.one_of(st.sampled_from(names), st.lists(st.sampled_from(names), min_size=1, max_size=2, unique=True))
            )
        elif kind == "done":
            transition["on"] = self.draw(
                st.sampled_from(["failed", "succeeded", "canceled"] if self.taste.outcomes else ["succeeded"])
            )
        elif kind == "after":
            transition["after_s"] = self.draw(st.sampled_from([0.25, 1.25]))
        if kind == "eventless" or (self.taste.guards and self.some(of=3)):
            transition["when"] = self.guard()
        if not (self.taste.targetless and self.some(of=5)) or kind == "eventless":
            transition["to"] = self.targets()
        if self.taste.internal and "states" in state and transition.get("to") and self.some(of=2):
            transition["to"] = self.draw(st.sampled_from(self.below(name)))
            transition["internal"] = True
        transition["do"] = [{"log": f"{name}.{index}"}, *self.effects()]
        if kind == "eventless" and self.some(of=2):
            transition |= {"when": {"key": "n", "<": 3}, "do": [*transition["do"], {"set": "n", "add": 1}]}
        return transition

    def reports(self, name: str) -> bool:
        """Whether SCXML and we agree on when it is done: not for a parallel with a parallel for a region."""
        return not any(self.parents[each] == name and "parallel" in self.states[each] for each in self.states) or (
            "states" in self.states[name]
        )

    def defaults(self) -> None:
        """Where histories lead without memory, reported by every other one."""
        for name, state in self.states.items():
            if "history" in state and self.taste.defaults and self.some(of=2):
                parent = self.parents[name]
                inner = [each for each in self.below(parent) if "history" not in self.states[each]]
                children = [each for each in inner if self.parents[each] == parent]
                to = self.draw(st.sampled_from(children if state["history"] == "shallow" else inner))
                state["transitions"] = [{"to": to}]

    def connect(self) -> None:
        self.defaults()
        for name, state in self.states.items():
            if "states" in state:
                state["initial"] = self.initial(name, state)
            if "history" in state:
                continue
            for word in ("entry", "exit"):
                state[word] += self.effects() if self.some(of=4) else []
            if "final" not in state:
                transitions = [self.transition(name, index) for index in range(self.draw(st.integers(0, 3)))]
                state["transitions"] = transitions


@st.composite
def charts(draw: st.DrawFn, taste: Taste | None = None) -> Json:
    """A chart that passes for a mission; it may run in circles."""
    taste = taste if taste is not None else Taste()
    if draw(st.booleans()):
        off = draw(
            st.lists(
                st.sampled_from(["history", "finals", "guards", "eventless", "raising", "targetless"]), unique=True
            )
        )
        taste = taste.without(**dict.fromkeys(off, False))
    draft = _Draft(draw, taste)
    states = dict(draft.state("", taste.depth) for _ in range(draw(st.integers(2, 3))))
    if taste.end and draw(st.booleans()):
        states.update([draft.leaf("", "final", draft.ending())])
    draft.connect()
    document: Json = {
        "name": "generated",
        "initial": draft.initial("", {}),
        "states": states,
        "events": {name: {} for name in (*EVENTS, *INNER)},
        "blackboard": {key: {"type": "integer", "initial": 0} for key in KEYS},
    }
    if taste.root_transitions and draw(st.booleans()):
        document["transitions"] = [draft.transition("", index) for index in range(draw(st.integers(1, 2)))]
    return document


def scripts(*, timed: bool = False, writes: bool = False) -> st.SearchStrategy[list[tuple[Any, ...]]]:
    """What happens, as (word, name or key and value, seconds since what came before)."""
    waits = st.sampled_from([0.0, 0.5, 1.0, 3.0]) if timed else st.just(0.0)
    kinds: list[st.SearchStrategy[tuple[Any, ...]]] = [st.tuples(st.just("event"), st.sampled_from(EVENTS), waits)]
    if timed:
        kinds.append(st.tuples(st.just("tick"), st.just(""), waits))
    if writes:
        values = st.tuples(st.sampled_from(KEYS), st.integers(0, 4))
        kinds.append(st.tuples(st.just("write"), values, waits))
    return st.lists(st.one_of(kinds), min_size=1, max_size=12)


def lineage(document: Json) -> tuple[dict[str, Json], dict[str, list[str]]]:
    """Every state by its name, and the names of those that it is in, innermost first."""
    states: dict[str, Json] = {}
    above: dict[str, list[str]] = {}

    def gather(inside: Json, outer: list[str]) -> None:
        for name, state in inside.items():
            states[name], above[name] = state, outer
            gather(state.get("states") or state.get("parallel") or {}, [name, *outer])

    gather(document["states"], [])
    return states, above


def without_transitions(document: Json, unwanted: Callable[[str, Json], bool]) -> Json:
    """The chart without the transitions of which `unwanted(source, transition)` is true."""
    for name, state in lineage(document)[0].items():
        if "transitions" in state:
            state["transitions"] = [transition for transition in state["transitions"] if not unwanted(name, transition)]
    return document
