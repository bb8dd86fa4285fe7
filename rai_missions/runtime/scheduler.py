# SPDX-License-Identifier: Apache-2.0
"""What is done on a run's thread, and when: at an instant of its clock, or before its next event.

Rule: from any thread only `post`, `call_soon`, `call_later`, `wake` and `now`; the rest belongs to the run's own.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections import deque
from collections.abc import Callable

from rai_missions.event import Event
from rai_missions.runtime.clock import Clock
from rai_missions.runtime.mailbox import Mailbox

__all__ = ("Scheduler",)


class Scheduler:
    """A run's agenda.

    Args:
        clock: The run's time.
        mailbox: Where its events arrive, and where it waits.
    """

    def __init__(self, clock: Clock, mailbox: Mailbox) -> None:
        self.clock, self.mailbox = clock, mailbox
        self._at: list[tuple[float, int, Callable[[], None]]] = []
        self._order = itertools.count()
        self._soon: deque[Callable[[], None]] = deque()

    def now(self) -> float:
        """Seconds on the run's clock."""
        return self.clock.now()

    def post(self, event: Event) -> None:
        """Something has happened; from any thread."""
        self.mailbox.post(event)

    def wake(self) -> None:
        """Have the run look again at what it waits for; from any thread."""
        self.mailbox.wake()

    def call_soon(self, do: Callable[[], None]) -> None:
        """Have something done on the run's thread, before its next event; from any thread."""
        self._soon.append(do)
        self.mailbox.wake()

    def call_at(self, at: float, do: Callable[[], None]) -> None:
        """Have something done at an instant of the run's clock."""
        heapq.heappush(self._at, (at, next(self._order), do))

    def call_later(self, seconds: float, do: Callable[[], None]) -> None:
        """Have something done on the run's thread after so many seconds of its clock; from any thread."""
        self.call_soon(lambda: self.call_at(self.now() + seconds, do))

    @property
    def due(self) -> float:
        """The instant at which something is to be done; minus infinity where it is now, infinity where nothing is."""
        if self._soon:
            return -math.inf
        return self._at[0][0] if self._at else math.inf

    def run_due(self) -> None:
        """Do what is asked for, and what the time has come for."""
        while self._soon:
            self._soon.popleft()()
        now = self.clock.now()
        while self._at and self._at[0][0] <= now:
            heapq.heappop(self._at)[2]()
