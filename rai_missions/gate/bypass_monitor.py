# SPDX-License-Identifier: Apache-2.0
"""Who else publishes to the actuators: their messages reach them past the gate, no matter who holds control.

Rule: looking never waits on the gate's own threads, and stops nothing; it is for a person to mend.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from rai_missions.connectors.connector import Connector, SupportsDiscoveryCount
from rai_missions.connectors.worker import Worker
from rai_missions.errors import ConnectorError
from rai_missions.redaction import logger

__all__ = ("BypassMonitor",)

log = logger(__name__)

LOOK_S = 2.0
"""Seconds between two looks; also how long anyone who is there already may take to be found."""


class BypassMonitor:
    """Looks for others on the gate's topics, an `Agent`.

    Args:
        connector: The gate's; where it cannot determine who is there, no one is found.
        topics: The actuators', each of which the gate publishes on itself.
        on_change: Called once when others appear on a topic, and again after they were gone: topic and how many.
    """

    def __init__(self, connector: Connector, topics: Iterable[str], on_change: Callable[[str, int], None]) -> None:
        self._connector, self._topics, self._on_change = connector, tuple(topics), on_change
        self._known: frozenset[str] = frozenset()
        self._worker = Worker("bypass monitor")

    def look(self) -> None:
        """Count them now."""
        if not isinstance(self._connector, SupportsDiscoveryCount):
            return
        try:
            counts = self._connector.offered("topics")
        except ConnectorError as fault:
            log.info("no one could be counted: %s", fault)
            return
        others = {topic: counts[topic] - 1 for topic in self._topics if counts.get(topic, 0) > 1}
        for topic in (each for each in others if each not in self._known):
            self._on_change(topic, others[topic])
        self._known = frozenset(others)

    def run(self) -> None:
        """Begin on a thread of its own; returns at once."""
        if not self._worker.is_alive:
            self._worker.start()
            self._worker.every(LOOK_S, self.look)

    def stop(self) -> None:
        """Look no more."""
        self._worker.close()
