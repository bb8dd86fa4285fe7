# SPDX-License-Identifier: Apache-2.0
"""Finds the way: over headlands and through alleys, forwards and backwards, in moves that the tractor can drive.

The headlands carry a lattice of places, one turning radius apart, each with one of four headings. A move goes straight
to the next place or around a quarter circle; an alley is one long move from mouth to mouth. Dijkstra's algorithm
finds the cheapest moves; driving backwards and changing direction cost more.
"""

from __future__ import annotations

import heapq
import itertools
import math
from collections.abc import Callable, Iterator
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.orchard.layout import Layout

__all__ = ("Lattice", "LatticePlace", "PathSegment", "straight")

BACKWARDS_COSTS, CHANGE_COSTS_M = 1.4, 3.0
SAMPLE_M = 0.1
STEP = ((1, 0), (0, 1), (-1, 0), (0, -1))
"""Unit steps by heading: east, north, west, south."""


WEST_MOUTH, EAST_MOUTH = 3, 4
"""The columns of the alleys' mouths."""


class LatticePlace(NamedTuple):
    """A place of the lattice, and how the tractor is turned there."""

    column: int
    """0 to 3 are in the west, 4 to 7 in the east, from west to east."""
    row: int
    """Two to an alley; the even ones are in its middle."""
    heading: int
    """0 east, 1 north, 2 west, 3 south."""

    @property
    def is_west(self) -> bool:
        """Whether the place is on the western headland."""
        return self.column <= WEST_MOUTH

    def across(self) -> LatticePlace:
        """The place opposite, on the other headland."""
        return self._replace(column=WEST_MOUTH + EAST_MOUTH - self.column)


class PathSegment(NamedTuple):
    """A way from one place to another, sampled."""

    points: NDArray[np.float64]
    """Rows of x, y, the tractor's heading, and curvature (1/m, left positive, as driven)."""
    ahead: int
    """1 forwards, -1 backwards."""
    end: LatticePlace
    alley: int | None = None
    """The alley that it lies in."""

    @property
    def length_m(self) -> float:
        return float(np.sum(np.hypot(*np.diff(self.points[:, :2], axis=0).T)))


def straight(x: float, y: float, to_x: float, to_y: float, heading: float) -> NDArray[np.float64]:
    """Samples of a straight line."""
    count = max(2, math.ceil(math.hypot(to_x - x, to_y - y) / SAMPLE_M) + 1)
    line = np.linspace((x, y), (to_x, to_y), count)
    return np.column_stack([line, np.full(count, heading), np.zeros(count)])


