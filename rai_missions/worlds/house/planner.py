# SPDX-License-Identifier: Apache-2.0
"""The shortest way over a grid of costs: A* with eight neighbours."""

from __future__ import annotations

import heapq
import math
from itertools import count

import numpy as np
from numpy.typing import NDArray

__all__ = ("Cell", "plan")

Cell = tuple[int, int]
WAY_OUT, WAY_OUT_COST = 3, 50.0
"""So far, in cells, a robot that is too close to something may go over infinite cells, and what each of them costs."""
NEIGHBOURS = [(dy, dx, math.hypot(dy, dx)) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dy, dx) != (0, 0)]


def plan(cost: NDArray[np.float64], start: Cell, goal: Cell) -> list[Cell] | None:
    """The cells from start to goal, both included; None if no way leads there.

    Args:
        cost: The cost of a step onto each cell, at least 1; infinite where no one can be.
        start: May lie on an infinite cell: a robot that is too close to something must get away.
        goal: Must not.
    """
    rows, columns = cost.shape
    if not (0 <= goal[0] < rows and 0 <= goal[1] < columns) or math.isinf(cost[goal]):
        return None
    # Numbers for cells, and an edge where no one can be: a way over a house takes many thousand looks at a neighbour.
    wide = columns + 2
    costs: list[float] = np.pad(cost, 1, constant_values=math.inf).ravel().tolist()
    left = _left(rows, columns, goal)
    steps = [(dy * wide + dx, far) for dy, dx, far in NEIGHBOURS]
    first, last = ((row + 1) * wide + column + 1 for row, column in (start, goal))
    way_out = _near(start, rows, columns, wide)
    known = [math.inf] * len(costs)
    known[first] = 0.0
    came: dict[int, int] = {}
    number = count()  # among equals the first comes first, so that the same grid gives the same way
    waiting = [(left[first], next(number), first)]
    done = bytearray(len(costs))
    while waiting:
        _, _, here = heapq.heappop(waiting)
        if here == last:
            return [(each // wide - 1, each % wide - 1) for each in _way(came, here)]
        if done[here]:
            continue
        done[here] = True
        so_far, is_stuck = known[here], math.isinf(costs[here])
        for by, far in steps:
            there = here + by
            step = costs[there]
            if is_stuck and step == math.inf and there in way_out:
                step = WAY_OUT_COST
            total = so_far + far * step
            if total < known[there]:
                known[there], came[there] = total, here
                heapq.heappush(waiting, (total + left[there], next(number), there))
    return None


def _near(cell: Cell, rows: int, columns: int, wide: int) -> set[int]:
    """The numbers of the cells around one, in lines so wide."""
    (top, bottom), (left, right) = (
        (max(0, at - WAY_OUT), min(many, at + WAY_OUT + 1)) for at, many in zip(cell, (rows, columns), strict=True)
    )
    return {(row + 1) * wide + column + 1 for row in range(top, bottom) for column in range(left, right)}


def _left(rows: int, columns: int, goal: Cell) -> list[float]:
    """What is left at least from each cell, and from those around the grid."""
    down = np.abs(np.arange(-1, rows + 1) - goal[0])[:, None]
    across = np.abs(np.arange(-1, columns + 1) - goal[1])[None, :]
    left: list[float] = (np.maximum(down, across) + (math.sqrt(2) - 1) * np.minimum(down, across)).ravel().tolist()
    return left


def _way(came: dict[int, int], here: int) -> list[int]:
    way = [here]
    while here in came:
        here = came[here]
        way.append(here)
    return way[::-1]
