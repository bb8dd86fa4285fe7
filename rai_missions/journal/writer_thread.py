# SPDX-License-Identifier: Apache-2.0
"""Waits for the disk on a run's behalf, so that a disk which hangs holds up no emergency stop.

Rule: anyone who hands something over continues only when it is written, just as if it had written it itself.
"""

from __future__ import annotations

import queue
import threading
import time
from collections.abc import Callable

from rai_missions.errors import ConnectorError

__all__ = ("LONGEST_S", "WriterThread")

LONGEST_S = 10.0
"""A disk that has not taken a row by then is one that cannot be written."""


class WriterThread:
    """Writes on a thread of its own, which it has from the first writing to `close`.

    Args:
        called: Done by the one that waits, at once, when `call` is.
    """

    def __init__(self, called: Callable[[], None]) -> None:
        self._called = called
        self._work: queue.SimpleQueue[Callable[[], None] | None] = queue.SimpleQueue()
        self._bell: queue.SimpleQueue[tuple[int, BaseException | None]] = queue.SimpleQueue()
        self._thread: threading.Thread | None = None
        self._is_lost = False
        self._ticket = 0

    def do(self, write: Callable[[], object]) -> None:
        """Have something written, and wait until it is; raises what writing it raises.

        Raises:
            ConnectorError: It took too long. Whether it was written is not known, and nothing more will be.
        """
        if self._is_lost:
            raise ConnectorError(self._why)
        if self._thread is None:
            self._thread = threading.Thread(target=self._write_on, name="journal", daemon=True)
            self._thread.start()
        self._ticket += 1
        ticket, until = self._ticket, time.monotonic() + LONGEST_S
        self._work.put(lambda: self._write(write, ticket))
        task = self._next_task(until)
        while task[0] != ticket:
            if task[0] == CALL:
                self._called()
            task = self._next_task(until)
        if task[1] is not None:
            raise task[1]

    def call(self) -> None:
        """Wake the one that waits; from any thread."""
        self._bell.put((CALL, None))

    def close(self) -> None:
        """Nothing more is to be written; a disk that hangs is not waited for."""
        self._work.put(None)
        if self._thread is not None and not self._is_lost:
            self._thread.join(LONGEST_S)

    @property
    def _why(self) -> str:
        return f"its disk has not answered for {LONGEST_S:g} s"

    def _next_task(self, until: float) -> tuple[int, BaseException | None]:
        try:
            return self._bell.get(timeout=max(0.0, until - time.monotonic()))
        except queue.Empty:
            self._is_lost = True
            raise ConnectorError(self._why) from None

    def _write_on(self) -> None:
        while (work := self._work.get()) is not None:
            work()

    def _write(self, write: Callable[[], object], ticket: int) -> None:
        try:
            write()
        except BaseException as error:  # noqa: BLE001 - raised again where it was handed over
            self._bell.put((ticket, error))
        else:
            self._bell.put((ticket, None))


CALL = 0
