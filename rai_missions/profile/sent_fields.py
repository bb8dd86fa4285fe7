# SPDX-License-Identifier: Apache-2.0
"""Whether what is sent to a robot, and taken from its results, has fields of those names, and values that they take.

Rule: a field is the profile's fault where the profile names it, and where the mission does, the sentence states where.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rai_missions.check.index import MissionIndex, RobotUse
from rai_missions.errors import Fault, pointer
from rai_missions.mission.mission import Mission
from rai_missions.profile.endpoints import listened
from rai_missions.profile.entries import references
from rai_missions.profile.field_values import SentValue, misfit, sent_value
from rai_missions.profile.profile import Place, Robot, service_places
from rai_missions.profile.receivers import SENT_WORDS, receiver_of
from rai_missions.profile.type_fields import FieldsOf, TypePart, lack

__all__ = ("unknown_sent_fields",)


class SentField(NamedTuple):
    """A field that is given to a part of a type, or taken from it."""

    place: Place
    """Where the profile's author mends it."""
    type: str
    part: TypePart
    path: str
    by: str = ""
    """What the mission does with it, and where; empty where the profile names it."""
    value: SentValue | None = None
    """What it is given; None for a field that is taken."""


def unknown_sent_fields(mission: Mission | None, robot: Robot, fields_of: FieldsOf) -> tuple[Fault, ...]:
    """The fields of goals, requests, messages and results that their types have not; arguments as `unknown_fields`."""
    uses = [*_of_profile(robot), *(_of_mission(mission, robot) if mission is not None else ())]
    known = {each: fields_of(*each) for each in dict.fromkeys((use.type, use.part) for use in uses if use.type)}
    faults: dict[Fault, None] = {}
    for use in uses:
        fields = known.get((use.type, use.part))
        if fields is not None and (why := lack(fields, use.path) or _misfit(fields, use)):
            faults[Fault(pointer(list(use.place)), f"{use.by}{_words(use)} {why}")] = None
    return tuple(faults)


def _misfit(fields: Mapping[str, Any], use: SentField) -> str:
    return misfit(fields, use.path, use.value) if use.value is not None else ""


def _words(use: SentField) -> str:
    part = {"srv": "the reply"}.get(use.part, f"the {use.part}")
    return f"a {use.type}" if use.part == "msg" else f"{part} of a {use.type}"


def _of_profile(robot: Robot) -> Iterator[SentField]:
    for name, action in robot.actions.items():
        yield from _given(("actions", name, "goal"), action.type, "goal", action.goal)
        for word, path in action.result.items():
            yield SentField(("actions", name, "result", word), action.type, "result", path)
    for place, service in service_places(robot):
        yield from _given((*place, "request"), service.type, "request", service.request)
    for name, topic in robot.topics.items():
        yield from _given(("topics", name, "message"), topic.type, "msg", topic.message)
    for place, source in listened(None, robot):
        yield from _given((*place, "request"), source.type, "request", source.request)


def _given(place: Place, type_name: str, part: TypePart, template: Mapping[str, Any]) -> Iterator[SentField]:
    for where, item in _given_fields(template):
        yield SentField((*place, *where), type_name, part, ".".join(where), value=sent_value(item, {}))


def _given_fields(template: Mapping[str, Any]) -> Iterator[tuple[Place, Any]]:
    """The fields of a message that a template gives a value, each with what is written for it."""
    for name, item in template.items():
        if isinstance(item, Mapping) and item and "from" not in item and not any(word.startswith("$") for word in item):
            yield from (((name, *rest), inner) for rest, inner in _given_fields(item))
        else:
            yield (name,), item


def _of_mission(mission: Mission, robot: Robot) -> Iterator[SentField]:
    """What the mission gives, where the profile passes it on as it is, and the fields that it takes."""
    for use in MissionIndex(mission).uses:
        receiver, word = receiver_of(robot, use), SENT_WORDS[use.sort]
        if receiver is None:
            continue
        part: TypePart = "msg" if receiver.word == "message" else receiver.word
        if not any(True for _ in references(receiver.template)):
            for where, item in _given_fields(getattr(use.user, word, None) or {}):
                by = f"the mission gives it '{'.'.join(where)}' at {use.place}/{word}, and "
                value = sent_value(item, mission.blackboard)
                yield SentField(receiver.place, receiver.type, part, ".".join(where), by, value)
        yield from _taken(use, robot)


def _taken(use: RobotUse, robot: Robot) -> Iterator[SentField]:
    """What the mission takes from the result of a server or the reply of a service."""
    entry: Any = getattr(robot, f"{use.sort}s")[use.name]
    part: TypePart = "result" if use.sort == "action" else "srv"
    if not getattr(entry, "result", None):
        for path in dict(getattr(use.user, "result", None) or {}).values():
            by = f"the mission takes '{path}' at {use.place}/result, and "
            yield SentField((f"{use.sort}s", use.name), entry.type, part, path, by)
