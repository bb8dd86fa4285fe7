# SPDX-License-Identifier: Apache-2.0
"""Listens to the robot as its profile states, and turns messages into blackboard writes and events.

Rule: what it receives it passes on with its stamp; what it cannot understand is kept as such, and logged once a source.
"""

from __future__ import annotations

import json
import math
from collections import defaultdict
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.connectors.connector import Close, Connector, Message, OnMessage, Reply
from rai_missions.errors import ConnectorError
from rai_missions.event import Event
from rai_missions.keys import Key, type_error
from rai_missions.profile import EventSource, Robot, Source, absent_field, why_unreadable
from rai_missions.redaction import cut_repr, logger
from rai_missions.runtime.readings import Readings, SourceState, offset_words
from rai_missions.runtime.scheduler import Scheduler

__all__ = ("RobotListener",)

log = logger(__name__)

Poll = tuple[str, str, float, str]
"""Service, type, seconds between two questions, and the request as text."""


class RobotListener:
    """The ears and eyes of a run.

    Args:
        robot: The profile, which names what is received.
        connector: How the robot is reached.
        scheduler: When services are asked, and where events go.
        keys: The mission's, to whose types a reading is held before it counts as understood.
        note: Has a sentence written into the journal.
    """

    def __init__(
        self,
        robot: Robot,
        connector: Connector | None,
        scheduler: Scheduler,
        keys: Mapping[str, Key] | None = None,
        note: Callable[[str], None] = lambda _text: None,
    ) -> None:
        self._robot, self._connector, self._keys, self._note = robot, connector, keys or {}, note
        self._scheduler = scheduler
        self._closes: list[Close] = []
        self._open = False
        self._puzzled: set[str] = set()
        self._readings: defaultdict[str, Readings] = defaultdict(Readings)
        self._before: dict[str, bool | None] = {}
        self._is_begun = False
        self._early: set[str] = set()
        """Events that were reported as dropped before the start."""
        self._under_way: set[str] = set()
        """Actions that were begun and whose end was not asked for."""
        self._polls: dict[Poll, tuple[Mapping[str, Any], list[OnMessage]]] = {}
        self.holder = None if robot.holder is None else ""
        """Who holds control, as the robot reports it; empty if it has yet to, None if it never will."""

    def source(self, key: str) -> SourceState:
        """What is known of the source of a robot key."""
        readings, source = self._readings.get(key), self._robot.blackboard.get(key)
        state = readings.state if readings is not None else SourceState()
        return state._replace(name=source.topic or source.service or "") if source is not None else state

    def open(self) -> None:
        """Subscribe to topics and begin to ask services."""
        if self._connector is None:
            return
        self._open = True
        for key, source in self._robot.blackboard.items():
            self._listen(source, self._write_of(key, source))
        for name, event in self._robot.events.items():
            if not event.posted:
                self._listen(event, self._event_of(name, event))
        if self._robot.holder is not None:
            self._listen(self._robot.holder, self._holder_of(self._robot.holder))
        for poll, (request, readers) in self._polls.items():
            self._poll(poll, request, readers)

    def begin(self) -> None:
        """The mission starts: what was so before is no news to it yet, so an event that lasts happens again."""
        self._before.clear()
        self._is_begun = True

    def resume(self) -> None:
        """Note that another process has begun the mission."""
        self._is_begun = True

    def begin_action(self, action: str) -> None:
        """An action is about to begin: what is so now is no news during it."""
        self._before |= {name: True for name, event in self._robot.events.items() if event.during == action}
        self.continue_action(action)

    def continue_action(self, action: str) -> None:
        """An action that another process has begun continues."""
        self._under_way.add(action)

    def end_action(self, action: str) -> None:
        """An action is asked to end: what the robot does about that is no event."""
        self._under_way.discard(action)

    def close(self) -> None:
        """Receive nothing more."""
        self._open = False
        while self._closes:
            try:
                self._closes.pop()()
            except (Exception, SystemExit):
                log.exception("a subscription could not be closed")

    def _listen(self, source: Source | EventSource, on_message: OnMessage) -> None:
        assert self._connector is not None
        if source.topic is not None:
            self._closes.append(self._connector.subscribe(source.topic, source.type, on_message))
        elif source.service is not None and source.every_s is not None:
            poll = (source.service, source.type, source.every_s, json.dumps(source.request, sort_keys=True))
            self._polls.setdefault(poll, (source.request, []))[1].append(on_message)

    def _poll(self, poll: Poll, request: Mapping[str, Any], readers: list[OnMessage]) -> None:
        """Ask a service now, and again when the time has come; one question for all who want its answer."""
        if not self._open or self._connector is None:
            return

        def answered(reply: Reply) -> None:
            if reply.outcome == "succeeded":
                message = Message(
                    service, reply.data, self._scheduler.now() - max(0.0, reply.age_s or 0.0), reply.age_s
                )
                for read in readers:
                    read(message)

        service, type_name, every_s, _ = poll
        try:
            self._connector.call(service, type_name, request, on_reply=answered, timeout_s=every_s)
        except (Exception, SystemExit) as error:  # noqa: BLE001 - a connector's fault is a robot that reports nothing, never the run's end
            self._puzzle(service, error)
        self._scheduler.call_at(self._scheduler.now() + every_s, lambda: self._poll(poll, request, readers))

    def _write_of(self, key: str, source: Source) -> OnMessage:
        readings = self._readings[key]

        def read(message: Message) -> None:
            now = self._scheduler.now()
            try:
                if readings.receive(message.age_s, kept=message.kept):
                    self._report_offset(key, readings)
                value = source.value(message.data, now)
            except Exception as error:  # noqa: BLE001 - whatever a robot sends, the run continues without it
                readings.misread(str(error))
                self._puzzle(key, error)
                return
            if value is None:
                readings.misread(why_unreadable(source, message.data))
                self._miss(key, source, message.data)
                return
            stamp = _stamp(message, now)
            if why := type_error(self._keys[key], value) if key in self._keys else "":
                readings.misread(why)
            else:
                readings.understood(now - stamp)
            self._scheduler.post(Event(key, now, {"value": value, "stamp": stamp}, "write"))

        return read

    def _report_offset(self, key: str, readings: Readings) -> None:
        """A source's stamps are off: its readings are stale too early, or as old as their receipt."""
        offset_s = readings.offset_s
        if offset_s is not None:
            sentence = f"'{key}': {offset_words(offset_s)}; mend the clock of what sends it, or what holds it up"
            log.warning("%s", sentence)
            self._note(sentence)

    def _event_of(self, name: str, source: EventSource) -> OnMessage:
        def read(received: Message) -> None:
            message = received.data
            if source.during is not None and source.during not in self._under_way:
                return
            try:
                fires = source.fires(message)
                happens = source.happens(self._before.get(name), fires)
                if happens or fires is None:
                    self._miss(name, source, message)
                self._before[name] = fires
                if happens:
                    self._report_early(name, source)
                    self._scheduler.post(Event(name, self._scheduler.now(), source.payload(message)))
            except Exception as error:  # noqa: BLE001 - whatever a robot sends, the run continues without it
                self._puzzle(name, error)

        return read

    def _report_early(self, name: str, source: EventSource) -> None:
        """An event that does not last is dropped by a mission that has not started, and does not happen again."""
        if not self._is_begun and source.when is None and name not in self._early:
            self._early.add(name)
            sentence = f"the event '{name}' is dropped: it came before the start"
            log.warning("%s", sentence)
            self._note(sentence)

    def _holder_of(self, source: Source) -> OnMessage:
        def read(message: Message) -> None:
            try:
                holder = source.value(message.data)
                if not isinstance(holder, str):
                    raise ConnectorError(f"{cut_repr(holder, 60)} is given where the name of who holds control belongs")
            except Exception as error:  # noqa: BLE001 - whatever a robot sends, the run continues without it
                self._puzzle("holder", error)
                return
            if holder != self.holder:
                self.holder = holder
                self._scheduler.post(Event(holder, self._scheduler.now(), {"by": "robot"}, "control"))

        return read

    def _miss(self, name: str, source: Source | EventSource, message: Mapping[str, Any]) -> None:
        """What was sought is not in a message: it has no place there, which is logged once, or was left open."""
        if name not in self._puzzled and (why := absent_field(source, message)):
            self._puzzled.add(name)
            log.warning("'%s': %s", name, why)

    def _puzzle(self, name: str, error: BaseException) -> None:
        if name not in self._puzzled:
            self._puzzled.add(name)
            log.warning("'%s' was not understood and counts as not received: %s", name, error)


def _stamp(message: Message, now: float) -> float:
    """When a reading that is received now was so, on the run's clock.

    Its age decides, whatever clock the connector counts by; a connector that gives none gives an instant of the run's.
    """
    if message.age_s is not None and math.isfinite(message.age_s):
        return now - max(0.0, message.age_s)
    return min(float(message.at), now) if math.isfinite(message.at) else now
