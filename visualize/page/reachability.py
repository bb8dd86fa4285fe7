# SPDX-License-Identifier: Apache-2.0
"""Where a mission may go from some of its states, by its transitions alone.

Rule: nothing that can happen is left out. Guards are taken as if they could always hold, so what is not reached here is
not reached in any run; what is reached here may still be impossible.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Iterator
from functools import cached_property
from typing import NamedTuple

from rai_missions.mission.mission import Mission
from rai_missions.states import Compound, Each, Final, History, State
from rai_missions.states.effects import Raise
from rai_missions.states.state import OUTCOMES
from rai_missions.states.transition import Transition
from visualize.build import parents_of

__all__ = ("ReachableParts", "Roads")


class ReachableParts(NamedTuple):
    """What may be entered, and the transitions that lead there."""

    states: frozenset[str] = frozenset()
    transitions: frozenset[str] = frozenset()
    """JSON pointers."""


class Roads:
    """A mission's states with their parents and transitions."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission
        self.states: dict[str, State] = {}
        self.transitions: dict[str, tuple[tuple[str, Transition], ...]] = {"": _transitions("", mission.transitions)}
        self.parents = {name: around for name, around in parents_of(mission).items() if around}
        for place, name, state in mission.walk():
            self.states.setdefault(name, state)
            self.transitions.setdefault(name, _transitions(place, state.transitions))
        self.finals = {name: state for name, state in mission.states.items() if isinstance(state, Final)}
        """The states that end the mission."""

    def above(self, name: str) -> Iterator[str]:
        """The states around one, innermost first."""
        while parent := self.parents.get(name, ""):
            yield parent
            name = parent

    def onward(self, targets: Iterable[str]) -> ReachableParts:
        """Everything that may be entered once these have been, themselves included.

        Args:
            targets: Entered from no one knows where: the regions next to them may be anywhere they ever come to.
        """
        given = tuple(targets)
        entered, received, transitions = set[str](), set[str](), set[str]()
        waiting = [*given, *(door for name in given for door in self._neighbours(name))]
        while waiting:
            name = waiting.pop()
            if name in entered or name not in self.states:
                continue
            entered.add(name)
            waiting += self._with({name, *self.above(name)}, self.inside(name))
            for around in self.waiting_in(name):
                if around in received:
                    continue
                received.add(around)
                for place, transition in self.transitions[around]:
                    transitions.add(place)
                    waiting += self._with(set(self.above(around)), transition.to)
        return ReachableParts(frozenset(entered), frozenset(transitions))

    def waiting_in(self, name: str) -> tuple[str, ...]:
        """Whose transitions may fire while a state is active, the mission's own (`""`) last; none where it ends."""
        return () if name in self.finals else (name, *self.above(name), "")

    def at_once(self, targets: Iterable[str]) -> frozenset[str]:
        """What may be entered in the same breath, themselves included: nothing is received, finished or waited for."""
        found: set[str] = set()
        waiting = list(targets)
        while waiting:
            name = waiting.pop()
            if name in found or name not in self.states:
                continue
            found.add(name)
            waiting += self.inside(name)
            received = self._raised | self._ends_at_once(name)
            for around in self.waiting_in(name):
                transitions = (
                    transition
                    for _, transition in self.transitions[around]
                    if transition.eventless or not received.isdisjoint(transition.on)
                )
                waiting += (target for transition in transitions for target in transition.to)
        return frozenset(found)

    def _ends_at_once(self, name: str) -> frozenset[str]:
        """The outcomes, of it and of what is around it, that may be there as soon as it is entered."""
        state = self.states[name]
        if isinstance(state, Final):
            return frozenset(OUTCOMES) - (set() if state.final == "succeeded" else {"succeeded"})
        ends = isinstance(state, Each) or (state.activity() and not state.takes_time())
        return frozenset(OUTCOMES if ends else ())

    @cached_property
    def _raised(self) -> frozenset[str]:
        """The events that the mission raises itself, at once."""
        effects = [
            each for transitions in self.transitions.values() for _, transition in transitions for each in transition.do
        ]
        effects += [each for state in self.states.values() for each in (*state.entry, *state.exit)]
        return frozenset(each.event for each in effects if isinstance(each, Raise) and each.after_s is None)

    def inside(self, name: str) -> Iterable[str]:
        """What may be entered with a state, and by nothing else than being there.

        What it begins with, its regions, all that a history remembers, or the next item's start at the end of one.
        """
        state = self.states[name]
        if isinstance(state, Compound | Each):
            return state.initial
        if isinstance(state, Final):
            around = self.states.get(self.parents.get(name, ""))
            return around.initial if isinstance(around, Each) and state.final == "succeeded" else ()
        if isinstance(state, History):
            return self._remembered(name, state)
        return state.children()

    def _remembered(self, name: str, state: History) -> list[str]:
        parent = self.parents.get(name)
        if parent is None:
            return list(self.mission.initial)
        around = self.states[parent]
        first = state.default or (around.initial if isinstance(around, Compound | Each) else ())
        if state.history == "shallow":
            return [*first, *around.children()]
        return [*first, *(each for each in self.states if parent in self.above(each))]

    def _with(self, within: set[str], targets: Iterable[str]) -> Iterator[str]:
        """Targets, and the regions that are entered next to them unless their own is one that is not left."""
        for target in targets:
            yield target
            for region in self._regions(target):
                if region not in within:
                    yield from self._others(region)

    def _neighbours(self, name: str) -> Iterator[str]:
        """Wherever the regions next to a state may have been entered: by default, or by a name from outside."""
        for region in self._regions(name):
            for other in self._others(region):
                yield from (other, *self._doors.get(other, ()))

    def _regions(self, name: str) -> Iterator[str]:
        """The regions of parallel states in which a state lies, or which it is."""
        for around in (name, *self.above(name)):
            if (parent := self.parents.get(around)) and self.states[parent].word == "parallel":
                yield around

    def _others(self, region: str) -> Iterator[str]:
        return (other for other in self.states[self.parents[region]].children() if other != region)

    @cached_property
    def _doors(self) -> dict[str, set[str]]:
        """Region → what inside it is entered by its name from outside."""
        found: dict[str, set[str]] = defaultdict(set)
        names = [("", (*self.mission.initial, *((self.mission.on_cancel,) if self.mission.on_cancel else ())))]
        names += [(name, each.initial) for name, each in self.states.items() if isinstance(each, Compound | Each)]
        names += [
            (name, transition.to) for name, transitions in self.transitions.items() for _, transition in transitions
        ]
        for source, targets in names:
            around = {source, *self.above(source)}
            for target in targets:
                for region in set(self._regions(target)) - around:
                    found[region].add(target)
        return found


def _transitions(place: str, transitions: tuple[Transition, ...]) -> tuple[tuple[str, Transition], ...]:
    return tuple((f"{place}/transitions/{index}", transition) for index, transition in enumerate(transitions))
