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
        cost: Of a step onto each cell, at least 1; infinite where nobody can be.
        start: May lie on an infinite cell: whoever stands too close to something must get away.
        goal: Must not.
    """
    rows, columns = cost.shape
    if not (0 <= goal[0] < rows and 0 <= goal[1] < columns) or math.isinf(cost[goal]):
        return None
    costs = cost.tolist()
    known: dict[Cell, float] = {start: 0.0}
    came: dict[Cell, Cell] = {}
    number = count()  # among equals the first comes first, so that the same grid gives the same way
    waiting = [(_left(start, goal), next(number), start)]
    done: set[Cell] = set()
    while waiting:
        _, _, here = heapq.heappop(waiting)
        if here == goal:
            return _way(came, here)
        if here in done:
            continue
        done.add(here)
        stuck = math.isinf(costs[here[0]][here[1]])
        for dy, dx, far in NEIGHBOURS:
            row, column = here[0] + dy, here[1] + dx
            if not (0 <= row < rows and 0 <= column < columns):
                continue
            step = costs[row][column]
            if math.isinf(step):
                if not stuck or abs(row - start[0]) > 3 or abs(column - start[1]) > 3:
                    continue
                step = 50.0
            total = known[here] + far * step
            if total < known.get((row, column), math.inf):
                known[row, column] = total
                came[row, column] = here
                heapq.heappush(waiting, (total + _left((row, column), goal), next(number), (row, column)))
    return None


def _left(here: Cell, goal: Cell) -> float:
    down, across = abs(here[0] - goal[0]), abs(here[1] - goal[1])
    return max(down, across) + (math.sqrt(2) - 1) * min(down, across)


def _way(came: dict[Cell, Cell], here: Cell) -> list[Cell]:
    way = [here]
    while here in came:
        here = came[here]
        way.append(here)
    return way[::-1]
