# SPDX-License-Identifier: Apache-2.0
"""Several runs in one process that take turns on one simulated clock, so that what they do is the same every time.

Rule: each run has a thread of its own, and at any moment one thread moves: a run until it waits, or the world.
"""

from __future__ import annotations

import heapq
import itertools
import math
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager

import pytest

from rai_missions.engine.semantics import macrostep, timing
from rai_missions.runtime.clock import Clock
from rai_missions.runtime.mailbox import Mailbox

__all__ = ("Seat", "Turns", "sooner_ended")

PATIENCE_S = 30.0
MOST_AT_ONCE, RESTS_S = 100, 0.25
"""So many events that a run may take in one instant, and for how long it rests then."""


@contextmanager
def sooner_ended() -> Iterator[None]:
    """What goes round for ever is found sooner."""
    with pytest.MonkeyPatch.context() as limits:
        for module in (macrostep, timing):
            limits.setattr(module, "MOST_MICROSTEPS", 100)
        yield


class Seat:
    """The clock of one run, whose waits give the turn back.

    Args:
        turns: Whose time it is.
    """

    def __init__(self, turns: Turns) -> None:
        self._turns = turns
        self._mine, self._back = threading.Semaphore(0), threading.Semaphore(0)
        self._mailbox: Mailbox | None = None
        self._taken = (0.0, 0)
        self.until = -math.inf
        """When it is to be woken at the latest."""
        self.is_over = False
        self.is_left = False
        """It gets no turn any more: it hangs."""
        self.error: BaseException | None = None

    # -- the clock, on the run's thread -------------------------------------------------------------------------------

    def now(self) -> float:
        return self._turns.at

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        self._rest(mailbox, until)
        mailbox.wait(0.0)

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        """A run that goes round in one instant gives time a chance to move, as `SimulatedClock` does."""
        at, count = self._taken
        self._taken = (self.now(), count + 1 if at == self.now() else 1)
        if self._taken[1] >= MOST_AT_ONCE:
            self._rest(None, self.now() + RESTS_S)

    def _rest(self, mailbox: Mailbox | None, until: float) -> None:
        self._mailbox, self.until = mailbox, until
        self._back.release()
        self._mine.acquire()

    # -- on the thread of the world -----------------------------------------------------------------------------------

    def seat(self, run: Callable[[], object]) -> None:
        """Give a run this clock; it begins with its first turn."""

        def live() -> None:
            self._mine.acquire()
            try:
                run()
            except BaseException as error:  # noqa: BLE001 - how a run dies is the test's affair
                self.error = error
            finally:
                self.is_over = True
                self._back.release()

        threading.Thread(target=live, daemon=True).start()

    @property
    def is_due(self) -> bool:
        """It has something to do now."""
        has_news = self._mailbox is not None and not self._mailbox.empty
        return not (self.is_over or self.is_left) and (has_news or self.until <= self._turns.at)

    def turn(self) -> None:
        """Let the run do what it has to do, until it waits or is over."""
        self.until = math.inf
        self._mine.release()
        assert self._back.acquire(timeout=PATIENCE_S), "the run neither waits nor ends"


class Turns:
    """Time, the runs that live in it, and what is to happen when."""

    def __init__(self) -> None:
        self.at = 0.0
        self._seats: list[Seat] = []
        self._moments: list[tuple[float, int, Callable[[], object]]] = []
        self._order = itertools.count()
        self.settle: Callable[[], object] = lambda: None
        """Called after each turn: what other threads make of it is over before the next, and before time moves."""

    def now(self) -> float:
        return self.at

    def call_at(self, at: float, do: Callable[[], object]) -> None:
        """Have something happen at an instant; what is to happen at the same one keeps the order of the calls."""
        heapq.heappush(self._moments, (max(at, self.at), next(self._order), do))

    def call_later(self, seconds: float, do: Callable[[], object]) -> None:
        self.call_at(self.at + seconds, do)

    def begin(self, make: Callable[[Clock], Callable[[], object]]) -> Seat:
        """Begin another run, now.

        Args:
            make: Makes a run on the clock that it is given.
        """
        seat = Seat(self)
        seat.seat(make(seat))
        self._seats.append(seat)
        return seat

    def play(self, until: float) -> None:
        """Let time pass until then, or until every run is over."""
        while not all(seat.is_over or seat.is_left for seat in self._seats) or self._moments:
            for seat in tuple(self._seats):
                if seat.is_due:
                    seat.turn()
                    self.settle()
            if any(seat.is_due for seat in self._seats):
                continue
            due = min([seat.until for seat in self._seats if not (seat.is_over or seat.is_left)], default=math.inf)
            then = min(due, self._moments[0][0] if self._moments else math.inf)
            if then > until:
                return
            self.at = max(self.at, then)
            while self._moments and self._moments[0][0] <= self.at:  # all of an instant, before anyone looks
                heapq.heappop(self._moments)[2]()
