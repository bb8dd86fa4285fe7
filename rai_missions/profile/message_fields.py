# SPDX-License-Identifier: Apache-2.0
"""Whether the messages that a profile receives have the fields that it names.

Rule: what a message leaves open is no fault; what its type, or the message itself, has no place for is one.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from difflib import get_close_matches
from typing import Any

from rai_missions.errors import Fault, pointer
from rai_missions.guards.guard import Guard
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import is_number
from rai_missions.profile.convert import at_path
from rai_missions.profile.message_types import Kind, listened
from rai_missions.profile.profile import Robot
from rai_missions.profile.sources import EventSource, Source
from rai_missions.redaction import cut_repr

__all__ = ("FieldsOf", "absent_field", "unknown_fields", "why_unreadable")

MANY = 20
"""The fields of one message."""
DEEPEST = 20
"""How deep a message is looked through for numbers that are not finite."""
FieldsOf = Callable[[str, Kind], Mapping[str, Any] | None]
"""The fields of a type: name → a plain type's name, the fields of a message, or a list of what one item holds; of a
service its reply's. None where the type is not here."""


def unknown_fields(mission: Mission | None, robot: Robot, fields_of: FieldsOf) -> tuple[Fault, ...]:
    """The fields that a profile names and its types have not.

    Args:
        mission: What is to run; without one everything that the profile receives is looked at.
        robot: On which robot.
        fields_of: Reports what a type holds; what it cannot determine is left to the run.
    """
    faults = []
    for sort, name, source in listened(mission, robot):
        fields = fields_of(source.type, "srv" if source.service is not None else "msg") if source.type else None
        for where, path in _paths(source) if fields is not None else ():
            if why := _lack(fields, path):
                faults.append(Fault(pointer([sort, name, *where]), f"{_a(source.type)} {why}"))
    return tuple(faults)


def absent_field(source: Source | EventSource, message: Mapping[str, Any]) -> str:
    """What a source names and a message has no place for, in a sentence; empty if there is nothing."""
    for _, path in _paths(source):
        if why := _lack(message, path):
            return f"{_a(source.type)} {why}"
    return ""


def why_unreadable(source: Source, message: Mapping[str, Any]) -> str:
    """Why a message that a source receives has no value, with what is there: `pose.position.x is nan`."""
    found = _not_finite(at_path(message, source.path), source.path)
    strange = [f"{place or 'it'} is {cut_repr(number, 40)}" for place, number in found]
    if strange:
        return ", ".join(strange[:MANY]) + (", …" if len(strange) > MANY else "")
    return absent_field(source, message) or (f"it leaves '{source.path}' open" if source.path else "it is empty")


def _not_finite(there: Any, place: str, depth: int = 0) -> Iterator[tuple[str, float]]:
    """The numbers that cannot be reckoned with, each with its place."""
    if isinstance(there, int | float) and not is_number(there) and not isinstance(there, bool):
        yield place, there
    elif depth < DEEPEST and isinstance(there, Mapping | list | tuple):
        for name, item in there.items() if isinstance(there, Mapping) else enumerate(there):
            yield from _not_finite(item, f"{place}.{name}" if place else str(name), depth + 1)


def _a(type_name: str) -> str:
    return f"a {type_name}" if type_name else "its message"


def _paths(source: Source | EventSource) -> Iterator[tuple[tuple[str, ...], str]]:
    """Where a path into the message is in a source, and the path."""
    if isinstance(source, Source):
        if source.path:
            yield ("field",), source.path
    elif not source.json_:
        for path in dict.fromkeys(_read_by(source.when)) if source.when is not None else ():
            yield ("when",), path
        for name, path in source.fields.items():
            yield ("fields", name), path


def _read_by(guard: Guard) -> Iterator[str]:
    for each in guard.walk():
        yield from each.paths()


def _lack(there: Any, path: str) -> str:
    """What is not there on the way along a path, in what a type or a message holds; empty if all may be."""
    behind: list[str] = []
    for word in path.split("."):
        inside = f" in '{'.'.join(behind)}'" if behind else ""
        if isinstance(there, Mapping):
            if word not in there:
                return f"has no field '{word}'{inside}{_known(word, there)}"
            there = there[word]
        elif _is_list(there):
            if not word.isdecimal():
                return f"has no field '{word}'{inside}, which is a list; an item is named by its number, counted from 0"
            there = _item(there, int(word))
        elif isinstance(there, str | bool | int | float) and "/" not in str(there):
            return f"has no field '{word}'{inside}, which is one value"
        else:
            return ""
        behind.append(word)
    return ""


def _is_list(there: Any) -> bool:
    """A list, or the name of a type of lists: `sequence<double>`, `double[36]`."""
    if isinstance(there, str):
        return there.startswith("sequence<") or there.endswith("]")
    return isinstance(there, list | tuple)


def _item(there: Any, number: int) -> Any:
    """What an item of a list holds; None where nothing is known of it."""
    if isinstance(there, str) or not there:
        return None
    return there[min(number, len(there) - 1)]


def _known(word: str, there: Mapping[str, Any]) -> str:
    close = get_close_matches(word, there, n=1, cutoff=0.6)
    near = f" (did you mean '{close[0]}'?)" if close else ""
    names = ", ".join(list(there)[:MANY]) + (", …" if len(there) > MANY else "")
    return f"{near}; it has: {names}" if names else f"{near}; it has none"
