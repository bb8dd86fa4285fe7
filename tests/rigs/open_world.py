# SPDX-License-Identifier: Apache-2.0
"""A world on a connector in this process, and all that it publishes on some topics."""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import Any

from rai_missions.connectors.connector import Message, Reply
from rai_missions.connectors.local import LocalConnector
from rai_missions.worlds import open_world

__all__ = ("OpenWorld",)


class OpenWorld:
    """A world that a test opens and steps.

    Args:
        name: The name of the world.
        topics: Those that are received.
        options: The world's.
    """

    def __init__(self, name: str, topics: Iterable[str], **options: Any) -> None:
        self.world: Any = open_world(name, **options)
        self.connector = LocalConnector(now=lambda: self.world.at)
        self.received: dict[str, list[Message]] = {topic: [] for topic in topics}
        for topic, messages in self.received.items():
            self.connector.subscribe(topic, "", messages.append)
        self.world.open(self.connector)
        self.connector.start()

    def step(self, seconds: float) -> None:
        for _ in range(round(seconds / self.world.period_s)):
            self.world.step()

    def facts(self, topic: str) -> list[Any]:
        """What was published there as JSON."""
        return [json.loads(message.data["data"]) for message in self.received[topic]]

    def call(self, service: str, request: dict[str, Any]) -> Reply:
        replies: list[Reply] = []
        self.connector.call(service, "", request, timeout_s=5.0, on_reply=replies.append)
        return replies[0]
