# SPDX-License-Identifier: Apache-2.0
"""Subscribe: readers that fit their publisher, each for all who listen to a topic.

Rule: anyone who joins later receives what a reader of their own would: of a latched topic what was reported last,
else nothing.
"""

from __future__ import annotations

import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import replace
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import QoSPolicyKind
from rclpy.serialization import deserialize_message

from rai_missions.connectors.connector import Close, Message, OnMessage, RawMessage
from rai_missions.connectors.ros2.config import QosProfile, is_conventional
from rai_missions.connectors.ros2.inspection import unlatched
from rai_missions.connectors.ros2.messages import name_of, to_data
from rai_missions.connectors.ros2.mixed import MessageSorter
from rai_missions.connectors.ros2.node_thread import Runtime, guarded
from rai_missions.connectors.ros2.offers import offered_quality
from rai_missions.connectors.ros2.publishers import profile
from rai_missions.connectors.stamps import ReadingDate
from rai_missions.redaction import logger

__all__ = ("Listener", "Subscriptions")

log = logger(__name__)

LOOKS_S = (1.0, 2.0, 7.0)
"""When it is asked why nothing is received, each counted from the time before."""


class Listener:
    """One who listens to a topic.

    Args:
        on_message: Sent each message.
        on_raw: Sent its bytes, before.
    """

    def __init__(self, on_message: OnMessage, on_raw: Callable[[RawMessage], None] | None = None) -> None:
        self._on_message, self._on_raw = on_message, on_raw
        self.is_raw = on_raw is not None
        self.is_open = True

    def deliver(self, raw: RawMessage | None, message: Message) -> None:
        """Pass a message on; what this listener raises stops no one else."""
        on_raw = self._on_raw
        if raw is not None and on_raw is not None and self.is_open:
            guarded(lambda: on_raw(raw))
        if self.is_open:
            guarded(lambda: self._on_message(message))


class Subscriptions:
    """The topics that are listened to: one reader each, and one more where someone wants the bytes.

    Args:
        runtime: Where they live.
        quality: How a topic's messages travel; where it leaves the reliability open, it is what the publisher offers.
        date: Dates a message that is received now.
    """

    def __init__(
        self, runtime: Runtime, quality: Callable[[str], QosProfile], date: Callable[[Any], ReadingDate]
    ) -> None:
        self._runtime, self._quality, self._date = runtime, quality, date
        self._readers: dict[tuple[str, bool], _Reader] = {}

    def join(self, topic: str, cls: Any, listener: Listener) -> Close:
        """Listen to a topic from now on; from any thread, as is what ends it: then nothing more is received."""
        self._runtime.post(lambda: self._join(topic, cls, listener))

        def close() -> None:
            listener.is_open = False
            self._runtime.post(lambda: self._leave(topic, listener))

        return close

    def _join(self, topic: str, cls: Any, listener: Listener) -> None:
        if not listener.is_open:
            return
        key = (topic, listener.is_raw)
        if key not in self._readers:
            self._readers[key] = _Reader(
                self._runtime, topic, cls, quality=self._quality(topic), date=self._date, is_raw=listener.is_raw
            )
        self._readers[key].join(listener)

    def _leave(self, topic: str, listener: Listener) -> None:
        key = (topic, listener.is_raw)
        reader = self._readers.get(key)
        if reader is not None and reader.leave(listener):
            del self._readers[key]