class Lattice:
    """The places and moves of one orchard."""

    def __init__(self, layout: Layout) -> None:
        self.layout = layout
        west, east = layout.mouths_m
        r = layout.radius_m
        self._xs = [west - k * r for k in (3, 2, 1, 0)] + [east + k * r for k in (0, 1, 2, 3)]
        self._rows = range(-3, 2 * layout.alleys + 2)
        self._turns: dict[LatticePlace, tuple[tuple[PathSegment, float], ...]] = {}

    def position(self, place: LatticePlace) -> tuple[float, float]:
        return self._xs[place.column], place.row * self.layout.radius_m

    def mouth(self, alley: int, *, east: bool, heading: int) -> LatticePlace:
        return LatticePlace(EAST_MOUTH if east else WEST_MOUTH, 2 * alley, heading)

    def nearest(self, x: float, y: float) -> LatticePlace:
        """The place nearest to a point, looking east."""
        column = min(range(len(self._xs)), key=lambda k: abs(self._xs[k] - x))
        row = min(self._rows, key=lambda k: abs(k * self.layout.radius_m - y))
        return LatticePlace(column, row, 0)

    def way(
        self,
        starts: list[tuple[tuple[PathSegment, ...], LatticePlace]],
        is_goal: Callable[[LatticePlace], bool],
        passable: Callable[[int], bool],
        below: float = math.inf,
    ) -> tuple[float, tuple[PathSegment, ...]] | None:
        """The cheapest way to a goal: its cost and its moves, those of its start included; None if there is none.

        Args:
            starts: Moves that come first in any case, and the place that they lead to.
            is_goal: Whether a place is where to go.
            passable: Whether an alley may be driven through.
            below: Only a way that costs less is wanted.
        """
        order = itertools.count()
        queue = [(_cost(moves), next(order), place, moves) for moves, place in starts]
        heapq.heapify(queue)
        seen: set[tuple[LatticePlace, int]] = set()
        while queue:
            cost, _, place, moves = heapq.heappop(queue)
            if cost >= below:
                return None
            if is_goal(place):
                return cost, moves
            ahead = moves[-1].ahead if moves else 1
            if (place, ahead) in seen:
                continue
            seen.add((place, ahead))
            for move, length_m in self._moves(place, passable):
                more = _step_cost(move, length_m, ahead)
                heapq.heappush(queue, (cost + more, next(order), move.end, (*moves, move)))
        return None

    def through(self, alley: int, start: LatticePlace) -> PathSegment:
        """From one mouth of an alley (or of a lane next to the orchard) to the other, forwards."""
        (x, y), end = self.position(start), start.across()
        points = straight(x, y, self._xs[end.column], y, start.heading * math.pi / 2)
        return PathSegment(points, 1, end, alley if 0 <= alley < self.layout.alleys else None)

    def _moves(self, place: LatticePlace, passable: Callable[[int], bool]) -> Iterator[tuple[PathSegment, float]]:
        """The moves from a place, each with its length in m."""
        if place not in self._turns:  # every way leads past the same places
            self._turns[place] = tuple((move, move.length_m) for move in self._on_headland(place))
        yield from self._turns[place]
        into = (place.column, place.heading) in ((WEST_MOUTH, 0), (EAST_MOUTH, 2))
        alley = place.row // 2
        if into and place.row % 2 == 0 and -1 <= alley <= self.layout.alleys and passable(alley):
            move = self.through(alley, place)
            yield move, move.length_m

    def _on_headland(self, place: LatticePlace) -> Iterator[PathSegment]:
        for ahead in (1, -1):
            yield from self._straight(place, ahead)
            yield from (self._arc(place, ahead, left) for left in (1, -1) if self._arc_end(place, ahead, left))

    def _straight(self, place: LatticePlace, ahead: int) -> Iterator[PathSegment]:
        dx, dy = STEP[place.heading]
        end = LatticePlace(place.column + ahead * dx, place.row + ahead * dy, place.heading)
        if self._exists(place, end):
            yield PathSegment(
                straight(*self.position(place), *self.position(end), place.heading * math.pi / 2), ahead, end
            )

    def _arc_end(self, place: LatticePlace, ahead: int, left: int) -> LatticePlace | None:
        dx, dy = STEP[place.heading]
        column, row = place.column + ahead * dx - left * dy, place.row + ahead * dy + left * dx
        end = LatticePlace(column, row, (place.heading + ahead * left) % 4)
        return end if self._exists(place, end) else None

    def _arc(self, place: LatticePlace, ahead: int, left: int) -> PathSegment:
        """A quarter circle; backwards to the left, the tail goes to the left."""
        end = self._arc_end(place, ahead, left)
        assert end is not None
        r, heading = self.layout.radius_m, place.heading * math.pi / 2
        (x, y), turn = self.position(place), np.linspace(0, math.pi / 2, math.ceil(r * math.pi / 2 / SAMPLE_M))
        u, v = ahead * r * np.sin(turn), left * r * (1 - np.cos(turn))
        c, s = math.cos(heading), math.sin(heading)
        bend = np.full(len(turn), left / r)
        return PathSegment(
            np.column_stack([x + u * c - v * s, y + u * s + v * c, heading + ahead * left * turn, bend]), ahead, end
        )

    def _exists(self, place: LatticePlace, end: LatticePlace) -> bool:
        same_side = place.is_west == end.is_west and 0 <= end.column < len(self._xs)
        return same_side and end.row in self._rows


def _step_cost(move: PathSegment, length_m: float, ahead: int) -> float:
    back = BACKWARDS_COSTS if move.ahead < 0 else 1.0
    return length_m * back + (CHANGE_COSTS_M if move.ahead != ahead else 0.0)


def _cost(moves: tuple[PathSegment, ...]) -> float:
    total, ahead = 0.0, moves[0].ahead if moves else 1
    for move in moves:
        total, ahead = total + _step_cost(move, move.length_m, ahead), move.ahead
    return total
