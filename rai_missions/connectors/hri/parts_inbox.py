# SPDX-License-Identifier: Apache-2.0
"""The parts that a topic receives, joined: from any thread, and in time.

Rule: no lock is held while what was received is passed on.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable
from functools import partial

from rai_missions.connectors.hri.assembly import Assembly, ReceivedMessage
from rai_missions.connectors.hri.message import HRIMessage
from rai_missions.connectors.worker import SerialQueue, Work

__all__ = ("PartsInbox",)


class PartsInbox:
    """Joins parts, and looks again when one is overdue.

    Args:
        assembly: Joins them.
        on_received: Receives each message and each report, one after the other.
        now: Seconds on a clock that does not go back.
        later: Has something done so many seconds from now, and returns what cancels it.
    """

    def __init__(
        self,
        assembly: Assembly,
        on_received: Callable[[ReceivedMessage], object],
        now: Callable[[], float],
        later: Callable[[float, Work], Work],
    ) -> None:
        self._assembly, self._on_received, self._now, self._later = assembly, on_received, now, later
        self._lock = threading.Lock()
        self._queue = SerialQueue()
        self._cancel: Work = lambda: None
        self._due: float | None = None
        self._is_closed = False

    def add(self, part: HRIMessage) -> None:
        """Take a part that was received now."""
        with self._lock:
            self._pass(self._assembly.add(part, self._now()))
        self._queue.run()

    def close(self) -> None:
        """Report what is incomplete, and pass nothing on any more."""
        with self._lock:
            self._cancel()
            self._pass(self._assembly.leave())
            self._is_closed = True
        self._queue.run()

    def _look(self) -> None:
        with self._lock:
            self._due = None
            self._pass(self._assembly.expire(self._now()))
        self._queue.run()

    def _pass(self, found: Iterable[ReceivedMessage]) -> None:
        """The lock is held: what is found is queued, and passed on once it is not."""
        for each in () if self._is_closed else found:
            self._queue.put(partial(self._on_received, each))
        due = self._assembly.due
        if due is not None and not self._is_closed and (self._due is None or due < self._due):
            self._cancel()
            self._due = due
            self._cancel = self._later(max(0.0, due - self._now()), self._look)
