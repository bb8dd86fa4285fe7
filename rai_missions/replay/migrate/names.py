# SPDX-License-Identifier: Apache-2.0
"""What everything in a mission is called in another one, and whether it is still written as it was.

Rule: a thing means the same only if it is written the same, with the names of today in it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rai_missions.errors import Fault, pointer, suggestion
from rai_missions.mission.mission import Mission
from rai_missions.mission.renaming import Names, matched, renamed
from rai_missions.replay.migrate.map import Map
from rai_missions.states.state import State

__all__ = ("Naming",)

Place = tuple[str, State]
"""A state, and its JSON pointer."""
WITHOUT = frozenset({"about"})
RULES = frozenset({"transitions", "entry", "exit", "control", "timeout_s", "handover_s"})
"""The words of a state that do not describe what runs in it."""
CHILDREN = frozenset({"states", "parallel", "initial"})


class Naming:
    """The names of two missions, and a map between them.

    Args:
        was: The mission of the run.
        now: The mission in which it is to continue.
        map_: What is called otherwise.
    """

    def __init__(self, was: Mission, now: Mission, map_: Map) -> None:
        self.was, self.now, self.map = was, now, map_
        self.states_then = {name: (place, state) for place, name, state in was.walk()}
        self.states_now = {name: (place, state) for place, name, state in now.walk()}
        self.names = Names.by(states=map_.states, keys=map_.keys, events=map_.events)
        self._controls_then, self._controls_now = _controls(self.states_then), _controls(self.states_now)

    def state(self, name: str) -> str | None:
        """What a state is called now; None if it is no more."""
        found = self.map.states.get(name, name)
        return found if found in self.states_now else None

    def key(self, name: str) -> str | None:
        """What a key is called now; None if it is no more."""
        found = self.map.keys.get(name, name)
        return found if found in self.now.blackboard else None

    def event(self, name: str) -> str | None:
        """What an event is called now; None if it is no more."""
        found = self.map.events.get(name, name)
        return found if found in self.now.events else None

    def faults(self) -> Iterator[Fault]:
        """What the map names and what is not there."""
        was, now, map_ = self.was, self.now, self.map
        for word, kind, names, then, today in (
            ("states", "state", map_.states, self.states_then, self.states_now),
            ("keys", "key", map_.keys, was.blackboard, now.blackboard),
            ("events", "event", map_.events, was.events, now.events),
            ("values", "key", {name: name for name in map_.values}, map_.values, now.blackboard),
        ):
            for old, new in names.items():
                place = pointer((word, old))
                if old not in then:
                    yield Fault(place, f"the mission of the run has no {kind} '{old}'{suggestion(old, then)}")
                if new is not None and new not in today:
                    yield Fault(place, f"the mission now has no {kind} '{new}'{suggestion(new, today)}")

    # -- whether something is as it was -------------------------------------------------------------------------------

    def changed(self, old: str, new: str) -> list[str]:
        """The words of a state that have another meaning now; what is inside it counts by itself."""
        was, now = _words(renamed(self.states_then[old][1], self.names)), _words(self.states_now[new][1])
        return sorted(word for word in was.keys() | now.keys() if was.get(word) != now.get(word))

    def runs_the_same(self, old: str, new: str) -> bool:
        """Whether a state runs what the other ran, under the same control."""
        return self._controls_then[old] == self._controls_now[new] and RULES.issuperset(self.changed(old, new))

    def transitions(self, old: str, new: str) -> dict[str, str]:
        """Place now → place then, of the transitions that two states share; empty names mean the missions."""
        place, before = self.states_then[old] if old else ("", self.was)
        then = {
            f"{place}/transitions/{index}": renamed(transition, self.names).written()
            for index, transition in enumerate(before.transitions)
        }
        return matched(then, self.transitions_now(new), lambda one, other: one == other)

    def invariants(self) -> Iterator[str]:
        """The places of the invariants that are as they were."""
        for name, guard in self.was.invariants.items():
            now = self.now.invariants.get(name)
            if now is not None and renamed(guard, self.names).written() == now.written():
                yield f"/invariants/{name}"

    def transitions_now(self, name: str) -> dict[str, Mapping[str, Any]]:
        """Place → transition as it is written, of a state now, or of the mission."""
        place, after = self.states_now[name] if name else ("", self.now)
        return {f"{place}/transitions/{index}": each.written() for index, each in enumerate(after.transitions)}


def _words(state: State) -> dict[str, Any]:
    left_out = WITHOUT | (CHILDREN if state.children() else frozenset())
    return {"": type(state).__name__} | {word: item for word, item in state.written().items() if word not in left_out}


def _controls(states: Mapping[str, Place]) -> dict[str, str | None]:
    """Who must have control for each state: the innermost decides."""
    by_place: dict[str, str | None] = {"": None}
    for place, state in states.values():  # outer before inner
        by_place[place] = state.control or by_place.get(place.rsplit("/", 2)[0])
    return {name: by_place[place] for name, (place, _) in states.items()}
