# SPDX-License-Identifier: Apache-2.0
"""Which file a place of a mission comes from, where the mission includes others.

Rule: a place is reported in the file that its author opens to mend it.
"""

from __future__ import annotations

from pathlib import Path
from typing import NamedTuple

from rai_missions.errors import escaped, steps_of
from rai_missions.mission.include import read_mission
from rai_missions.mission.mission import Mission
from rai_missions.states import Include

__all__ = ("WrittenPlace", "origin")

NAMED = ("blackboard", "events", "invariants")


class WrittenPlace(NamedTuple):
    """A place in a file."""

    file: str
    """As the caller would open it."""
    place: str
    """JSON pointer into that file."""


def origin(file: str, place: str, mission: Mission | None = None) -> WrittenPlace:
    """Where a place of an expanded mission is written.

    Args:
        file: The file of the outermost mission, which could be loaded.
        place: JSON pointer into the expanded mission.
        mission: The mission as it is written there; read if not given.
    """
    if not file.endswith(".json"):
        return WrittenPlace(file, place)
    written = mission if mission is not None else read_mission(Path(file))
    for outer, name, state in written.walk():
        if isinstance(state, Include) and (inner := _inside(place, outer, name, state)) is not None:
            return origin(str(Path(file).parent / state.mission), inner)
    return WrittenPlace(file, place)


def _inside(place: str, outer: str, name: str, include: Include) -> str | None:
    """The same place in the included mission; None where it is not written there."""
    words = steps_of(place)
    if place.startswith(f"{outer}/states/"):
        inner = words[outer.count("/") :]
    elif place.startswith(f"{outer}/transitions/"):
        depth = outer.count("/")
        number = int(words[depth + 1]) - len(include.transitions)
        if number < 0:
            return None
        inner = ("transitions", str(number), *words[depth + 2 :])
    elif len(words) > 1 and words[0] in NAMED and words[1].startswith(f"{name}/"):
        inner = words
    else:
        return None
    return "".join(f"/{escaped(word.removeprefix(f'{name}/'))}" for word in inner)
