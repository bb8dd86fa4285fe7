# SPDX-License-Identifier: Apache-2.0
"""Which file a place of a mission comes from, where the mission includes others.

Rule: a place is reported in the file that its author opens to mend it.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from rai_missions.errors import pointer, steps_of
from rai_missions.mission.include import read_mission
from rai_missions.mission.mission import Mission
from rai_missions.states import Include

__all__ = ("Origins", "WrittenPlace")

NAMED = ("blackboard", "events", "invariants")


class WrittenPlace(NamedTuple):
    """A place in a file."""

    file: str
    """As the caller would open it."""
    place: str
    """JSON pointer into that file."""


class Origins:
    """Where the places of an expanded mission are written; each file is read once.

    Args:
        file: The file of the outermost mission, which could be loaded.
        mission: The mission as it is written there; read if not given.
    """

    def __init__(self, file: str, mission: Mission | None = None) -> None:
        self._file = file
        self._places: dict[str, tuple[str, Include]] = {}
        """The pointer of each state that is an inclusion → its name, and it."""
        self._names: dict[str, Include] = {}
        self._included: dict[str, Origins] = {}
        if not file.endswith(".json"):
            return
        written = mission if mission is not None else read_mission(Path(file))
        for place, name, state in written.walk():
            if isinstance(state, Include):
                self._places[place], self._names[name] = (name, state), state

    def of(self, place: str) -> WrittenPlace:
        """Where a place is written.

        Args:
            place: JSON pointer into the expanded mission.
        """
        inside = self._inside(steps_of(place)) if self._names else None
        if inside is None:
            return WrittenPlace(self._file, place)
        file, inner = str(Path(self._file).parent / inside.file), inside.place
        if file not in self._included:
            self._included[file] = Origins(file)
        return self._included[file].of(inner)

    def _inside(self, steps: Sequence[str]) -> WrittenPlace | None:
        """The same place in an included mission; None where it is not written there."""
        if len(steps) > 1 and steps[0] in NAMED:
            name = steps[1].partition("/")[0]
            include = self._names.get(name) if name != steps[1] else None
            return None if include is None else _without(name, include, steps)
        for depth in range(2, len(steps) - 1):
            if found := self._places.get(pointer(steps[:depth])):
                name, include = found
                word, rest = steps[depth], steps[depth + 1 :]
                if word == "states":
                    return _without(name, include, (word, *rest))
                number = int(rest[0]) - len(include.transitions) if word == "transitions" else -1
                return _without(name, include, (word, str(number), *rest[1:])) if number >= 0 else None
        return None


def _without(name: str, include: Include, steps: Iterable[str]) -> WrittenPlace:
    """A place in an included mission, whose names have no prefix there."""
    return WrittenPlace(include.mission, pointer([step.removeprefix(f"{name}/") for step in steps]))
