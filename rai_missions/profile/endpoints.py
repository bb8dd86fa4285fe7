# SPDX-License-Identifier: Apache-2.0
"""The endpoints of a robot: the topics, services and actions that a profile names, each with its place and its type.

Rule: which names and types a middleware takes is its connector's to state; a profile is compared with that before a run
begins.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import NamedTuple

from rai_missions.check.index import MissionIndex
from rai_missions.connectors.connector import TYPE_KINDS, ConnectorMode, TypeKind
from rai_missions.errors import Fault, pointer
from rai_missions.mission.mission import Mission
from rai_missions.profile.profile import Place, Robot, service_places
from rai_missions.profile.sources import EventSource, Source

__all__ = ("Endpoint", "asked", "endpoints", "lacking", "listened", "misnamed", "wanted")

HANDS_OVER = ("agent", "operator")
"""By whom control may be handed over; each has services of its own where the name reports `{by}`."""


class Endpoint(NamedTuple):
    """A topic, service or action of a robot, as its profile names it."""

    place: Place
    mode: ConnectorMode
    name: str
    """The name on the robot; that of a handover may hold `{by}`."""
    type: str
    """Empty where the profile leaves it out."""
    is_listener: bool = False
    """The mission publishes on it: no subscriber is needed."""
    may_be_silent: bool = False
    """An event: its publisher may appear when it happens."""

    @property
    def kind(self) -> TypeKind:
        return TYPE_KINDS[self.mode]

    @property
    def names(self) -> tuple[str, ...]:
        """The endpoint's names on the robot: for a handover one a holder that may ask for it."""
        by = HANDS_OVER if self.place[0] == "control" else ("",)
        return tuple(dict.fromkeys(self.name.replace("{by}", each) for each in by))

    @property
    def type_place(self) -> str:
        """JSON pointer to its type; to the whole of a service that may be written as its name alone."""
        is_short = self.mode == "services" and (self.place[0] == "control" or len(self.place) > 2)
        return pointer([*self.place] if is_short else [*self.place, "type"])

    @property
    def what(self) -> str:
        """In words: `blackboard/battery: topic /battery`."""
        return f"{'/'.join(self.place)}: {self.mode[:-1]} {self.name}"

    @property
    def how(self) -> str:
        """How it must be present: `offered` by a server or publisher, or, where that is enough, `listed`."""
        return "listed" if self.is_listener else "offered"


def endpoints(robot: Robot, mission: Mission | None = None) -> Iterator[Endpoint]:
    """All that a profile names, or what of it a mission uses: what is received comes first."""
    used = _used(mission) if mission is not None else {}
    for each in (*_received(robot), *asked(robot)):
        if each.place[0] not in used or each.place[1] in used[each.place[0]]:
            yield each
    if robot.alive is not None:
        yield Endpoint(("alive",), "topics", robot.alive.topic, robot.alive.type, is_listener=True)


def asked(robot: Robot) -> Iterator[Endpoint]:
    """What a run on a robot may ask or publish on."""
    for name, action in robot.actions.items():
        if action.action is not None:
            yield Endpoint(("actions", name), "actions", action.action, action.type)
    for place, service in service_places(robot):
        yield Endpoint(place, "services", service.service, service.type)
    for name, topic in robot.topics.items():
        yield Endpoint(("topics", name), "topics", topic.topic, topic.type, is_listener=True)


def wanted(robot: Robot) -> Iterator[Endpoint]:
    """What must be there before a run; a handover's service, whose name depends on who asks, is left out."""
    for each in endpoints(robot):
        if each.place != ("alive",) and not (each.place[0] == "control" and "{" in each.name):
            yield each


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
    """The types that cannot be understood here.

    Args:
        mission: What is to run; without one everything that the profile names is looked at.
        robot: On which robot.
        why: Takes a type and its kind, and gives why it is not here; empty if it is.
    """
    uses = dict.fromkeys((each.type_place, each.type, each.kind) for each in endpoints(robot, mission))
    return tuple(Fault(place, reason) for place, name, kind in uses if (reason := why(name, kind)))


def misnamed(robot: Robot, why: Callable[[str, TypeKind], str]) -> tuple[Fault, ...]:
    """The names that the robot's middleware does not take, each once.

    Args:
        robot: Whose profile it is.
        why: Takes a name and its kind, and gives why it is none; empty if it is one.
    """
    found: dict[str, str] = {}
    for each in endpoints(robot):
        for reason in (why(name, each.kind) for name in each.names):
            if reason:
                found.setdefault(f"/{'/'.join(each.place)}", reason)
    return tuple(Fault(place, reason) for place, reason in found.items())


def _received(robot: Robot) -> Iterator[Endpoint]:
    for place, source in listened(None, robot):
        is_event = isinstance(source, EventSource)
        if source.topic is not None:
            yield Endpoint(place, "topics", source.topic, source.type, may_be_silent=is_event)
        elif source.service is not None:
            yield Endpoint(place, "services", source.service, source.type)


def _used(mission: Mission) -> dict[str, set[str]]:
    """Section of a profile → the names in it that a mission uses."""
    used: dict[str, set[str]] = {"actions": set(), "services": set(), "topics": set()}
    for use in MissionIndex(mission).uses:
        used[f"{use.sort}s"].add(use.name)
    return used | {"blackboard": set(mission.blackboard), "events": set(mission.events)}
