# SPDX-License-Identifier: Apache-2.0
"""What the navigation tries when it finds no way: the recoveries of Nav2's default tree, one after the other."""

from __future__ import annotations

import math
from typing import Literal

__all__ = ("Recovery", "Sort", "sort_of")

Sort = Literal["clear", "spin", "wait", "back_up"]
SORTS: tuple[Sort, ...] = ("clear", "spin", "wait", "back_up")
SPIN_RADPS, SPIN_RAD = 0.8, math.pi / 2
BACK_MPS, BACK_M = 0.1, 0.2
LASTS_S = {"clear": 0.5, "spin": SPIN_RAD / SPIN_RADPS, "wait": 5.0, "back_up": BACK_M / BACK_MPS}
ROOM_M = 0.35
"""What must be free behind, from the lidar, to back up."""


def sort_of(number: int) -> Sort:
    """Which one it is, counted from 0."""
    return SORTS[number % len(SORTS)]


class Recovery:
    """One recovery on its way.

    Args:
        sort: Which.
        at: When it began.
    """

    def __init__(self, sort: Sort, at: float) -> None:
        self.sort = sort
        self._until = at + LASTS_S[sort]

    def is_over(self, at: float) -> bool:
        return at >= self._until - 1e-9

    def command(self, behind_m: float) -> tuple[float, float]:
        """Speed (m/s) and turn (rad/s).

        Args:
            behind_m: How far the lidar sees backwards.
        """
        if self.sort == "spin":
            return 0.0, SPIN_RADPS
        if self.sort == "back_up" and behind_m > ROOM_M:
            return -BACK_MPS, 0.0
        return 0.0, 0.0
