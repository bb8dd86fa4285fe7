# SPDX-License-Identifier: Apache-2.0
"""Gives up questions whose time is over, whatever those who think about them do."""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

from rai_missions.answerers.model.pending import Pending

__all__ = ("DeadlineWatch",)


class DeadlineWatch:
    """One thread that sleeps until the next question's end; it lives only while questions are open."""

    def __init__(self) -> None:
        self._open: list[tuple[Pending, Callable[[], None]]] = []
        self._changed = threading.Condition()
        self._thread: threading.Thread | None = None

    def add(self, pending: Pending, give_up: Callable[[], None]) -> None:
        """Call `give_up` once the question's time is over, unless it is closed by then."""
        with self._changed:
            self._open.append((pending, give_up))
            if self._thread is None:
                self._thread = threading.Thread(target=self._sleep, name="deadlines", daemon=True)
                self._thread.start()
            self._changed.notify()

    def look(self) -> None:
        """A question was closed: there may be nothing left to wait for."""
        with self._changed:
            self._changed.notify()

    def _sleep(self) -> None:
        while due := self._due():
            for give_up in due:
                give_up()

    def _due(self) -> list[Callable[[], None]]:
        """Wait until something is due; empty once nothing is open."""
        with self._changed:
            while True:
                self._open = [(pending, give_up) for pending, give_up in self._open if pending.open]
                if not self._open:
                    self._thread = None
                    return []
                now = time.monotonic()
                due = [give_up for pending, give_up in self._open if pending.ends <= now]
                if due:
                    return due
                ends = min(pending.ends for pending, _ in self._open)
                self._changed.wait(None if math.isinf(ends) else min(ends - now, threading.TIMEOUT_MAX))
