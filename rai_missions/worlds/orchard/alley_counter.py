# SPDX-License-Identifier: Apache-2.0
"""Counts the alleys that were driven, by where the tractor really was.

An adapter: the upstream demo has no such topic. An alley counts once the rear axle has been in the middle of each half
metre of it, in whatever order and from whichever end; what the autonomy believes plays no part.
"""

from __future__ import annotations

from rai_missions.worlds.orchard.layout import Layout

__all__ = ("AlleyCounter",)

CELL_M, OFF_MIDDLE_M = 0.5, 0.8


class AlleyCounter:
    """Which cells of which alleys were driven."""

    def __init__(self, layout: Layout) -> None:
        self._layout = layout
        self._cells = round(layout.length_m / CELL_M)
        self._driven: list[set[int]] = [set() for _ in range(layout.alleys)]

    def see(self, x: float, y: float) -> None:
        """The rear axle is here."""
        alley = self._layout.alley_at(x, y)
        cell = int(x / CELL_M) if x >= 0 else -1
        if alley is not None and 0 <= cell < self._cells and abs(y - self._layout.centre_m(alley)) < OFF_MIDDLE_M:
            self._driven[alley].add(cell)

    @property
    def alleys(self) -> tuple[int, ...]:
        """The alleys that were driven from end to end."""
        return tuple(alley for alley, cells in enumerate(self._driven) if len(cells) == self._cells)

    def share(self, alley: int) -> float:
        """How much of an alley was driven, 0 to 1."""
        return len(self._driven[alley]) / self._cells
