# SPDX-License-Identifier: Apache-2.0
"""How far a long piece of work is, on stderr: a line that is updated on a terminal, else a line now and then.

Rule: what is quick shows nothing; what was shown on a terminal is removed at the end; stdout is never touched.
"""

from __future__ import annotations

import shutil
import sys
import time
from collections.abc import Callable
from typing import TextIO

from rai_missions.cli.output import terminal_of
from rai_missions.connectors.worker import Worker

__all__ = ("LongWork", "WorkPace")

UPDATED_S = 0.25
"""Seconds between two looks on a terminal; what ends before the first shows nothing."""
LINE_S = 10.0
"""Seconds between two lines elsewhere."""
ERASE = "\r\x1b[2K"


class WorkPace:
    """How much is done, and how fast.

    Args:
        now: The wall's clock, in seconds.
    """

    def __init__(self, now: Callable[[], float] = time.monotonic) -> None:
        self._now, self._began = now, now()
        self.done = self.total = 0
        """`total`: what there is to do, or was found so far; 0 where it is not known yet."""

    def set(self, done: int, total: int) -> None:
        """Set how much is done, and of how much."""
        self.done, self.total = done, total

    @property
    def elapsed_s(self) -> float:
        return self._now() - self._began

    @property
    def rate(self) -> float:
        """Done a second."""
        return self.done / self.elapsed_s if self.elapsed_s > 0 else 0.0

    @property
    def percent(self) -> int:
        return 100 * self.done // self.total if self.total else 0


class LongWork:
    """Shows how far a piece of work is while it lasts; a context manager.

    Args:
        words: How far it is; called on a thread of its own.
        out: Where it is shown; stderr, if not given.
    """

    def __init__(self, words: Callable[[], str], out: TextIO | None = None) -> None:
        self._words, self._out = words, terminal_of(out if out is not None else sys.stderr)
        self._is_terminal = self._out.isatty()
        self._is_shown = False
        self._worker = Worker("long work")

    def __enter__(self) -> LongWork:
        self._worker.every(UPDATED_S if self._is_terminal else LINE_S, self.show)
        return self

    def __exit__(self, *_: object) -> None:
        self._worker.close()
        if self._is_shown and self._is_terminal:
            self._out.write(ERASE)
            self._out.flush()

    def show(self) -> None:
        """Show it now."""
        text = self._words()
        if self._is_terminal:
            text = ERASE + text[: max(1, shutil.get_terminal_size().columns - 1)]
        self._out.write(text if self._is_terminal else f"{text}\n")
        self._out.flush()
        self._is_shown = True
