# SPDX-License-Identifier: Apache-2.0
"""Publish and subscribe: publishers that do not lose their first words, and readers that fit their publisher."""

from __future__ import annotations

import logging
from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.event_handler import SubscriptionEventCallbacks
from rclpy.qos import DurabilityPolicy, QoSPolicyKind, QoSProfile, ReliabilityPolicy
from rclpy.serialization import deserialize_message

from rai_missions.connectors.connector import Message, RawMessage
from rai_missions.connectors.ros2.messages import name_of, to_data
from rai_missions.connectors.ros2.options import Quality
from rai_missions.connectors.ros2.runtime import Runtime, guarded

__all__ = ("Publication", "Subscription", "profile")

log = logging.getLogger(__name__)

LOOKS_S = (1.0, 2.0, 7.0)
"""When it is asked why nothing is heard, each counted from the time before."""


def profile(quality: Quality, reliability: str = "reliable") -> QoSProfile:
    """A quality as rclpy has it."""
    is_reliable = (quality.reliability or reliability) == "reliable"
    is_latched = quality.durability == "latched"
    return QoSProfile(
        depth=quality.depth,
        reliability=ReliabilityPolicy.RELIABLE if is_reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if is_latched else DurabilityPolicy.VOLATILE,
    )


class Publication:
    """One topic that is published on. On the runtime's thread only.

    A new publisher is not yet known to the subscribers: what it said in that while would be lost. So its first messages
    wait for a subscriber, as many as the topic's depth and no longer than `patience_s`.

    A picture is made when it leaves: while nobody listens it is not made at all, and of those that wait for the first
    subscriber only the newest is.
    """

    def __init__(self, runtime: Runtime, topic: str, cls: Any, quality: Quality, patience_s: float) -> None:
        self._publisher = runtime.node.create_publisher(cls, topic, profile(quality))
        self._keeps = quality.durability == "latched"
        self._first: deque[Any] | None = deque(maxlen=quality.depth)
        self._picture: Callable[[], Any] | None = None
        runtime.when(self._is_known, patience_s, lambda _known: self._open())

    def _is_known(self) -> bool:
        return bool(self._publisher.get_subscription_count())

    def _open(self) -> None:
        first, self._first = self._first or (), None
        for message in first:
            self._publisher.publish(message)
        if self._picture is not None:
            self.publish_later(self._picture)
            self._picture = None

    def publish(self, message: Any) -> None:
        if self._first is None:
            self._publisher.publish(message)
        else:
            self._first.append(message)

    def publish_later(self, make: Callable[[], Any]) -> None:
        """Publish a picture, if anybody may see it."""
        if self._first is not None:
            self._picture = make
        elif self._keeps or self._is_known():
            self._publisher.publish(make())


class Subscription:
    """One listener of a topic. Made and destroyed on the runtime's thread; closed from any.

    Args:
        runtime: Where it lives.
        topic: Its name.
        cls: The message's class.
        quality: How messages travel; where it leaves the reliability open, it is what the publisher offers.
        hear: Whom to tell.
        at_of: When a message was so, on the run's clock.
        hear_raw: Whom to tell of its bytes, before.
    """

    def __init__(
        self, runtime: Runtime, topic: str, cls: Any, *, quality: Quality, hear: Callable[[Message], None],
        at_of: Callable[[Any], float], hear_raw: Callable[[RawMessage], None] | None = None,
    ) -> None:  # fmt: skip
        self._runtime, self._topic, self._class, self._quality = runtime, topic, cls, quality
        self._hear, self._at_of, self._hear_raw = hear, at_of, hear_raw
        self._is_open = True
        self._entity: Any = None
        self._is_puzzled = self._is_fitted = self._is_heard = False
        runtime.post(lambda: self._listen("reliable"))
        runtime.post(lambda: self._look_after(LOOKS_S))

    def close(self) -> None:
        """Nothing more is heard from this moment on."""
        self._is_open = False
        self._runtime.post(self._leave)

    def _listen(self, reliability: str) -> None:
        if not self._is_open:
            return
        events = SubscriptionEventCallbacks(incompatible_qos=self._misfits)
        self._entity = self._runtime.node.create_subscription(
            self._class, self._topic, self._heard, profile(self._quality, reliability),
            callback_group=self._runtime.group, event_callbacks=events, raw=self._hear_raw is not None,
        )  # fmt: skip

    def _leave(self) -> None:
        if self._entity is not None:
            self._runtime.node.destroy_subscription(self._entity)
            self._entity = None

    def _look_after(self, waits: tuple[float, ...]) -> None:
        """Say it if what is published there is of another type: ROS itself keeps silent."""

        def look() -> None:
            if self._is_heard or not self._is_open:
                return
            name, found = name_of(self._class), self._runtime.node.get_publishers_info_by_topic(self._topic)
            others = sorted({each.topic_type for each in found} - {name})
            if others:
                log.warning("%s is published as %s, and so not heard as the %s that is asked for; mend the type",
                            self._topic, " and ".join(others), name)  # fmt: skip
            else:
                self._look_after(waits[1:])

        if waits:
            self._runtime.later(waits[0], look)

    def _misfits(self, found: Any) -> None:
        """A publisher offers less than is asked for, and would never be heard."""
        if self._is_fitted:
            return
        if found.last_policy_kind == QoSPolicyKind.RELIABILITY and self._quality.reliability is None:
            self._is_fitted = True
            log.info("%s is published with best effort, and is heard so", self._topic)
            self._runtime.post(self._leave)
            self._runtime.post(lambda: self._listen("best_effort"))
        elif not self._is_puzzled:
            self._is_puzzled = True
            policy = QoSPolicyKind(found.last_policy_kind).name.lower()
            log.warning(
                "a publisher of %s offers less %s than the profile asks for and is not heard; mend connector/qos/%s",
                self._topic, policy, self._topic,
            )  # fmt: skip

    def _heard(self, message: Any) -> None:
        """A message has come; in bytes, where somebody wants them."""
        self._is_heard = True
        if self._is_open:
            hear_raw, wire = self._hear_raw, message
            if hear_raw is not None:
                message = deserialize_message(wire, self._class)
            at = self._at_of(message)
            if hear_raw is not None:
                guarded(lambda: hear_raw(RawMessage(self._topic, name_of(self._class), wire, at)))
            data = to_data(message, f"{self._topic}@{at:.3f}")
            guarded(lambda: self._hear(Message(self._topic, data, at)))
