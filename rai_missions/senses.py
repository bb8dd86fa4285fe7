# SPDX-License-Identifier: Apache-2.0
"""Listens to the robot as its profile says, and turns messages into blackboard writes and events.

Rule: what it hears it passes on with its stamp; what it cannot understand is not heard, and logged once a source.
"""

from __future__ import annotations

import json
import logging
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Close, Connector, Reply
from rai_missions.cut import cut_repr
from rai_missions.errors import ConnectorError
from rai_missions.event import Event
from rai_missions.robot import EventSource, Robot, Source, unsaid

__all__ = ("Senses",)

log = logging.getLogger(__name__)

Hear = Callable[[Mapping[str, Any], float], None]
Poll = tuple[str, str, float, str]
"""Service, type, seconds between two questions, and the request as text."""


class Senses:
    """The ears and eyes of a run.

    Args:
        robot: The profile; without one nothing is heard.
        connector: How the robot is reached.
        post: Where events go.
        later: Has something done at an instant of the run's clock.
        now: The run's clock.
    """

    def __init__(
        self, robot: Robot | None, connector: Connector | None, *, post: Callable[[Event], None],
        later: Callable[[float, Callable[[], None]], None], now: Callable[[], float],
    ) -> None:  # fmt: skip
        self._robot, self._connector = robot, connector
        self._post, self._later, self._now = post, later, now
        self._closes: list[Close] = []
        self._open = False
        self._puzzled: set[str] = set()
        self._before: dict[str, bool | None] = {}
        self._under_way: set[str] = set()
        """Actions that were begun and whose end was not asked for."""
        self._polls: dict[Poll, tuple[Mapping[str, Any], list[Hear]]] = {}
        self.holder = None if robot is None or robot.holder is None else ""
        """Who holds control, as the robot says it; empty if it has yet to, None if it never will."""

    def open(self) -> None:
        """Subscribe to topics and begin to ask services."""
        if self._robot is None or self._connector is None:
            return
        self._open = True
        for key, source in self._robot.blackboard.items():
            self._listen(source, self._write_of(key, source))
        for name, event in self._robot.events.items():
            if not event.posted:
                self._listen(event, self._event_of(name, event))
        if self._robot.holder is not None:
            self._listen(self._robot.holder, self._hear_holder(self._robot.holder))
        for poll, (request, hears) in self._polls.items():
            self._poll(poll, request, hears)

    def begin(self) -> None:
        """The mission starts: what was so before is no news to it yet, so an event that lasts happens anew."""
        self._before.clear()

    def begin_action(self, action: str, *, anew: bool = True) -> None:
        """An action is about to begin: what is so now is no news during it, unless another process had begun it.

        Args:
            action: Its name.
            anew: It begins now; else it goes on.
        """
        if self._robot is not None and anew:
            self._before |= {name: True for name, event in self._robot.events.items() if event.during == action}
        self._under_way.add(action)

    def end_action(self, action: str) -> None:
        """An action is asked to end: what the robot does about that is no event."""
        self._under_way.discard(action)

    def close(self) -> None:
        """Hear nothing more."""
        self._open = False
        while self._closes:
            try:
                self._closes.pop()()
            except Exception:
                log.exception("a subscription could not be closed")
        self._polls.clear()

    def _listen(self, source: Source | EventSource, hear: Hear) -> None:
        assert self._connector is not None
        if source.topic is not None:
            self._closes.append(
                self._connector.subscribe(source.topic, source.type, lambda heard: hear(heard.data, heard.at))
            )
        elif source.service is not None and source.every_s is not None:
            poll = (source.service, source.type, source.every_s, json.dumps(source.request, sort_keys=True))
            self._polls.setdefault(poll, (source.request, []))[1].append(hear)

    def _poll(self, poll: Poll, request: Mapping[str, Any], hears: list[Hear]) -> None:
        """Ask a service now, and again when the time has come; one question for all who want its answer."""
        if not self._open or self._connector is None:
            return

        def answered(reply: Reply) -> None:
            if reply.outcome == "succeeded":
                for hear in hears:
                    hear(reply.data, self._now())

        service, type_name, every_s, _ = poll
        try:
            self._connector.call(service, type_name, request, answered=answered, timeout_s=every_s)
        except Exception as error:  # noqa: BLE001 - a connector's fault is a robot not heard, never the run's end
            self._puzzle(service, error)
        self._later(self._now() + every_s, lambda: self._poll(poll, request, hears))

    def _write_of(self, key: str, source: Source) -> Hear:
        def hear(message: Mapping[str, Any], at: float) -> None:
            now = self._now()
            try:
                value = source.value(message, now)
                stamp = _stamp(source.at(message, now), at, now)
            except Exception as error:  # noqa: BLE001 - whatever a robot sends, the run goes on without it
                self._puzzle(key, error)
                return
            if value is None:
                self._miss(key, source, message)
            else:
                self._post(Event(key, now, {"value": value, "stamp": stamp}, "write"))

        return hear

    def _event_of(self, name: str, source: EventSource) -> Hear:
        def hear(message: Mapping[str, Any], _: float) -> None:
            if source.during is not None and source.during not in self._under_way:
                return
            try:
                fires = source.fires(message)
                happens = source.happens(self._before.get(name), fires)
                if happens or fires is None:
                    self._miss(name, source, message)
                self._before[name] = fires
                if happens:
                    self._post(Event(name, self._now(), source.payload(message)))
            except Exception as error:  # noqa: BLE001 - whatever a robot sends, the run goes on without it
                self._puzzle(name, error)

        return hear

    def _hear_holder(self, source: Source) -> Hear:
        def hear(message: Mapping[str, Any], _: float) -> None:
            try:
                holder = source.value(message)
                if not isinstance(holder, str):
                    raise ConnectorError(f"{cut_repr(holder, 60)} stands where the name of who holds control belongs")
            except Exception as error:  # noqa: BLE001 - whatever a robot sends, the run goes on without it
                self._puzzle("holder", error)
                return
            if holder != self.holder:
                self.holder = holder
                self._post(Event(holder, self._now(), {"by": "robot"}, "control"))

        return hear

    def _miss(self, name: str, source: Source | EventSource, message: Mapping[str, Any]) -> None:
        """What was sought is not in a message: it has no place there, which is told once, or was left open."""
        if name not in self._puzzled and (why := unsaid(source, message)):
            self._puzzled.add(name)
            log.warning("'%s': %s", name, why)

    def _puzzle(self, name: str, error: Exception) -> None:
        if name not in self._puzzled:
            self._puzzled.add(name)
            log.warning("'%s' was not understood and counts as not heard: %s", name, error)


def _stamp(own: float, at: float, now: float) -> float:
    """When a message was so, on the run's clock.

    Args:
        own: By its own stamp; now if it has none, or one of another clock.
        at: By the connector.
        now: When it is heard.
    """
    return own if own < now else at if 0 < at < now else now
