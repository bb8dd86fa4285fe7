# SPDX-License-Identifier: Apache-2.0
"""Which file a place of a mission comes from, where the mission includes others.

Rule: a place is reported in the file that its author opens to mend it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from pathlib import Path, PurePath
from typing import Any, NamedTuple

from rai_missions.errors import MissionError, pointer, steps_of
from rai_missions.mission.json_reader import read_json
from rai_missions.mission.mission import Mission
from rai_missions.states import Compound, Include

__all__ = ("Origins", "WrittenPlace", "as_written")

NAMED = ("blackboard", "events", "invariants")


JUNCTIONS = ("all", "any")


class WrittenPlace(NamedTuple):
    """A place in a file."""

    file: str
    """As the caller would open it."""
    place: str
    """JSON pointer into that file."""


class Origins:
    """Where the places of an expanded mission are written.

    Args:
        file: The file of the outermost mission; empty where it has none.
        mission: What it was expanded to.
    """

    def __init__(self, file: str, mission: Mission) -> None:
        self._file = file
        self._names: dict[str, Include] = {}
        """The name of each state that was an inclusion → how that is written."""
        self._places: dict[str, str] = {}
        """Its pointer → its name."""
        self._documents: dict[str, Any] = {}
        for place, name, state in mission.walk():
            if isinstance(state, Compound) and state.included_by is not None:
                self._names[name], self._places[place] = state.included_by, name

    def of(self, place: str) -> WrittenPlace:
        """Where a place is written.

        Args:
            place: JSON pointer into the expanded mission.
        """
        steps = steps_of(place)
        name, inside = self._named(steps) if steps[:1] and steps[0] in NAMED else self._stated(steps)
        file = self._file_of(name) if name else self._file
        inside = tuple(step.removeprefix(f"{name}/") for step in inside) if name else inside
        if file not in self._documents:
            self._documents[file] = _document(file)
        document = self._documents[file]
        return WrittenPlace(file, place if document is None else as_written(document, pointer(inside)))

    def _around(self, name: str) -> str:
        """The innermost inclusion that brought a name; empty where it is the mission's own."""
        while name := name.rpartition("/")[0]:
            if name in self._names:
                break
        return name

    def _chain(self, name: str) -> Iterator[str]:
        """An inclusion and those around it, innermost first."""
        while name:
            yield name
            name = self._around(name)

    def _file_of(self, name: str) -> str:
        """The file that an inclusion names; each names one relative to its own."""
        file = PurePath(self._file)
        for each in reversed(tuple(self._chain(name))):
            file = file.parent / self._names[each].mission
        return str(file)

    def _named(self, steps: tuple[str, ...]) -> tuple[str, tuple[str, ...]]:
        """The inclusion that brought a key, an event or an invariant, and the steps to a place in it there."""
        name = self._around(steps[1]) if len(steps) > 1 else ""
        if name and steps[0] == "invariants" and steps[2:3] == ("any",):
            number = int(steps[3]) - sum(1 for each in self._chain(name))  # each asks first whether it is active
            return name, (*steps[:3], str(number), *steps[4:])
        return name, steps

    def _stated(self, steps: tuple[str, ...]) -> tuple[str, tuple[str, ...]]:
        """The innermost inclusion in whose file a place is, and the steps to it there."""
        found, inside = "", steps
        for depth in range(2, len(steps)):
            name = self._places.get(pointer(steps[:depth]))
            if name is None:
                continue
            if steps[depth] in ("initial", "states"):
                found, inside = name, steps[depth:]
            elif steps[depth] == "transitions" and steps[depth + 1 :]:
                number = int(steps[depth + 1]) - len(self._names[name].transitions)
                if number >= 0:
                    found, inside = name, ("transitions", str(number), *steps[depth + 2 :])
        return found, inside


def _document(file: str) -> Any:
    """What is written in a file; None where it is no JSON that can be read."""
    try:
        return read_json(Path(file)) if file.endswith(".json") else None
    except MissionError:
        return None


def as_written(document: Any, place: str) -> str:
    """The pointer to a place of a mission in the document that it was read from.

    A junction there may be nested in one of its kind, which are one in the mission; and where the document has another
    guard, an inclusion has joined that with more. A junction has a list; a state or a key of its name has an object.
    """
    here, found, rest = document, tuple[str, ...](), steps_of(place)
    while rest:
        step, *_ = rest
        if step in JUNCTIONS and rest[1:2] and isinstance(here, Mapping) and isinstance(here.get(step, []), list):
            parts = tuple(_parts(here.get(step), step))
            if parts and int(rest[1]) >= len(parts):
                return pointer(found)  # what an inclusion has joined it with
            path, here = parts[int(rest[1])] if parts else ((), here)
            found, rest = (*found, *path), rest[2:]
            continue
        here = _item(here, step)
        if here is None:
            break
        found, rest = (*found, step), rest[1:]
    return pointer((*found, *rest))


def _item(here: Any, step: str) -> Any:
    if isinstance(here, Mapping):
        return here.get(step)
    return here[int(step)] if isinstance(here, list) and step.isdecimal() and int(step) < len(here) else None


def _parts(junction: Any, word: str) -> Iterator[tuple[tuple[str, ...], Any]]:
    """The guards that a junction has in a mission, each with the steps to it and as it is written."""
    for number, part in enumerate(junction if isinstance(junction, list) else ()):
        if isinstance(part, Mapping) and set(part) == {word} and isinstance(part[word], list):
            yield from (((word, str(number), *steps), inner) for steps, inner in _parts(part[word], word))
        else:
            yield (word, str(number)), part
