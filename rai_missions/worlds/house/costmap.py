# SPDX-License-Identifier: Apache-2.0
"""What the navigation knows of the house: the map that it was given, and what its lidar and depth camera saw since.

Rule: the map does not know the crates; a blocked door is found out by looking. What the lidar looks over has a layer of
its own: no beam of the lidar clears it, only floor that the depth camera sees there.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.house.layout import DEPTH_M, FURNITURE, WALLS, WIDTH_M
from rai_missions.worlds.house.rosbot import RADIUS_M

__all__ = ("CELL_M", "Costmap", "points_along")

CELL_M = 0.1
SEES_M = 3.5
"""What is farther away is not entered: a slightly wrong heading would put it elsewhere."""
KEEP_M = 0.2
"""How far the robot keeps from things if it can, beyond its own radius."""

LOW_KEEP_M = 0.1
"""How far the robot must keep from what is low, beyond its own radius: it may be a person."""
REMEMBERED_M = 1.0
"""What is low and nearer than this is not forgotten."""

Grid = NDArray[np.bool_]
Points = NDArray[np.float64]
"""(n, 2): x and y in m."""


def points_along(place: tuple[float, float], angles: NDArray[np.float64], far: NDArray[np.float64]) -> Points:
    """Points of beams, on the map.

    Args:
        place: Where the beams begin.
        angles: Of the beams, in the map.
        far: How far along each its point is, in metres.
    """
    return np.stack([place[0] + np.cos(angles) * far, place[1] + np.sin(angles) * far], -1)


class Costmap:
    """A grid of cells, rows along y, of what is occupied."""

    def __init__(self) -> None:
        self.shape = round(DEPTH_M / CELL_M), round(WIDTH_M / CELL_M)
        rows, columns = np.mgrid[: self.shape[0], : self.shape[1]]
        self._x, self._y = (columns + 0.5) * CELL_M, (rows + 0.5) * CELL_M
        self._map = self._drawn()
        self._seen: Grid = np.zeros(self.shape, bool)
        self._low: Grid = np.zeros(self.shape, bool)
        self._near, self._wide = _disc(RADIUS_M), _disc(RADIUS_M + KEEP_M)
        self._around_low = _disc(RADIUS_M + LOW_KEEP_M)
        self._cost: NDArray[np.float64] | None = None
        self._map_blocked = _grown(self._map, self._near)

    def cell(self, x: float, y: float) -> tuple[int, int]:
        return math.floor(y / CELL_M), math.floor(x / CELL_M)

    def middle(self, cell: tuple[int, int]) -> tuple[float, float]:
        return (cell[1] + 0.5) * CELL_M, (cell[0] + 0.5) * CELL_M

    def is_inside(self, x: float, y: float) -> bool:
        return 0 <= x < WIDTH_M and 0 <= y < DEPTH_M

    def is_free_on_the_map(self, x: float, y: float) -> bool:
        """Whether the robot could be there, as far as the map goes."""
        return self.is_inside(x, y) and not self._map_blocked[self.cell(x, y)]

    def nearest_free(self, x: float, y: float) -> tuple[float, float]:
        """The free place on the map that is nearest to a point, in steps of 0.1 m."""
        xs, ys = (range(10 * math.ceil(metres)) for metres in (WIDTH_M, DEPTH_M))
        free = ((at / 10, up / 10) for at in xs for up in ys if self.is_free_on_the_map(at / 10, up / 10))
        return min(free, key=lambda place: math.dist(place, (x, y)))

    def look(self, place: tuple[float, float], angles: NDArray[np.float64], ranges: NDArray[np.float64]) -> None:
        """Enter a scan: what a beam passes is free, where it ends something is.

        Args:
            place: The place of the lidar.
            angles: Of the beams, in the map.
            ranges: Metres; infinite where nothing was hit.
        """
        steps = np.arange(0.0, SEES_M, CELL_M / 2)
        passed = steps[None, :] < (np.minimum(ranges, SEES_M) - 2 * CELL_M)[:, None]
        rows, columns = self._cells(
            place, np.broadcast_to(angles[:, None], passed.shape)[passed], np.broadcast_to(steps, passed.shape)[passed]
        )
        self._seen[rows, columns] = False
        hits = ranges < SEES_M
        rows, columns = self._cells(place, angles[hits], ranges[hits] + CELL_M / 4)
        self._seen[rows, columns] = True
        self._cost = None

    def look_down(self, floor: Points, low: Points) -> None:
        """Enter what the depth camera sees below the lidar's plane.

        Args:
            floor: Where the floor is free, on the map.
            low: Where something is on it.
        """
        rows, columns = self._cells_of(floor)
        self._low[rows, columns] = False
        rows, columns = self._cells_of(low)
        self._low[rows, columns] = True
        self._cost = None

    def clear(self, place: tuple[float, float]) -> None:
        """Forget what was seen, but what is low and near: the camera may look elsewhere.

        Args:
            place: The place of the robot.
        """
        self._seen[:] = False
        self._low &= np.hypot(self._x - place[0], self._y - place[1]) < REMEMBERED_M
        self._cost = None

    def low_near(self, place: tuple[float, float], direction: float) -> float:
        """How far it is to what is low, in m; infinite where nothing is.

        Args:
            place: From where.
            direction: Of the map; half a radian to each side counts.
        """
        rows, columns = np.nonzero(self._low)
        x, y = (columns + 0.5) * CELL_M - place[0], (rows + 0.5) * CELL_M - place[1]
        aside = np.abs((np.arctan2(y, x) - direction + math.pi) % (2 * math.pi) - math.pi)
        return float(np.hypot(x, y)[aside < 0.5].min(initial=math.inf))

    @property
    def cost(self) -> NDArray[np.float64]:
        """What a step onto each cell costs, 1 in the open; infinite where the robot would touch something."""
        if self._cost is None:
            occupied = self._map | self._seen | self._low
            cost = np.where(_grown(occupied, self._wide), 4.0, 1.0)
            touches = _grown(occupied, self._near) | _grown(self._low, self._around_low)
            self._cost = np.where(touches, np.inf, cost)
        return self._cost

    def _cells(
        self, place: tuple[float, float], angles: NDArray[np.float64], far: NDArray[np.float64]
    ) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        return self._cells_of(points_along(place, angles, far))

    def _cells_of(self, points: Points) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
        columns, rows = np.floor(points / CELL_M).astype(np.int64).T
        return np.clip(rows, 0, self.shape[0] - 1), np.clip(columns, 0, self.shape[1] - 1)

    def _drawn(self) -> Grid:
        drawn: Grid = np.zeros(self.shape, bool)
        half = CELL_M / 2 - 1e-6
        for box in (*WALLS, *FURNITURE.values()):
            across = (self._x > box.west - half) & (self._x < box.east + half)
            drawn |= across & (self._y > box.south - half) & (self._y < box.north + half)
        return drawn


def _disc(radius_m: float) -> list[tuple[int, int]]:
    """The cells around one that lie within a radius."""
    reach = math.floor(radius_m / CELL_M)
    around = range(-reach, reach + 1)
    return [(dy, dx) for dy in around for dx in around if math.hypot(dy, dx) * CELL_M <= radius_m]


def _grown(grid: Grid, disc: list[tuple[int, int]]) -> Grid:
    """Every cell within a disc of an occupied one."""
    reach = max(dy for dy, _ in disc)
    padded = np.pad(grid, reach)
    rows, columns = grid.shape
    out: Grid = np.zeros_like(grid)
    for dy, dx in disc:
        out |= padded[reach + dy : reach + dy + rows, reach + dx : reach + dx + columns]
    return out
