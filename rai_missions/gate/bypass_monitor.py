# SPDX-License-Identifier: Apache-2.0
"""Who else publishes to the actuators: what they state reaches them past the gate, no matter who holds control.

Rule: looking never waits on the gate's own threads, and stops nothing; it is for a person to mend.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable

from rai_missions.connectors.connector import Connector, SupportsDiscoveryCount
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
        reported: Is notified of a topic once when others are there, and again after they were gone: topic and how many.
    """

    def __init__(self, connector: Connector, topics: Iterable[str], on_change: Callable[[str, int], None]) -> None:
        self._connector, self._topics, self._on_change = connector, tuple(topics), on_change
        self._known: frozenset[str] = frozenset()
        self._is_over = threading.Event()
        self._thread: threading.Thread | None = None

    def look(self) -> None:
        """Count them now."""
        if not isinstance(self._connector, SupportsDiscoveryCount):
            return
        counts = self._connector.offered("topics")
        others = {topic: counts[topic] - 1 for topic in self._topics if counts.get(topic, 0) > 1}
        for topic in others.keys() - self._known:
            self._on_change(topic, others[topic])
        self._known = frozenset(others)

    def run(self) -> None:
        """Begin on a thread of its own; returns at once."""
        if self._thread is None:
            self._is_over.clear()
            self._thread = threading.Thread(target=self._watch, name="next to the gate", daemon=True)
            self._thread.start()

    def stop(self) -> None:
        """Look no more."""
        self._is_over.set()
        thread, self._thread = self._thread, None
        if thread is not None:
            thread.join()

    def _watch(self) -> None:
        while not self._is_over.wait(LOOK_S):
            try:
                self.look()
            except ConnectorError as fault:
                log.info("no one could be counted: %s", fault)
