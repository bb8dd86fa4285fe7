# SPDX-License-Identifier: Apache-2.0
"""Instants of what a run does at which its process kills itself: exact ones, that no one could hit from outside.

Rule: it is SIGKILL, as anybody else would send it. Nothing is closed, written or reported after it.
"""

from __future__ import annotations

import functools
import importlib
import itertools
import os
import signal
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

__all__ = ("INSTANTS", "Instant", "die_at")


class Instant(NamedTuple):
    """Right before or right after something is done for the n-th time in this life."""

    name: str
    nth: int
    is_done: bool

    def __str__(self) -> str:
        return f"{'after' if self.is_done else 'before'} {self.name} {self.nth}"


class Spot(NamedTuple):
    """A method, and how often it is called in a life at the most."""

    place: str
    often: int
    counts: Callable[..., bool] = lambda *given, **words: True
    """Whether a call is one of those that are meant."""


def _is(*kinds: str) -> Callable[..., bool]:
    return lambda self, event: event.kind in kinds


INSTANTS: Mapping[str, Spot] = {
    "a step is done again": Spot("rai_missions.replay.rebuild:JournalReplayer.again", 30),
    "the run is resumed": Spot("rai_missions.runtime.recovery:resume_effects", 1),
    "the robot reports again": Spot("rai_missions.runtime.recovery:ResyncWindow.take", 3),
    "a question is asked again": Spot("rai_missions.runtime.effects:EffectExecutor.ask_again", 1),
    "a step is taken": Spot("rai_missions.engine:Chart.send", 25),
    "a row is written": Spot("rai_missions.journal.writer:Journal._append", 30),
    "effects are performed": Spot("rai_missions.runtime.effects:EffectExecutor.perform", 12),
    "a goal is given to the connector": Spot("rai_missions.connectors.ros2.connector:Ros2Connector.send_goal", 4),
    "a goal is looked for": Spot("rai_missions.connectors.ros2.connector:Ros2Connector.find_goal", 2),
    "a goal is sent": Spot("rai_missions.connectors.ros2.remote_goal:RemoteGoal._start", 4),
    "a service is called": Spot("rai_missions.connectors.ros2.connector:Ros2Connector.call", 2),
    "a call is sent": Spot("rai_missions.connectors.ros2.services:Client._send_one", 2),
    "a message is published": Spot("rai_missions.connectors.ros2.connector:Ros2Connector.publish", 1),
    "an acceptance comes": Spot("rai_missions.runtime.mailbox:Mailbox.post", 4, _is("accepted")),
    "a result comes": Spot("rai_missions.runtime.mailbox:Mailbox.post", 4, _is("result")),
    "an answer comes": Spot("rai_missions.runtime.mailbox:Mailbox.post", 1, _is("proposal")),
}


def die_at(instant: Instant) -> None:
    """Have this process kill itself there."""
    spot, calls = INSTANTS[instant.name], itertools.count(1)
    module, _, path = spot.place.partition(":")
    *owner, name = path.split(".")
    rooms = [importlib.import_module(module)] if owner else _rooms_with(module, name)
    for room in rooms:
        holder: Any = getattr(room, owner[0]) if owner else room
        setattr(holder, name, _mortal(getattr(holder, name), spot, calls, instant))


def _rooms_with(module: str, name: str) -> list[Any]:
    """A function is known in the rooms that imported it, too."""
    import sys

    found = getattr(importlib.import_module(module), name)
    return [each for each in list(sys.modules.values()) if getattr(each, name, None) is found]


def _mortal(do: Callable[..., Any], spot: Spot, calls: itertools.count[int], instant: Instant) -> Callable[..., Any]:
    @functools.wraps(do)
    def done(*given: Any, **words: Any) -> Any:
        is_last = spot.counts(*given, **words) and next(calls) == instant.nth
        if is_last and not instant.is_done:
            os.kill(os.getpid(), signal.SIGKILL)
        made = do(*given, **words)
        if is_last:
            os.kill(os.getpid(), signal.SIGKILL)
        return made

    return done
