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
NEIGHBOURS = [(dy, dx, math.hypot(dy, dx)) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dy, dx) != (0, 0)]


def plan(cost: NDArray[np.float64], start: Cell, goal: Cell) -> list[Cell] | None:
    """The cells from start to goal, both included; None if no way leads there.

    Args:
        cost: Of a step onto each cell, at least 1; infinite where no one can be.
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
            if step == math.inf:
                if not is_stuck:
                    continue
                cell = there // wide - 1, there % wide - 1
                if not (0 <= cell[0] < rows and 0 <= cell[1] < columns and _is_near(cell, start)):
                    continue
                step = 50.0
            total = so_far + far * step
            if total < known[there]:
                known[there] = total
                came[there] = here
                heapq.heappush(waiting, (total + left[there], next(number), there))
    return None


def _is_near(cell: Cell, start: Cell) -> bool:
    return abs(cell[0] - start[0]) <= 3 and abs(cell[1] - start[1]) <= 3


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
