# SPDX-License-Identifier: Apache-2.0
"""The tools' only way to the robot: each name is judged where it is touched, each wait has an end.

Rule: nothing here reaches the connector before `Allowlist` has been asked about that very name.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

from rai_missions.connectors.connector import Close, Connector, ConnectorMode, Data, Message, OnMessage, Reply
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import cut_repr
from rai_missions.tools.allowlist import AccessKind, Allowlist
from rai_missions.tools.latest import Latest

__all__ = ("AllowedConnector", "Sample", "until")

T = TypeVar("T")
LONGEST_WAIT_S = 60.0
LOOK_EVERY_S = 0.05
"""How often it is looked whether a name is listed by now."""
LISTED_S = 3.0
"""How long a name may take to be listed, where its type must be found out."""
STOPPED = "the tools were stopped"


class Sample(NamedTuple):
    """A message, and how old it was when it was handed over."""

    topic: str
    type_name: str
    data: Data
    at: float
    age_s: float


def until(timeout_s: float) -> float:
    """The instant of `time.monotonic` at which a wait ends; it is never longer than a minute."""
    if not 0 <= timeout_s <= LONGEST_WAIT_S:
        raise UsageError(
            f"timeout_s: {cut_repr(timeout_s, 40)} is no time to wait; give 0 to {LONGEST_WAIT_S:g} seconds"
        )
    return time.monotonic() + timeout_s


class AllowedConnector:
    """A connector as far as tools may use it. Safe to use from any thread.

    Args:
        connector: Started, and stopped, by someone else.
        allowed: What may be touched.
        now: Seconds on the clock that stamps the connector's messages.
    """

    def __init__(self, connector: Connector, allowed: Allowlist, now: Callable[[], float]) -> None:
        self.allowed, self.now = allowed, now
        self._connector = connector
        self._lock = threading.Lock()
        self._waits: set[Latest[Any]] = set()
        self._stopped = threading.Event()

    def stop(self) -> None:
        """End every wait; from now on nothing is done."""
        with self._lock:
            self._stopped.set()
            waits = tuple(self._waits)
        for wait in waits:
            wait.close()

    def waiting(self, latest: Latest[T]) -> Latest[T]:
        """A place to wait, known to `stop`; give it back with `done`."""
        with self._lock:
            if self._stopped.is_set():
                raise UsageError(STOPPED)
            self._waits.add(latest)
        return latest

    def done(self, latest: Latest[Any]) -> None:
        with self._lock:
            self._waits.discard(latest)

    def listed(self, mode: ConnectorMode) -> tuple[dict[str, str], int]:
        """The names of a mode that may be read, with their types; and how many others there are.

        Raises:
            UsageError: The connector does not have the mode.
        """
        self._has(mode)
        found = self._connector.listed(mode)
        may = {name: found[name] for name in sorted(found) if self.allowed.allows(name, "read")}
        return may, len(found) - len(may)

    def type_of(self, mode: ConnectorMode, name: str, given: str, ends: float, access: AccessKind = "read") -> str:
        """The type of a name: as it was given, else as it is listed once it is; empty if it is not in time."""
        self.allowed.check(name, access)
        self._has(mode)
        patience = min(ends, time.monotonic() + LISTED_S)
        while not given and (found := self._connector.listed(mode).get(name)) is None:
            if time.monotonic() >= patience or self._stopped.wait(LOOK_EVERY_S):
                return ""
        return given or found or ""

    def subscribe(self, topic: str, type_name: str, on_message: OnMessage, ends: float) -> tuple[Close, str]:
        """Listen to a topic that may be read; what ends that, and its type.

        A connector that has no types, or knows this one already, is not made to wait for a list.
        """
        self.allowed.check(topic, "read")
        self._has("topics")
        known = type_name or self._connector.listed("topics").get(topic, "")
        try:
            return self._connector.subscribe(topic, known, on_message), known
        except ConnectorError:
            if known:
                raise
        known = self.type_of("topics", topic, "", ends)
        if not known:
            raise ConnectorError(f"no topic '{topic}' is there{self.others('topics')}")
        return self._connector.subscribe(topic, known, on_message), known

    def receive(
        self, wanted: Mapping[str, str], ends: float, enough: Callable[[Mapping[str, Sample]], bool]
    ) -> dict[str, Sample]:
        """The newest messages of several topics at once.

        Args:
            wanted: Topic → its type, or nothing where it is to be found out.
            ends: An instant of `time.monotonic`.
            enough: Whether what was received so far will do; asked with each message.

        Returns:
            Topic → its newest message, of those that came in time; old ones too, if nothing newer came.
        """
        for topic in wanted:
            self.allowed.check(topic, "read")
        newest, types, closes = NewestMessages(), dict[str, str](), list[Close]()
        received: dict[str, Sample] = {}
        changed: Latest[Message] = self.waiting(newest.changed)

        def will_do(_: object) -> bool:
            received.update({each.topic: self._sample(each, types.get(each.topic, "")) for each in newest.messages()})
            return enough(received)

        try:
            for topic, type_name in wanted.items():
                close, types[topic] = self.subscribe(topic, type_name, newest.take, ends)
                closes.append(close)
            changed.wait(ends, will_do)
        finally:
            for close in closes:
                close()
            self.done(changed)
        if self._stopped.is_set():
            raise UsageError(STOPPED)
        return received

    def newest(
        self, topic: str, type_name: str, max_age_s: float | None, timeout_s: float
    ) -> tuple[Sample | None, Sample | None]:
        """The newest message, if one came that is no older than asked; else the newest of those that are."""
        if max_age_s is not None and not max_age_s >= 0:
            raise UsageError(f"max_age_s: {cut_repr(max_age_s, 40)} is no age in seconds")
        oldest_s = math.inf if max_age_s is None else max_age_s

        def will_do(received: Mapping[str, Sample]) -> bool:
            return topic in received and received[topic].age_s <= oldest_s

        found = self.receive({topic: type_name}, until(timeout_s), will_do)
        sample = found.get(topic)
        return (sample, None) if will_do(found) else (None, sample)

    def publish(self, topic: str, type_name: str, message: Data) -> None:
        self.allowed.check(topic, "write")
        self._connector.publish(topic, type_name, message)

    def call(self, service: str, type_name: str, request: Data, timeout_s: float) -> Reply:
        """Call a service and wait for its reply."""
        self.allowed.check(service, "write")
        replies: Latest[Reply] = self.waiting(Latest())
        try:
            # The connector gives up first; the grace is for a connector that does not.
            self._connector.call(service, type_name, request, on_reply=replies.put, timeout_s=timeout_s)
            reply = replies.wait(time.monotonic() + timeout_s + 1.0)
        finally:
            self.done(replies)
        return reply or Reply("timed_out", {}, f"{service} did not answer within {timeout_s:g} s")

    def send_goal(
        self, action: str, type_name: str, goal: Data, goal_id: str, on_report: Callable[[Any], None]
    ) -> None:
        self.allowed.check(action, "write")
        self._has("actions")
        self._connector.send_goal(action, type_name, goal, goal_id=goal_id, on_report=on_report)

    def cancel_goal(self, goal_id: str) -> None:
        """Anyone who was allowed to start a goal may end it."""
        self._connector.cancel_goal(goal_id)

    def _has(self, mode: ConnectorMode) -> None:
        if mode not in self._connector.modes:
            has = ", ".join(sorted(self._connector.modes))
            raise UsageError(f"this robot's connector carries no {mode}; it carries {has}")

    def others(self, mode: ConnectorMode) -> str:
        """The names that there are, for the end of a sentence."""
        names = list(self.listed(mode)[0])
        more = ", …" if len(names) > 12 else ""
        return f"; there is: {', '.join(names[:12])}{more}" if names else f"; no {mode} that may be read are there"

    def _sample(self, message: Message, type_name: str) -> Sample:
        age_s = max(0.0, self.now() - message.at) if math.isfinite(message.at) else math.inf
        return Sample(message.topic, type_name, message.data, message.at, age_s)


class NewestMessages:
    """Keeps the newest message of each topic that it receives."""

    def __init__(self) -> None:
        self.changed: Latest[Message] = Latest()
        self._lock = threading.Lock()
        self._newest: dict[str, Message] = {}

    def take(self, message: Message) -> None:
        with self._lock:
            before = self._newest.get(message.topic)
            if before is None or _instant(message) >= _instant(before):
                self._newest[message.topic] = message
        self.changed.put(message)

    def messages(self) -> tuple[Message, ...]:
        with self._lock:
            return tuple(self._newest.values())


def _instant(message: Message) -> float:
    """When it was so; a stamp that is no time is older than every other."""
    return message.at if math.isfinite(message.at) else -math.inf
