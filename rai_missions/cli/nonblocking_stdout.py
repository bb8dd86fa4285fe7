# SPDX-License-Identifier: Apache-2.0
"""Printing that nobody waits for: a terminal that takes nothing any more holds up no run and no emergency stop.

Rule: what is printed comes in its order, or is left out and counted.
"""

from __future__ import annotations

import io
import queue
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from typing import TextIO, cast

__all__ = ("MOST", "Aside", "nonblocking_stdout", "settled")

MOST = 2_000
"""So many pieces of text wait to be taken; what is printed beyond is left out."""


class Aside(io.TextIOBase):
    """Text on its way to a terminal, a file or a pipe, on a thread of its own.

    Args:
        out: Where it goes.
    """

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._texts: queue.SimpleQueue[str | None] = queue.SimpleQueue()
        self._lost = 0
        self.fault: Exception | None = None
        """What printing has raised; nothing more is printed then."""
        self._thread = threading.Thread(target=self._write_on, name="printing", daemon=True)
        self._thread.start()

    def write(self, text: str) -> int:
        """Have it printed; raises what printing has raised before."""
        if self.fault is not None:
            raise self.fault
        if not self._thread.is_alive():
            return self._out.write(text)
        if self._texts.qsize() < MOST:
            self._texts.put(f"{self._left_out()}{text}" if self._lost else text)
        else:
            self._lost += 1
        return len(text)

    def flush(self) -> None:
        """It goes out as soon as it is taken."""
        if not self._thread.is_alive():
            self._out.flush()

    def settle(self) -> None:
        """Wait until all of it is out; what is printed later is waited for."""
        self._texts.put(None)
        self._thread.join()
        if self._lost and self.fault is None:
            self._out.write(self._left_out())

    def isatty(self) -> bool:
        return self._out.isatty()

    def fileno(self) -> int:
        return self._out.fileno()

    def writable(self) -> bool:
        return True

    @property
    def encoding(self) -> str:  # type: ignore[override]
        return self._out.encoding

    @property
    def errors(self) -> str | None:  # type: ignore[override]
        return self._out.errors

    def _write_on(self) -> None:
        while (text := self._texts.get()) is not None:
            try:
                self._put(text)
            except Exception as error:  # noqa: BLE001 - raised where the next text is printed
                self.fault = self.fault or error

    def _put(self, text: str) -> None:
        if self.fault is not None:
            return
        self._out.write(text)
        if self._texts.empty():
            self._out.flush()

    def _left_out(self) -> str:
        lost, self._lost = self._lost, 0
        return f"\n… {lost} pieces of text are left out, since nobody took them\n"


def settled() -> None:
    """Nothing is under way any more that printing could hold up: from now on all that is printed is waited for."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, Aside):
            stream.settle()


@contextmanager
def nonblocking_stdout() -> Iterator[None]:
    """What is printed meanwhile is waited for at the end only."""
    out, error = Aside(sys.stdout), Aside(sys.stderr)
    with redirect_stdout(cast(TextIO, out)), redirect_stderr(cast(TextIO, error)):
        try:
            yield
        finally:
            out.settle()
            error.settle()
    if out.fault is not None:
        raise out.fault
