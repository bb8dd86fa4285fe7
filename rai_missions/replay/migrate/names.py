# SPDX-License-Identifier: Apache-2.0
"""What everything in a mission is called in another one, and whether it is still written as it was.

Rule: a thing means the same only if it is written the same, with the names of today in it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

from rai_missions.errors import Fault, suggestion
from rai_missions.mission.mission import Mission
from rai_missions.mission.renaming import Names, renamed
from rai_missions.replay.migrate.map import Map
from rai_missions.states.state import State

__all__ = ("Naming", "TransitionName")

TransitionName = tuple[str, Mapping[str, Any]]
"""JSON pointer of a row, and the row as it is written, with the names of today in it."""
WITHOUT = frozenset({"about"})
RULES = frozenset({"transitions", "entry", "exit", "control", "timeout_s", "handover_s"})
"""The words of a state that do not say what runs in it."""
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
        words = {*was.events}
        self._names = Names(
            state=_by(map_.states), key=_by(map_.keys), event=_by(map_.events), timer=lambda name: name,
            trigger=lambda on: tuple(_by(map_.events)(name) if name in words else name for name in on),
        )  # fmt: skip

    def state(self, name: str) -> str | None:
        """What a state is called now; None if it is no more."""
        found = self.map.states.get(name, name)
        return found if found in self.states_now else None

    def key(self, name: str) -> str | None:
        found = self.map.keys.get(name, name)
        return found if found in self.now.blackboard else None

    def event(self, name: str) -> str | None:
        found = self.map.events.get(name, name)
        return found if found in self.now.events else None

    def path(self, path: str) -> str:
        """A key or a field of one, under today's name."""
        head, dot, rest = path.partition(".")
        return _by(self.map.keys)(head) + dot + rest

    def faults(self) -> Iterator[Fault]:
        """What the map names and what is not there."""
        sides = (
            ("states", "state", self.map.states, self.states_then, self.states_now),
            ("keys", "key", self.map.keys, self.was.blackboard, self.now.blackboard),
            ("events", "event", self.map.events, self.was.events, self.now.events),
        )
        for word, kind, given, then, now in sides:
            for old, new in given.items():
                if old not in then:
                    sentence = f"the mission of the run has no {kind} '{old}'{suggestion(old, then)}"
                    yield Fault(f"/{word}/{_escaped(old)}", sentence)
                if new is not None and new not in now:
                    sentence = f"the mission now has no {kind} '{new}'{suggestion(new, now)}"
                    yield Fault(f"/{word}/{_escaped(old)}", sentence)
        for name in self.map.values:
            if name not in self.now.blackboard:
                yield Fault(
                    f"/values/{_escaped(name)}",
                    f"the mission now has no key '{name}'{suggestion(name, self.now.blackboard)}",
                )

    # -- whether something is as it was -------------------------------------------------------------------------------

    def changed(self, old: str, new: str) -> list[str]:
        """The words of a state that say something else now; what is inside it counts by itself."""
        was, now = self._then(old), _words(self.states_now[new][1])
        return sorted(word for word in was.keys() | now.keys() if was.get(word) != now.get(word))

    def runs_the_same(self, old: str, new: str) -> bool:
        """Whether a state runs what the other ran, under the same control."""
        if _controls(self.states_then)[old] != _controls(self.states_now)[new]:
            return False
        was, now = self._then(old), _words(self.states_now[new][1])
        return {word: item for word, item in was.items() if word not in RULES} == {
            word: item for word, item in now.items() if word not in RULES
        }

    def transitions(self, old: str, new: str) -> Iterator[tuple[str, str]]:
        """The places of the rows that two states have in common: then, and now. Empty names stand for the missions."""
        left = list(self.transitions_now(new))
        for place, transition in self._transitions_then(old):
            match = next((each for each in left if each[1] == transition), None)
            if match is not None:
                left.remove(match)
                yield place, match[0]

    def transitions_now(self, name: str) -> Iterator[TransitionName]:
        place, transitions = self.states_now[name] if name else ("", self.now)
        for index, transition in enumerate(transitions.transitions):
            yield f"{place}/transitions/{index}", transition.written()

    def _transitions_then(self, name: str) -> Iterator[TransitionName]:
        place, transitions = self.states_then[name] if name else ("", self.was)
        for index, transition in enumerate(transitions.transitions):
            yield f"{place}/transitions/{index}", renamed(transition, self._names).written()

    def _then(self, name: str) -> Mapping[str, Any]:
        """A state of then, in today's names."""
        return _words(renamed(self.states_then[name][1], self._names))


def _words(state: State) -> dict[str, Any]:
    inner = CHILDREN if state.children() else frozenset[str]()
    return {"": type(state).__name__} | {
        word: item for word, item in state.written().items() if word not in WITHOUT | inner
    }


def _controls(states: Mapping[str, tuple[str, State]]) -> dict[str, str | None]:
    """Who must have control for each state: the innermost says."""
    by_place: dict[str, str | None] = {"": None}
    found = {}
    for name, (place, state) in states.items():  # outer before inner
        found[name] = by_place[place] = state.control or by_place.get(place.rsplit("/", 2)[0])
    return found


def _by(given: Mapping[str, str | None]) -> Callable[[str], str]:
    return lambda name: given.get(name) or name


def _escaped(name: str) -> str:
    return name.replace("~", "~0").replace("/", "~1")
