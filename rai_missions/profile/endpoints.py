# SPDX-License-Identifier: Apache-2.0
"""Whom a run on a robot may ask or tell something: the services, actions and topics that its profile names."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Literal, NamedTuple

from rai_missions.profile.entries import ServiceEntry
from rai_missions.profile.profile import Robot

__all__ = ("Endpoint", "asked")

HANDS_OVER = ("agent", "operator")
"""By whom control may be handed over; each has services of its own where the name says `{by}`."""


class Endpoint(NamedTuple):
    """A service, an action or a topic that is published on, by its name on the robot."""

    mode: Literal["services", "actions", "topics"]
    name: str
    type: str


def asked(robot: Robot) -> Iterator[Endpoint]:
    """What the profile names, each once."""
    services: list[ServiceEntry | None] = [*robot.services.values()]
    found: dict[Endpoint, None] = {}
    for action in robot.actions.values():
        if action.action is not None:
            found[Endpoint("actions", action.action, action.type)] = None
        services += (action.start, action.cancel)
    for service in services:
        if service is not None:
            found[Endpoint("services", service.service, service.type)] = None
    for entry in robot.control.values():
        for by in HANDS_OVER:
            found[Endpoint("services", entry.service.replace("{by}", by), entry.type)] = None
    for topic in robot.topics.values():
        found[Endpoint("topics", topic.topic, topic.type)] = None
    yield from found
