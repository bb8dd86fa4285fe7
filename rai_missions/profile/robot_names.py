# SPDX-License-Identifier: Apache-2.0
"""The names of a robot's topics, services and actions, each with its place in the profile.

Rule: which names a middleware takes is its connector's to state; a profile is compared with that before a run begins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from rai_missions.connectors.connector import TYPE_KINDS, ConnectorMode, TypeKind
from rai_missions.errors import Fault
from rai_missions.profile.message_types import listened
from rai_missions.profile.profile import HANDS_OVER, Robot, service_places
from rai_missions.profile.sources import EventSource

__all__ = ("RobotEntry", "misnamed", "wanted")


class RobotEntry(NamedTuple):
    """Something that a profile names."""

    place: str
    """Where: `blackboard/battery`."""
    mode: ConnectorMode
    name: str
    type: str
    is_listener: bool = False
    """The mission publishes on it: no subscriber is needed."""
    may_be_silent: bool = False
    """An event: its publisher may appear when it happens."""

    @property
    def what(self) -> str:
        """In words: `blackboard/battery: topic /battery`."""
        return f"{self.place}: {self.mode[:-1]} {self.name}"

    @property
    def how(self) -> str:
        """How it must be present: `offered` by a server or publisher, or, where that is enough, `listed`."""
        return "listed" if self.is_listener else "offered"


def wanted(robot: Robot) -> Iterator[RobotEntry]:
    """All topics, services and actions that a profile names; a handover's, whose name depends on who asks, left out."""
    yield from _received(robot)
    yield from _done(robot)
    for name, topic in robot.topics.items():
        yield RobotEntry(f"topics/{name}", "topics", topic.topic, topic.type, is_listener=True)


def _received(robot: Robot) -> Iterator[RobotEntry]:
    for place, source in listened(None, robot):
        if source.topic is not None:
            yield RobotEntry(
                "/".join(place), "topics", source.topic, source.type, may_be_silent=isinstance(source, EventSource)
            )
        elif source.service is not None:
            yield RobotEntry("/".join(place), "services", source.service, source.type)


def _done(robot: Robot) -> Iterator[RobotEntry]:
    for name, action in robot.actions.items():
        if action.action is not None:
            yield RobotEntry(f"actions/{name}", "actions", action.action, action.type)
    for place, each in service_places(robot):
        if place[0] != "control" or "{" not in each.service:
            yield RobotEntry("/".join(place), "services", each.service, each.type)


def misnamed(robot: Robot, why: Callable[[str, TypeKind], str]) -> tuple[Fault, ...]:
    """The names that the robot's middleware does not take, each once.

    Args:
        robot: Whose profile it is.
        why: Takes a name and its kind, and gives why it is none; empty if it is one.
    """
    handovers = (
        RobotEntry(f"control/{name}", "services", each.service.replace("{by}", by), each.type)
        for name, each in robot.control.items()
        for by in HANDS_OVER
    )
    alive = robot.alive and RobotEntry("alive", "topics", robot.alive.topic, robot.alive.type)
    found: dict[str, str] = {}
    for each in (*wanted(robot), *handovers, *([alive] if alive else ())):
        if reason := why(each.name, TYPE_KINDS[each.mode]):
            found.setdefault(f"/{each.place}", reason)
    return tuple(Fault(place, reason) for place, reason in found.items())
