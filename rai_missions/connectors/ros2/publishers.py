# SPDX-License-Identifier: Apache-2.0
"""Publish: publishers that do not lose their first words."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Any

from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy

from rai_missions.connectors.ros2.config import QosProfile
from rai_missions.connectors.ros2.node_thread import Runtime

__all__ = ("Publication", "profile")


def profile(quality: QosProfile, reliability: str = "reliable") -> QoSProfile:
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

    A new publisher is not yet known to the subscribers: what it reported in that while would be lost. So its first
    messages wait for a subscriber, as many as the topic's depth and no longer than `patience_s`.

    A picture is made when it leaves: while no client listens it is not made at all, and of those that wait for the
    first subscriber only the newest is.
    """

    def __init__(self, runtime: Runtime, topic: str, cls: Any, quality: QosProfile, patience_s: float) -> None:
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
