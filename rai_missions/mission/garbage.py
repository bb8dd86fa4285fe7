# SPDX-License-Identifier: Apache-2.0
"""Garbage collection while much is built at once, and while a mission runs.

Rule: a search for garbage visits all that is alive. What grows by much that stays, and in which hardly anything is
garbage, is searched rarely until it is built; what was built for a run, not while it runs.
"""

from __future__ import annotations

import gc
import threading
from collections.abc import Iterator
from contextlib import contextmanager

__all__ = ("few_collections", "set_apart")

FEW = (1_000_000, 50, 1000)
"""The thresholds meanwhile: objects until a search, and searches of one generation until one of the next."""

MUCH = 10_000
"""New objects from which on they join the oldest; fewer are searched, in a millisecond."""


class _Builders:
    """How many builders are at work, in all threads of the process."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._many = 0
        self._before: tuple[int, int, int] | None = None
        """The thresholds before the first of them; None where they stayed."""

    def begin(self) -> None:
        """One more is building."""
        with self._lock:
            self._many += 1
            before = gc.get_threshold()
            if self._many == 1 and gc.isenabled() and 0 < before[0] < FEW[0]:
                self._before = before
                gc.set_threshold(*FEW)

    def end(self) -> None:
        """One of them has finished."""
        with self._lock:
            self._many -= 1
            if self._many or self._before is None:
                return
            # What the application has frozen would thaw with it, and to count that takes a look at each of its objects
            if gc.get_count()[0] >= MUCH and not gc.get_freeze_count():
                gc.freeze()
                gc.unfreeze()
            gc.set_threshold(*self._before)
            self._before = None


_builders = _Builders()


@contextmanager
def few_collections() -> Iterator[None]:
    """Search rarely for garbage meanwhile, in any number of threads; then as before.

    Much that was built is not searched at its end: it joins the oldest objects, as it would have after two searches.
    Where thresholds are higher already, or collection is switched off, nothing changes.
    """
    _builders.begin()
    try:
        yield
    finally:
        _builders.end()


@contextmanager
def set_apart() -> Iterator[None]:
    """Have no search visit what is alive as this begins, until its end; for a process that does this alone.

    A full search stops all threads while it visits what is alive: 75 ms where ROS is loaded. Garbage among what was
    alive stays until the end. Where an application has frozen objects, nothing changes.
    """
    if gc.get_freeze_count():
        yield
        return
    gc.freeze()
    try:
        yield
    finally:
        gc.unfreeze()
