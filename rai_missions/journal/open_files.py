# SPDX-License-Identifier: Apache-2.0
"""Which journals of a process have their files open: a bounded number, those that were written last.

Rule: a journal at rest keeps its lock, so it has a writer; its next row opens its files again.
Rule: files are closed on a thread of their own, so a disk that hangs holds up no journal on another.
"""

from __future__ import annotations

import math
import os
import resource
import threading
import time
from contextlib import suppress
from typing import Protocol
from weakref import WeakSet

from rai_missions.connectors.worker import Worker
from rai_missions.journal.lock import FILES, may_open

__all__ = ("OPEN", "OpenFiles", "OpenJournal")

KEPT = 64
"""Journals that stay open whatever they do. An open one takes 76 kB and two files more than one at rest."""
REST_S = 5.0
"""Beyond these, a journal that has written no row for so long is closed. To close and open again takes 1 ms of CPU."""
BATCH, PACE_S = 10, 0.2
"""How many are closed at once, and how often: where all are written every 6 s, that takes 6 % of a core at most."""
SHARE = 4
"""One in so many of the files that this process may open, locks left out, is the database of a journal. Another one
is its log, and half are for all else."""
FEWEST = 4
"""Journals that may be open where there are files, however many locks there are."""
TRIM_S = 5.0
"""At most so often the C library gives back what closed journals have freed. That takes 16 ms of CPU after 1,000."""
PATIENCE_S = 1.0
"""How long a journal that is opened waits for the files of others to be closed."""


class OpenJournal(Protocol):
    """A journal whose files may be closed until its next row: `rai_missions.journal.Journal`."""

    written: float
    """When its last row was written, on `time.monotonic`."""

    def rest(self) -> None: ...


class OpenFiles:
    """The journals of a process whose files are open.

    Args:
        kept: How many stay open whatever they do.
        rest_s: How long, in seconds, each of the others stays open after a row.
    """

    def __init__(self, kept: int = KEPT, rest_s: float = REST_S) -> None:
        self.kept, self.rest_s = kept, rest_s
        self.forget()

    def forget(self) -> None:
        """Begin again in a forked process, which does not have its parent's thread."""
        self._lock = threading.Lock()
        self._open: WeakSet[OpenJournal] = WeakSet()
        self._closer: Worker | None = None
        self._has_freed, self._trimmed_at = False, -math.inf

    @property
    def count(self) -> int:
        """How many journals have their files open."""
        return len(self._open)

    def opened(self, journal: OpenJournal) -> None:
        """Count in a journal whose files were opened."""
        with self._lock:
            self._open.add(journal)
            if self._closer is None and len(self._open) > self.kept:
                self._closer = Worker("journals at rest")
                self._closer.after(self.rest_s, self._close_idle)

    def closed(self, journal: OpenJournal) -> None:
        """Count out a journal whose files were closed."""
        with self._lock:
            self._open.discard(journal)

    def make_room(self, locks: int) -> None:
        """Have the files of others closed where too many are open for another journal.

        Args:
            locks: How many journals this process may write, each of which has a file open.
        """
        limit = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
        most = max(FEWEST, (limit - locks) // SHARE) if limit != resource.RLIM_INFINITY else math.inf
        with self._lock:
            surplus = len(self._open) + 1 - most
            if surplus <= 0 and (may_open(FILES) or not self._open):
                return
            count = int(max(1, surplus))
        closer = Worker("journals at rest")
        with suppress(TimeoutError):
            closer.submit(lambda: self._close_oldest(count)).result(PATIENCE_S)
        closer.close(0.0)

    def _close_oldest(self, count: int) -> None:
        with self._lock:
            oldest = self._oldest(count)
        for journal in oldest:
            journal.rest()

    def _oldest(self, count: int) -> list[OpenJournal]:
        """The open journals whose last write is the longest ago, `count` of them, the oldest first."""
        return sorted(self._open, key=lambda journal: journal.written)[: max(0, count)]

    def _close_idle(self) -> None:
        """Close those that have rested for long enough, and look again while there are more than are kept."""
        with self._lock:
            spare = self._oldest(min(len(self._open) - self.kept, BATCH))
        now, wait_s = time.monotonic(), PACE_S
        while spare and (wait_s := spare[0].written + self.rest_s - now) <= 0:
            spare.pop(0).rest()
            self._has_freed = True
        del spare
        with self._lock:
            closer, is_done = self._closer, len(self._open) <= self.kept
            if is_done:
                self._closer = None
        if self._has_freed and (is_done or now - self._trimmed_at >= TRIM_S):
            self._has_freed, self._trimmed_at = False, now
            trim()
        if closer is not None:
            if is_done:
                closer.close()
            else:
                closer.after(max(wait_s, PACE_S), self._close_idle)


def trim() -> None:
    """Give the memory that was freed back to the system, where the C library is one that keeps it: glibc."""
    import ctypes  # needed for many journals alone

    with suppress(AttributeError):
        ctypes.CDLL(None).malloc_trim(0)


OPEN = OpenFiles()
os.register_at_fork(after_in_child=OPEN.forget)
