# SPDX-License-Identifier: Apache-2.0
"""Where time comes from, and the mailbox that everything arrives in.

Rule: nobody sleeps and nobody polls; a run waits in one place, for an event or for an instant.
"""

from __future__ import annotations

import math
import queue
import time
from collections import deque
from collections.abc import Callable
from typing import Protocol

from rai_missions.event import Event

__all__ = ("Clock", "Mailbox", "SimulatedClock", "Steppable", "WallClock")


class Mailbox:
    """Events on their way to the runner, from any thread, in the order in which they came; urgent ones overtake."""

    def __init__(self) -> None:
        self._queue: queue.SimpleQueue[Event | None] = queue.SimpleQueue()
        self._urgent: deque[Event] = deque()
        self._front: deque[Event] = deque()

    def post(self, event: Event) -> None:
        self._queue.put(event)

    def post_urgent(self, event: Event) -> None:
        """It is taken next, whatever waits."""
        self._urgent.append(event)
        self._queue.put(None)

    def wake(self) -> None:
        """End a wait without an event."""
        self._queue.put(None)

    def take(self) -> Event | None:
        """The next event; None if there is none now."""
        if self._urgent:
            return self._urgent.popleft()
        if self._front:
            return self._front.popleft()
        while True:
            try:
                event = self._queue.get_nowait()
            except queue.Empty:
                return None
            if event is not None:
                return event
            if self._urgent:
                return self._urgent.popleft()

    @property
    def empty(self) -> bool:
        return not self._urgent and not self._front and self._queue.empty()

    def wait(self, timeout_s: float | None) -> None:
        """Return when something has come, or after so many seconds of wall time; None waits for ever."""
        if self._urgent or self._front:
            return
        try:
            event = self._queue.get(timeout=timeout_s) if timeout_s is None or timeout_s > 0 else self._queue.get_nowait()
        except queue.Empty:
            return
        if event is not None:
            self._front.append(event)


class Clock(Protocol):
    """The run's clock, in seconds from its start."""

    def now(self) -> float: ...

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        """Return when the mailbox holds something, or at an instant.

        Args:
            mailbox: Where events come.
            until: An instant on this clock; infinity for none.
            paced: A model or a person is thinking: time goes no faster than on the wall.
        """


class WallClock:
    """Real time, as `time.monotonic` counts it."""

    def __init__(self) -> None:
        self._start = time.monotonic()

    def now(self) -> float:
        return time.monotonic() - self._start

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        mailbox.wait(None if until == math.inf else max(0.0, until - self.now()))


class Steppable(Protocol):
    """What a simulated clock moves: a world."""

    at: float
    period_s: float

    def step(self) -> None: ...


class SimulatedClock:
    """Time that moves only when nothing waits to be dealt with.

    Args:
        world: Stepped as time moves; without one time jumps to the next instant that anybody waits for.
        speed: Simulated seconds to one of the wall at the most; infinity for as fast as it goes.
    """

    def __init__(self, world: Steppable | None = None, speed: float = math.inf) -> None:
        self._world, self._speed = world, speed
        self._at = world.at if world is not None else 0.0
        self._pace: tuple[float, float, float] | None = None

    def now(self) -> float:
        return self._at

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        speed = min(self._speed, 1.0) if paced else self._speed
        if self._world is None and until == math.inf:
            mailbox.wait(None)
            return
        ahead = self._anchor(speed)
        while mailbox.empty and self._at < until:
            if speed != math.inf and (early_s := ahead(self._at)) > 0:
                mailbox.wait(early_s)
                continue
            self._advance(until)

    def _advance(self, until: float) -> None:
        if self._world is None:
            self._at = until
            return
        self._world.step()
        self._at = self._world.at

    def _anchor(self, speed: float) -> Callable[[float], float]:
        """How many seconds of the wall an instant lies ahead of its time."""
        if self._pace is None or self._pace[0] != speed:
            self._pace = (speed, time.monotonic(), self._at)
        _, wall, start = self._pace
        period_s = self._world.period_s if self._world is not None else 0.0
        return lambda at: wall + (at + period_s - start) / speed - time.monotonic()
