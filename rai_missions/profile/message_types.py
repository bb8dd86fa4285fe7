# SPDX-License-Identifier: Apache-2.0
"""Which types of messages a mission meets on a robot: one that is missing is reported before anything moves."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from rai_missions.check.index import MissionIndex
from rai_missions.connectors.connector import TypeKind
from rai_missions.errors import Fault, pointer
from rai_missions.mission.mission import Mission
from rai_missions.profile.profile import Place, Robot, service_places
from rai_missions.profile.sources import EventSource, Source

__all__ = ("TypeUse", "lacking", "listened", "typed")


class TypeUse(NamedTuple):
    """A type that a profile names, and where."""

    place: str
    kind: TypeKind
    type: str


def typed(mission: Mission | None, robot: Robot) -> Iterator[TypeUse]:
    """The types of what the mission uses, of everything without one; a type that is left out is empty."""
    used = _used(mission) if mission is not None else _all(robot)
    for place, source in listened(mission, robot):
        if source.topic is not None or source.service is not None:
            yield _one(source.type, "srv" if source.service is not None else "msg", *place, "type")
    for name, action in robot.actions.items():
        if name in used["actions"] and not action.composed:
            yield _one(action.type, "action", "actions", name, "type")
    for place, service in service_places(robot):
        sort, name = place[:2]
        if sort == "control" or name in used[sort]:
            yield _one(service.type, "srv", *place, *(("type",) if sort == "services" else ()))
    for name, topic in robot.topics.items():
        if name in used["topics"]:
            yield _one(topic.type, "msg", "topics", name, "type")
    if robot.alive is not None:
        yield _one(robot.alive.type, "msg", "alive", "type")


def listened(mission: Mission | None, robot: Robot) -> Iterator[tuple[Place, Source | EventSource]]:
    """What a run of the mission receives, everything without one: each source with its place."""
    for name, source in robot.blackboard.items():
        if mission is None or name in mission.blackboard:
            yield ("blackboard", name), source
    for name, event in robot.events.items():
        if mission is None or name in mission.events:
            yield ("events", name), event
    if robot.holder is not None:
        yield ("holder",), robot.holder


def lacking(mission: Mission | None, robot: Robot, why: Callable[[str, TypeKind], str]) -> tuple[Fault, ...]:
    """What cannot be understood here.

    Args:
        mission: What is to run; without one everything that the profile names is looked at.
        robot: On which robot.
        why: Takes a type and its kind, and gives why it is not here; empty if it is.
    """
    reasons = {each: why(each.type, each.kind) for each in typed(mission, robot)}
    return tuple(Fault(each.place, sentence) for each, sentence in reasons.items() if sentence)


def _one(type_name: str, kind: TypeKind, *place: str) -> TypeUse:
    return TypeUse(pointer(list(place)), kind, type_name)


def _all(robot: Robot) -> dict[str, set[str]]:
    sorts = ("blackboard", "events", "actions", "services", "topics")
    return {sort: set(getattr(robot, sort)) for sort in sorts}


def _used(mission: Mission) -> dict[str, set[str]]:
    index = MissionIndex(mission)
    used: dict[str, set[str]] = {"actions": set(), "services": set(), "topics": set()}
    used |= {"blackboard": set(mission.blackboard), "events": set(mission.events)}
    for use in index.uses:
        used[f"{use.sort}s"].add(use.name)
    return used
