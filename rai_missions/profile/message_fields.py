# SPDX-License-Identifier: Apache-2.0
"""Whether messages have the fields that a profile names, and a mission by it.

Rule: what a message leaves open is no fault; what its type, or the message itself, has no place for is one.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from rai_missions.errors import Fault, pointer
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import at_path, is_number, is_numeric
from rai_missions.profile.endpoints import listened
from rai_missions.profile.profile import Robot
from rai_missions.profile.sent_fields import unknown_sent_fields
from rai_missions.profile.sources import EventSource, Source
from rai_missions.profile.type_fields import MANY, FieldsOf, lack
from rai_missions.redaction import cut_repr

__all__ = ("absent_field", "unknown_fields", "why_unreadable")

DEEPEST = 20
"""How deep a message is looked through for numbers that are not finite."""


def unknown_fields(mission: Mission | None, robot: Robot, fields_of: FieldsOf) -> tuple[Fault, ...]:
    """The fields that a profile names and its types have not.

    Args:
        mission: What is to run; without one everything that the profile names is looked at.
        robot: On which robot.
        fields_of: Reports what a type holds; what it cannot determine is left to the run.
    """
    faults = []
    for place, source in listened(mission, robot):
        fields = fields_of(source.type, "srv" if source.service is not None else "msg") if source.type else None
        for where, path in _paths(source) if fields is not None else ():
            if why := lack(fields, path):
                faults.append(Fault(pointer([*place, *where]), f"{_a(source.type)} {why}"))
    return (*faults, *unknown_sent_fields(mission, robot, fields_of))


def absent_field(source: Source | EventSource, message: Mapping[str, Any]) -> str:
    """What a source names and a message has no place for, in a sentence; empty if there is nothing."""
    for _, path in _paths(source):
        if why := lack(message, path):
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
    if is_numeric(there) and not is_number(there):
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
        guards = source.when.walk() if source.when is not None else ()
        for path in dict.fromkeys(path for guard in guards for path in guard.paths()):
            yield ("when",), path
        for name, path in source.fields.items():
            yield ("fields", name), path
