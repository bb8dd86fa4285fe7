# SPDX-License-Identifier: Apache-2.0
"""Where a mission may go from some of its states, by its rows alone.

Rule: nothing that can happen is left out. Guards are taken as if they could always hold, so what is not reached here is
not reached in any run; what is reached here may still be impossible.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import NamedTuple

from rai_missions.mission import Mission
from rai_missions.states import Compound, Each, History, State
from rai_missions.states.state import Transition

__all__ = ("Reached", "Roads")


class Reached(NamedTuple):
    """What may be entered, and the rows that lead there."""

    states: frozenset[str] = frozenset()
    rows: frozenset[str] = frozenset()
    """JSON pointers."""


class Roads:
    """A mission's states with their parents and rows."""

    def __init__(self, mission: Mission) -> None:
        self.mission = mission
        self.states: dict[str, State] = {}
        self.rows: dict[str, tuple[tuple[str, Transition], ...]] = {"": _rows("", mission.transitions)}
        self.parents: dict[str, str] = {}
        for place, name, state in mission.walk():
            self.states[name] = state
            self.rows[name] = _rows(place, state.transitions)
            self.parents |= dict.fromkeys(state.children(), name)

    def above(self, name: str) -> Iterator[str]:
        """The states around one, innermost first."""
        while parent := self.parents.get(name, ""):
            yield parent
            name = parent

    def onward(self, targets: Iterable[str]) -> Reached:
        """Everything that may be entered once these have been, themselves included."""
        entered: set[str] = set()
        heard: set[str] = set()
        rows: set[str] = set()
        waiting = list(targets)
        while waiting:
            name = waiting.pop()
            if name in entered or name not in self.states:
                continue
            entered.add(name)
            waiting += self.inside(name)
            chain = (name, *self.above(name))
            for around in (*chain, ""):
                if around in heard:
                    continue
                heard.add(around)
                if around and around != name and self.states[around].word == "parallel":
                    waiting += (region for region in self.states[around].children() if region not in chain)
                for place, row in self.rows[around]:
                    rows.add(place)
                    waiting += row.to
        return Reached(frozenset(entered), frozenset(rows))

    def inside(self, name: str) -> Iterable[str]:
        """What may be entered with a state: what it begins with, its regions, or all that a history remembers."""
        state = self.states[name]
        if isinstance(state, Compound | Each):
            return state.initial
        if isinstance(state, History) and (parent := self.parents.get(name)):
            around = self.states[parent]
            inside = list(around.children())
            return (
                inside if state.history == "shallow" else [each for each in self.states if parent in self.above(each)]
            )
        return state.children()


def _rows(place: str, rows: tuple[Transition, ...]) -> tuple[tuple[str, Transition], ...]:
    return tuple((f"{place}/transitions/{index}", row) for index, row in enumerate(rows))
