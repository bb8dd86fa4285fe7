# SPDX-License-Identifier: Apache-2.0
"""A figure that a benchmark found, handed to what gathers them: `make bench` names the file; and memory, counted."""

from __future__ import annotations

import gc
import json
import os
import resource
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

__all__ = ("PACE", "PACE_AT_BOUNDS_MS", "VARIABLE", "Figure", "children_cpu_s", "figure", "figures_in", "peak_bytes")

VARIABLE = "RAI_MISSIONS_FIGURES"
"""The environment's variable that names the file; without it a figure is kept nowhere."""

PACE, PACE_AT_BOUNDS_MS = "import mujoco", 314
"""The figure by which machines are compared, and its value on the one for which the bounds were set."""


class Figure(NamedTuple):
    """One measured number, of one run of a benchmark."""

    name: str
    """What was measured, the same in every round and commit: figures are compared by it."""
    value: float
    unit: str
    """Of `value`, of the peer's value and of the bound."""
    peer: str = ""
    """With whom it was measured in the same run; empty: alone."""
    peer_value: float | None = None
    most: float | None = None
    """The bound that it has to stay under; None: there is none."""
    larger_is_better: bool = False
    """For rates: the bound is then the least, and a gain is a larger value."""


def figure(
    name: str,
    value: float,
    unit: str,
    *,
    peer: tuple[str, float] | None = None,
    most: float | None = None,
    larger_is_better: bool = False,
) -> None:
    """Hand a figure over; no effect where no one gathers."""
    if not (path := os.environ.get(VARIABLE)):
        return
    who, theirs = peer or ("", None)
    found = Figure(name, value, unit, who, theirs, most, larger_is_better)
    with Path(path).open("a", encoding="utf-8") as out:
        out.write(json.dumps(found._asdict()) + "\n")


def figures_in(path: Path) -> list[Figure]:
    """What was handed over, in its order; a file that is not there holds none."""
    if not path.exists():
        return []
    return [Figure(**json.loads(line)) for line in path.read_text(encoding="utf-8").splitlines()]


def children_cpu_s() -> float:
    """The CPU seconds of all processes that this one has begun and that have ended."""
    used = resource.getrusage(resource.RUSAGE_CHILDREN)
    return used.ru_utime + used.ru_stime


def peak_bytes(step: Callable[[], object], times: int = 300) -> float:
    """The bytes that one call has allocated at its peak, its result among them; the mean, and no timing."""
    for _ in range(60):
        step()
    gc.collect()
    gc.disable()
    tracemalloc.start()
    try:
        total, kept = 0, list[object]()
        for _ in range(times):
            before, _ = tracemalloc.get_traced_memory()
            tracemalloc.reset_peak()
            kept.append(step())
            total += tracemalloc.get_traced_memory()[1] - before
        return total / times
    finally:
        tracemalloc.stop()
        gc.enable()
