# SPDX-License-Identifier: Apache-2.0
"""Where the arm can work: the desk, and what of it is in reach."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import product

from rai_missions.planning.geometry import Footprint, Point

__all__ = ("Workspace",)

SPARE_M = 0.04
"""How far from the limits of its reach a place is that is chosen, metres."""


@dataclass(frozen=True)
class Workspace:
    """The desk and the arm's reach over it, in metres in the base frame."""

    desk: tuple[float, float, float, float] = (-0.2, -0.75, 0.95, 0.75)
    """From x and y to x and y."""
    nearest_m: float = 0.28
    """Radius from the base below which the gripper does not reach the desk from above."""
    farthest_m: float = 0.80
    """Radius up to which it reaches from above."""
    tilted_m: float = 0.84
    """Radius up to which it reaches with a tilted wrist: for places that are named, never for those that are chosen."""
    front_m: float = 0.24
    """The least x of a place that is chosen: what is at the arm's side is hidden from the cameras."""
    turned_rad: float = math.pi / 2
    """How far to a side it works: the angle from straight ahead."""
    highest_m: float = 0.31
    """The top of what it can set down."""
    opening_m: float = 0.076
    """The width of what fits between its fingers."""
    step_m: float = 0.03
    """The raster of the places that it chooses from."""

    def reaches(self, x: float, y: float) -> bool:
        """Whether a place is within reach, be it with a tilted wrist."""
        return self.nearest_m <= math.hypot(x, y) <= self.tilted_m and abs(math.atan2(y, x)) <= self.turned_rad

    def is_easy(self, x: float, y: float) -> bool:
        """Whether a place may be chosen: in front of the arm, and reached from above with room to spare."""
        return x >= self.front_m and self.nearest_m + SPARE_M <= math.hypot(x, y) <= self.farthest_m - SPARE_M

    def carries(self, footprint: Footprint) -> bool:
        """Whether a whole footprint is on the desk."""
        (from_x, to_x), (from_y, to_y) = footprint.extent(0), footprint.extent(1)
        return self.desk[0] <= from_x and self.desk[1] <= from_y and to_x <= self.desk[2] and to_y <= self.desk[3]

    def places(self, start: Point) -> list[Point]:
        """The places that may be chosen, those in easy reach: the nearest to a point first, then from below left."""
        return sorted(self._raster, key=lambda each: (round(math.dist(each, start), 6), each))

    @cached_property
    def _raster(self) -> tuple[Point, ...]:
        return tuple(self._easy())

    def _easy(self) -> Iterator[Point]:
        counts = (int((self.desk[axis + 2] - self.desk[axis]) / self.step_m) for axis in (0, 1))
        for column, row in product(*(range(1, count + 1) for count in counts)):
            x, y = round(self.desk[0] + column * self.step_m, 4), round(self.desk[1] + row * self.step_m, 4)
            if self.is_easy(x, y):
                yield x, y