class _Reader:
    """One topic's reader. On the runtime's thread only."""

    def __init__(
        self,
        runtime: Runtime,
        topic: str,
        cls: Any,
        *,
        quality: QosProfile,
        date: Callable[[Any], ReadingDate],
        is_raw: bool,
    ) -> None:
        self._runtime, self._topic, self._class, self._quality = runtime, topic, cls, quality
        self._date, self._is_raw = date, is_raw
        self._listeners: tuple[Listener, ...] = ()
        self._last: deque[Any] = deque(maxlen=quality.depth if quality.durability == "latched" else 0)
        self._entities: dict[str, Any] = {}
        self._offers = ""
        self._mixed = MessageSorter(runtime.later, self._arrived, self._count_reliable)
        self._is_open = True
        self._is_puzzled = self._is_fitted = self._has_arrived = False
        self._open("reliable")
        self._look_after(LOOKS_S)

    def join(self, listener: Listener) -> None:
        """Add one listener, beginning with what ROS would notify a reader that is new."""
        self._listeners += (listener,)
        if self._last and self._publishers():
            for kept in tuple(self._last):
                self._deliver(kept, (listener,), is_kept=True)

    def leave(self, listener: Listener) -> bool:
        """Remove one listener; whether that was the last one, and the reader is closed."""
        self._listeners = tuple(each for each in self._listeners if each is not listener)
        if self._is_open and not self._listeners:
            self._is_open = False
            self._close()
        return not self._listeners

    def _open(self, reliability: str) -> None:
        if not self._is_open:
            return
        if not self._entities:
            self._opened_ns, self._count = time.time_ns(), 0
        quality = self._quality
        if is_conventional(quality) and reliability == "best_effort":
            quality = replace(quality, durability="volatile")  # fits every publisher
        events = SubscriptionEventCallbacks(incompatible_qos=self._on_mismatch, use_default_callbacks=False)
        receive = self._mixed.receive_reliably if reliability == "reliable" else self._mixed.receive
        self._entities[reliability] = self._runtime.node.create_subscription(
            self._class,
            self._topic,
            receive,
            profile(quality, reliability),
            callback_group=self._runtime.group,
            event_callbacks=events,
            raw=self._is_raw,
        )

    def _close(self) -> None:
        while self._entities:
            self._runtime.node.destroy_subscription(self._entities.popitem()[1])

    def _count_reliable(self) -> int:
        """Reliable publishers there are: no other fits the reliable reader."""
        return int(self._entities["reliable"].get_publisher_count()) if "reliable" in self._entities else 0

    def _publishers(self) -> list[Any]:
        return list(self._runtime.node.get_publishers_info_by_topic(self._topic))

    def _offered(self) -> str:
        """The quality that its publishers offer, asked for once there is one."""
        if not self._offers:
            self._offers = offered_quality([each.qos_profile for each in self._publishers()])
        return self._offers

    def _look_after(self, waits: tuple[float, ...]) -> None:
        """State why what is published there is not received: ROS itself keeps silent."""

        def look() -> None:
            if self._has_arrived or not self._is_open:
                return
            if why := self._why_silent():
                log.warning("%s %s", self._topic, why)
            else:
                self._look_after(waits[1:])

        if waits:
            self._runtime.later(waits[0], look)

    def _why_silent(self) -> str:
        """What is wrong where no message comes although there are publishers, and the remedy; empty if nothing is."""
        publishers, name = self._publishers(), name_of(self._class)
        others = sorted({each.topic_type for each in publishers} - {name})
        if others:
            given = " and ".join(others)
            return f"is published as {given}, and so not received as the {name} that is asked for; mend the type"
        return "; ".join(unlatched(self._topic, self._quality, publishers) or ())

    def _on_mismatch(self, found: Any) -> None:
        """A publisher offers less than is asked for, and would never be received."""
        if self._is_fitted:
            return
        is_open = self._quality.reliability is None and found.last_policy_kind == QoSPolicyKind.RELIABILITY
        if is_open or is_conventional(self._quality):
            self._is_fitted = True
            log.info("%s is published with less than is asked for, and is received so from that publisher", self._topic)
            self._runtime.post(lambda: self._open("best_effort"))
        elif not self._is_puzzled:
            self._is_puzzled = True
            policy = QoSPolicyKind(found.last_policy_kind).name.lower()
            log.warning(
                "a publisher of %s offers less %s than the profile asks for and is not received; mend connector/qos/%s",
                self._topic,
                policy,
                self._topic,
            )

    def _arrived(self, message: Any, info: Mapping[str, Any]) -> None:
        """A message has come; in bytes, where someone wants them."""
        self._has_arrived = True
        self._last.append(message)
        self._deliver(message, self._listeners, is_kept=self._is_kept(info))

    def _is_kept(self, info: Mapping[str, Any]) -> bool:
        """A latched message that was published before this reader was there; a middleware may not state when it was."""
        self._count += 1
        if self._quality.durability != "latched" or self._count > self._quality.depth:
            return False
        return int(info.get("source_timestamp") or 0) < self._opened_ns

    def _deliver(self, arrived: Any, listeners: tuple[Listener, ...], *, is_kept: bool) -> None:
        """Convert a message once, for anyone who still listens."""
        if not any(each.is_open for each in listeners):
            return
        message = deserialize_message(arrived, self._class) if self._is_raw else arrived
        at, age_s = self._date(message)
        raw = RawMessage(self._topic, name_of(self._class), arrived, at, self._offered()) if self._is_raw else None
        plain = Message(self._topic, to_data(message, f"{self._topic}@{at:.3f}"), at, age_s, is_kept)
        for each in listeners:
            each.deliver(raw, plain)
