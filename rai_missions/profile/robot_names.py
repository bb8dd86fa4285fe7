# SPDX-License-Identifier: Apache-2.0
"""The names of a robot's topics, services and actions, each with its place in the profile.

Rule: which names a middleware takes is its connector's to state; a profile is compared with that before a run begins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from rai_missions.connectors.connector import TYPE_KINDS, Mode, TypeKind
from rai_missions.errors import Fault
from rai_missions.profile.profile import HANDS_OVER, Robot

__all__ = ("RobotEntry", "misnamed", "wanted")


class RobotEntry(NamedTuple):
    """Something that a profile names."""

    place: str
    """Where: `blackboard/battery`."""
    mode: Mode
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
    received = (("blackboard", robot.blackboard), ("events", robot.events), ("", {"holder": robot.holder}))
    for sort, sources in received:
        for name, source in sources.items():
            place = f"{sort}/{name}".lstrip("/")
            if source is not None and source.topic is not None:
                yield RobotEntry(place, "topics", source.topic, source.type, may_be_silent=sort == "events")
            elif source is not None and source.service is not None:
                yield RobotEntry(place, "services", source.service, source.type)


def _done(robot: Robot) -> Iterator[RobotEntry]:
    services = {f"services/{name}": service for name, service in robot.services.items()}
    for name, action in robot.actions.items():
        if action.action is not None:
            yield RobotEntry(f"actions/{name}", "actions", action.action, action.type)
        parts = (("start", action.start), ("cancel", action.cancel))
        services |= {f"actions/{name}/{word}": part for word, part in parts if part is not None}
    services |= {f"control/{name}": each for name, each in robot.control.items() if "{" not in each.service}
    yield from (RobotEntry(place, "services", each.service, each.type) for place, each in services.items())


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
