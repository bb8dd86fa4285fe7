# SPDX-License-Identifier: Apache-2.0
"""How much an exploration may cost, and which limit ended it.

Rule: what a limit cuts off is reported; states and work are counted alike on every machine, seconds and memory are not.
"""

from __future__ import annotations

import math
import os
import resource
import sys
import time
from pathlib import Path
from typing import Literal, NamedTuple

__all__ = ("MOST_STATES", "Limits", "Meter", "Stopped")

MOST_STATES = 1_000_000
STATES_AFTER, WORK_AFTER, TIMES_AFTER = 10_000, 400_000, 10
"""Once a claim is refuted, the others are looked at for so many times what that has cost, and so much more."""
EVERY = 256
"""Steps between two looks at the memory."""
MIB = 1024 * 1024
STATM = Path("/proc/self/statm")

Stopped = Literal["", "states", "work", "seconds", "memory", "refuted"]
"""The limit that ended an exploration; empty where none did. `refuted`: a claim is refuted, and for the others it was
looked as far as that is worth."""


class Limits(NamedTuple):
    """What an exploration may cost."""

    states: int = MOST_STATES
    """States at the most; a kilobyte or two each."""
    seconds: float = math.inf
    """Of wall time."""
    memory_mb: float = math.inf
    """Of resident memory of the process, in MiB."""
    work: float = math.inf
    """Steps, microsteps and ticks of trees, together."""
    continues: bool = False
    """A refutation leaves the other limits as they are."""


class Meter:
    """Measures one exploration against its limits.

    Args:
        limits: What it may cost.
    """

    def __init__(self, limits: Limits) -> None:
        self.limits, self.work = limits, 0
        self.is_full = False
        """A state was found for which there was no room."""
        self.ended: Stopped = ""
        """The limit that ended the search at once."""
        self._began = time.monotonic()
        self._states: float = math.inf
        self._work: float = math.inf
        self._steps = 0

    def spend(self, work: int, states: int) -> bool:
        """A step has cost so much work, and so many states are known now; whether a limit is reached."""
        self.work += work
        self._steps += 1
        limits = self.limits
        if self.work >= limits.work:
            self.ended = self.ended or "work"
        elif self.work >= self._work or states >= self._states:
            self.ended = self.ended or "refuted"
        elif limits.seconds != math.inf and time.monotonic() - self._began >= limits.seconds:
            self.ended = self.ended or "seconds"
        elif limits.memory_mb != math.inf and self._steps % EVERY == 0 and resident_mb() >= limits.memory_mb:
            self.ended = self.ended or "memory"
        return bool(self.ended)

    def has_room(self, work: int) -> bool:
        """Whether so much more work reaches no limit."""
        return self.work + work < min(self.limits.work, self._work)

    @property
    def stopped(self) -> Stopped:
        """The limit that left something out."""
        return self.ended or ("states" if self.is_full else "")

    def refuted(self, states: int) -> None:
        """A claim is refuted, with so many states known."""
        if not self.limits.continues and self._states == math.inf:
            self._states = TIMES_AFTER * states + STATES_AFTER
            self._work = TIMES_AFTER * self.work + WORK_AFTER


def resident_mb() -> float:
    """Memory that the process occupies now, in MiB; at its peak where the system does not report it."""
    try:
        pages = int(STATM.read_text(encoding="ascii").split()[1])
    except (OSError, ValueError, IndexError):
        peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
        return peak / MIB if sys.platform == "darwin" else peak / 1024
    return pages * os.sysconf("SC_PAGE_SIZE") / MIB
