# SPDX-License-Identifier: Apache-2.0
"""Where everything that happens to a run arrives, from any thread.

Rule: an event waits in the order of its arrival; an urgent one overtakes, and of the robot's facts only the newest of
each key waits where far too much does.
"""

from __future__ import annotations

import queue
import threading
from collections import deque
from collections.abc import Callable
from typing import Any

from rai_missions.event import Event
from rai_missions.image import Image

__all__ = ("Mailbox",)

LONGEST_WAIT_S = 86_400.0
"""A wait for longer ends early and begins again: threads cannot wait for centuries."""
MOST_BEFORE_PICTURE, MOST_BEFORE_WRITE = 200, 100_000
"""Events that may wait before of a key only its newest picture, or any other newest value, is kept."""


class Mailbox:
    """Events on their way to the runner, from any thread, in the order in which they came; urgent ones overtake.

    Args:
        clean: Takes out of an event's data secrets, as it is taken.
        now: The run's clock. With it each event gets the instant at which it enters here, in the order in which they
            enter: once the mailbox is seen empty, no event comes that is older than the clock's time before.
        on_urgent: Called for each urgent event, once it is here, on the thread that brings it.
    """

    def __init__(
        self,
        clean: Callable[[Any], Any] | None = None,
        now: Callable[[], float] | None = None,
        on_urgent: Callable[[], None] = lambda: None,
    ) -> None:
        self._clean, self._now, self._on_urgent = clean, now, on_urgent
        self._drops: list[Callable[[Event], bool]] = []
        self._entrance = threading.RLock()  # a signal may come on the thread that is posting
        self._queue: queue.SimpleQueue[Event | None] = queue.SimpleQueue()
        self._urgent: deque[Event] = deque()
        self._front: deque[Event] = deque()
        self._late: dict[str, Event] = {}
        """Key → its newest value of those that came while far too much waited; taken once nothing else waits."""

    def drop_if(self, is_overdue: Callable[[Event], bool]) -> None:
        """From now on, drop an event that comes to be taken and has waited too long.

        Args:
            is_overdue: Whether it has; where it has, its sender has been answered.
        """
        self._drops.append(is_overdue)

    def post(self, event: Event) -> None:
        """Put it behind what waits; of what the robot reports of a key while far too much does, the newest is kept."""
        with self._entrance:
            self._enter(event if self._now is None else event.moved(self._now()))

    def _enter(self, event: Event) -> None:
        if event.kind != "write":
            self._queue.put(event)
        elif self._queue.qsize() < _most(event):
            self._late.pop(event.name, None)
            self._queue.put(event)
        else:
            self._late[event.name] = event
            if self._queue.empty():
                self.wake()  # all was taken meanwhile, and the thread that waits was not woken

    def post_urgent(self, event: Event) -> None:
        """Post an event that is taken next, whatever waits."""
        self._urgent.append(event)
        self._queue.put(None)
        self._on_urgent()

    def wake(self) -> None:
        """End a wait without an event."""
        self._queue.put(None)

    def take(self) -> Event | None:
        """The next event; None if there is none now."""
        event = self._next()
        while event is not None and self._drops and any(is_overdue(event) for is_overdue in self._drops):
            event = self._next()
        if event is None or self._clean is None:
            return event
        clean = self._clean(event.data)
        return event if clean is event.data else event._replace(data=clean)

    def _next(self) -> Event | None:
        if self._urgent:
            return self._urgent.popleft()
        if self._front:
            return self._front.popleft()
        while True:
            try:
                event = self._queue.get_nowait()
            except queue.Empty:
                return self._next_late()
            if event is not None:
                return event
            if self._urgent:
                return self._urgent.popleft()

    def _next_late(self) -> Event | None:
        return self._late.pop(next(iter(tuple(self._late)), ""), None)  # it may have been overtaken just now

    @property
    def urgent(self) -> bool:
        """What is taken next must not wait."""
        return bool(self._urgent)

    @property
    def waiting(self) -> int:
        """About how many events are to be taken."""
        return len(self._urgent) + len(self._front) + self._queue.qsize() + len(self._late)

    def put_back(self, events: list[Event]) -> None:
        """Put events in front of all but the urgent ones, in this order."""
        self._front.extendleft(reversed(events))

    @property
    def empty(self) -> bool:
        return not self._urgent and not self._front and self._queue.empty() and not self._late

    def wait(self, timeout_s: float | None) -> None:
        """Return when something has come, or after so many seconds of wall time; None waits for ever."""
        if self._urgent or self._front or self._late:
            return
        if timeout_s is not None:
            timeout_s = min(timeout_s, LONGEST_WAIT_S)
        try:
            event = (
                self._queue.get(timeout=timeout_s) if timeout_s is None or timeout_s > 0 else self._queue.get_nowait()
            )
        except queue.Empty:
            return
        if event is not None:
            self._front.append(event)


def _most(event: Event) -> int:
    return MOST_BEFORE_PICTURE if isinstance(event.data.get("value"), Image) else MOST_BEFORE_WRITE
