# SPDX-License-Identifier: Apache-2.0
"""The planner's laws on any grid, and what the costmap makes of a scan."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.worlds.house.costmap import CELL_M, Costmap
from rai_missions.worlds.house.layout import DOORS, FURNITURE, PLACES, WALLS
from rai_missions.worlds.house.navigator import Navigator
from rai_missions.worlds.house.planner import Cell, plan
from rai_missions.worlds.house.rosbot import RobotPose


@st.composite
def grids(draw: st.DrawFn) -> tuple[np.ndarray, Cell, Cell]:
    """Costs, a start and a goal; a third of the cells is blocked, the start is free."""
    rows, columns = draw(st.integers(1, 9)), draw(st.integers(1, 9))
    cells = draw(st.lists(st.sampled_from([1.0, 4.0, math.inf]), min_size=rows * columns, max_size=rows * columns))
    cost = np.array(cells).reshape(rows, columns)
    start = draw(st.integers(0, rows - 1)), draw(st.integers(0, columns - 1))
    goal = draw(st.integers(0, rows - 1)), draw(st.integers(0, columns - 1))
    cost[start] = 1.0
    return cost, start, goal


def total(cost: np.ndarray, way: list[Cell]) -> float:
    return sum(math.dist(one, other) * cost[other] for one, other in itertools.pairwise(way))


def least(cost: np.ndarray, start: Cell, goal: Cell) -> float:
    """The least total, by relaxing until nothing changes."""
    known = np.full(cost.shape, math.inf)
    known[start] = 0.0
    changed = True
    while changed:
        changed = False
        for row, column in np.ndindex(*cost.shape):
            if math.isinf(cost[row, column]):
                continue
            for other in np.ndindex(*cost.shape):
                if other != (row, column) and max(abs(other[0] - row), abs(other[1] - column)) == 1:
                    through = known[other] + math.dist(other, (row, column)) * cost[row, column]
                    if through < known[row, column] - 1e-9:
                        known[row, column], changed = through, True
    return float(known[goal]) if not math.isinf(cost[goal]) else math.inf


@given(grids())
def test_a_way_is_made_of_free_neighbours_and_none_is_shorter(given: tuple[np.ndarray, Cell, Cell]) -> None:
    cost, start, goal = given
    way = plan(cost, start, goal)
    best = least(cost, start, goal)
    if way is None:
        assert math.isinf(best)
        return
    assert way[0] == start and way[-1] == goal
    assert all(max(abs(b[0] - a[0]), abs(b[1] - a[1])) == 1 for a, b in itertools.pairwise(way))
    assert all(math.isfinite(cost[cell]) for cell in way)
    assert total(cost, way) == pytest.approx(best)


def test_anyone_who_is_too_close_gets_away() -> None:
    cost = np.ones((9, 9))
    cost[3:6, 3:6] = math.inf
    way = plan(cost, (4, 4), (0, 0))
    assert way is not None and sum(math.isinf(cost[cell]) for cell in way) == 2
    cost[:] = math.inf
    cost[0, 0] = 1.0
    assert plan(cost, (8, 8), (0, 0)) is None, "but does not drive through walls"


def test_a_goal_off_the_grid_has_no_way() -> None:
    assert plan(np.ones((3, 3)), (0, 0), (3, 0)) is None
    assert plan(np.ones((3, 3)), (0, 0), (0, -1)) is None


def test_every_place_is_free_and_every_wall_is_not() -> None:
    grid = Costmap()
    assert all(grid.is_free_on_the_map(place.x, place.y) for place in PLACES.values())
    assert all(grid.is_free_on_the_map(*door) for door in DOORS.values())
    assert not any(grid.is_free_on_the_map(*box.middle) for box in (*WALLS, *FURNITURE.values()))


def scan(far: float) -> tuple[np.ndarray, np.ndarray]:
    return np.linspace(-0.3, 0.3, 60), np.full(60, far)


def test_what_a_beam_ends_at_is_in_the_way_until_a_beam_passes_it() -> None:
    grid, here = Costmap(), (6.0, 1.7)
    ahead = grid.cell(7.0, 1.7)
    assert math.isfinite(grid.cost[ahead])
    grid.look(here, *scan(1.0))
    assert math.isinf(grid.cost[ahead])
    grid.look(here, *scan(math.inf))
    assert math.isfinite(grid.cost[ahead])
    grid.look(here, *scan(1.0))
    grid.clear(here)
    assert math.isfinite(grid.cost[ahead])


def test_a_cell_and_its_middle_agree() -> None:
    grid = Costmap()
    for cell in ((0, 0), (79, 99), (13, 57)):
        assert grid.cell(*grid.middle(cell)) == cell
    assert grid.middle((0, 0)) == (CELL_M / 2, CELL_M / 2)


def test_a_way_that_is_seen_to_be_blocked_is_not_driven_on() -> None:
    navigator, here = Navigator(recoveries=3), RobotPose(6.0, 2.0, 0.0, 0.0, 0.0)
    navigator.begin(PLACES["pantry"], turns=False, at=0.0)
    assert navigator.step(here, 0.0)[0] > 0 and navigator.left_m > 2
    navigator.see(here[:2], here.heading, np.linspace(-math.pi, math.pi, 360, endpoint=False), np.full(360, 1.2))
    assert navigator.step(here, 0.2)[0] == 0 and navigator.recoveries == 1, "at once, not when it would plan again"


def test_a_robot_that_turns_out_of_its_place_plans_again() -> None:
    navigator, (x, y, heading) = Navigator(recoveries=0), PLACES["living_room"]
    navigator.begin(PLACES["living_room"], turns=True, at=0.0)
    assert navigator.step(RobotPose(x, y - 0.4, heading, 0.0, 0.0), 0.0)[0] > 0
    assert navigator.step(RobotPose(x, y - 0.1, 0.0, 0.0, 0.0), 0.1)[0] == 0, "it only turns"
    assert navigator.step(RobotPose(x, y - 0.2, heading, 0.0, 0.0), 0.2)[0] > 0, "it was pushed, and comes back"
