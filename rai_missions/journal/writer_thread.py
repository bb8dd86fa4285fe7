# SPDX-License-Identifier: Apache-2.0
"""Waits for the disk on a run's behalf, so that a disk which hangs holds up no emergency stop.

Rule: anyone who hands something over continues only when it is written, just as if it had written it itself.
"""

from __future__ import annotations

import queue
import time
from collections.abc import Callable

from rai_missions.connectors.worker import Worker
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
        self._called, self._worker = called, Worker("journal")
        self._bell: queue.SimpleQueue[bool] = queue.SimpleQueue()
        """Rings when something is written, and with True when `call` is called."""
        self._is_lost = False

    def do(self, write: Callable[[], object]) -> None:
        """Have something written, and wait until it is; raises what writing it raises.

        Raises:
            ConnectorError: It took too long. Whether it was written is not known, and nothing more will be.
        """
        if self._is_lost:
            raise ConnectorError(self._why)
        until = time.monotonic() + LONGEST_S
        written = self._worker.submit(write)
        written.add_done_callback(lambda _: self._bell.put(False))
        while not written.done():
            if self._rings(until):
                self._called()
        written.result()

    def call(self) -> None:
        """Wake the one that waits; from any thread."""
        self._bell.put(True)

    def close(self) -> None:
        """Nothing more is to be written; a disk that hangs is not waited for."""
        self._worker.close(0.0 if self._is_lost else LONGEST_S)

    @property
    def _why(self) -> str:
        return f"its disk has not answered for {LONGEST_S:g} s"

    def _rings(self, until: float) -> bool:
        """Wait for the bell; whether it is for `called`."""
        try:
            return self._bell.get(timeout=max(0.0, until - time.monotonic()))
        except queue.Empty:
            self._is_lost = True
            raise ConnectorError(self._why) from None
