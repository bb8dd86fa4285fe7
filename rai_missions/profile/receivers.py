# SPDX-License-Identifier: Apache-2.0
"""Which entry of a profile receives what a mission sends: a server, the service that starts an action, a topic."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

from rai_missions.check.index import RobotUse
from rai_missions.profile.entries import ActionEntry, ServiceEntry
from rai_missions.profile.profile import Place, Robot

__all__ = ("SENT_WORDS", "Receiver", "receiver_of")

SENT_WORDS = {"action": "goal", "service": "request", "topic": "message"}
"""What a mission uses → its word for what it sends there."""


class Receiver(NamedTuple):
    """An entry of a profile, or a part of one, to which something is sent."""

    place: Place
    word: Literal["goal", "request", "message"]
    """The entry's field with what it adds."""
    type: str
    template: Mapping[str, Any]


def receiver_of(robot: Robot, use: RobotUse) -> Receiver | None:
    """What receives the goal, request or message of a use; None where the profile lacks the name."""
    entry: Any = getattr(robot, f"{use.sort}s").get(use.name)
    place: Place = (f"{use.sort}s", use.name)
    if isinstance(entry, ActionEntry):
        if entry.start is None:
            return Receiver(place, "goal", entry.type, entry.goal)
        entry, place = entry.start, (*place, "start")
    if entry is None:
        return None
    if isinstance(entry, ServiceEntry):
        return Receiver(place, "request", entry.type, entry.request)
    return Receiver(place, "message", entry.type, entry.message)
