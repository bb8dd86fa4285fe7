# SPDX-License-Identifier: Apache-2.0
"""The depth camera alone sees who lies on the floor, and the robot drives around them or stops before."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.campaign.load import load_campaign
from rai_missions.campaign.questions import ask_in
from rai_missions.campaign.records import SceneRecord
from rai_missions.campaign.rollout import rollouts
from rai_missions.campaign.scenes import scenes
from rai_missions.connectors.local import LocalConnector
from rai_missions.profile.convert import pose_message
from rai_missions.worlds import open_world
from rai_missions.worlds.house.costmap import CELL_M, REMEMBERED_M, Costmap
from rai_missions.worlds.house.low_scan import REACH_M, LowScan
from rai_missions.worlds.house.rosbot import LIDAR_AT

pytestmark = pytest.mark.sim
CAMPAIGN = "campaigns/house.json"
TURNS = st.integers(-180, 180)


def house(**options: Any) -> Any:
    return open_world("house", **{"seed": 3, "camera": False, "objects": [], "recoveries": 1, **options})


def driven(world: Any, place: tuple[float, float], within_s: float) -> list[str]:
    """What an action to a place reported."""
    connector = LocalConnector(now=lambda: world.at)
    world.open(connector)
    connector.start()
    found: list[str] = []
    goal = {"pose": pose_message({"x": place[0], "y": place[1], "yaw": 0.0, "frame": "map"})}
    connector.send_goal(
        "/navigate_to_pose", "", goal, goal_id="g", on_report=lambda report: found.append(report.status)
    )
    while world.at < within_s and not {"succeeded", "failed"} & set(found):
        world.step()
    return found


def off_the_body(points: np.ndarray, one: Any, robot: Any) -> np.ndarray:
    """How far points, from the lidar, are from the axis of one who lies (m)."""
    cos, sin = math.cos(robot.heading), math.sin(robot.heading)
    x, y = points[:, 0] + LIDAR_AT[0], points[:, 1]
    east, north = robot.x + cos * x - sin * y - one.x, robot.y + sin * x + cos * y - one.y
    cos, sin = math.cos(one.heading), math.sin(one.heading)
    along = np.clip(cos * east + sin * north, -0.8, 0.7)
    return np.hypot(east - along * cos, north - along * sin)


@given(st.floats(1.9, 2.6), st.floats(2.4, 2.8), TURNS)
@settings(max_examples=8)
def test_what_is_low_is_where_someone_lies_and_the_rest_is_floor(x: float, y: float, turn: int) -> None:
    world = house(people=[{"at": [x, y], "lies": True, "turn_deg": turn}])
    world.step()
    seen, one = LowScan(world.model, world.data, 1).look(), world.residents.people[0]
    assert len(seen.low) > 0 and len(seen.floor) > 0
    nearby = seen.low[seen.low[:, 0] < REACH_M - 0.2]
    off = off_the_body(nearby, one, world.pose)
    assert (off[nearby[:, 1] > -0.5] < 0.13).all(), "but for the table, south of the way"
    assert len(seen.floor) > 200 and np.median(off_the_body(seen.floor, one, world.pose)) > 0.2


@given(st.floats(1.5, 3.2), st.floats(2.3, 3.5), TURNS)
@settings(max_examples=6)
def test_no_one_who_lies_on_the_way_is_touched_wherever_they_lie(x: float, y: float, turn: int) -> None:
    world = house(people=[{"at": [x, y], "lies": True, "turn_deg": turn}])
    assert {"succeeded", "failed"} & set(driven(world, (3.9, 3.1), 60.0))
    assert world.harm() == ""


def test_someone_who_lies_next_to_the_way_is_passed() -> None:
    world = house(people=[{"at": [2.4, 3.75], "lies": True, "turn_deg": 0}])
    assert "succeeded" in driven(world, (3.9, 3.1), 60.0) and world.harm() == ""


cells = st.tuples(st.integers(15, 30), st.integers(40, 46))


@given(st.lists(cells, min_size=1, max_size=4), st.lists(cells, max_size=4))
def test_no_beam_of_the_lidar_clears_what_is_low_but_floor_that_is_seen_does(
    low: list[tuple[int, int]], floor: list[tuple[int, int]]
) -> None:
    grid = Costmap()
    middles = np.array([grid.middle(cell) for cell in low])
    none = np.empty((0, 2))
    grid.look_down(none, middles)
    for _ in range(2):
        grid.look((3.9, 2.1), np.linspace(-math.pi, math.pi, 360), np.full(360, math.inf))
    assert all(math.isinf(grid.cost[cell]) for cell in low)
    grid.look_down(np.array([grid.middle(cell) for cell in floor]).reshape(-1, 2), none)
    for cell in low:
        near = min(math.dist(cell, other) for other in {*low} - {*floor}) if {*low} - {*floor} else math.inf
        assert math.isinf(grid.cost[cell]) is (near * CELL_M <= 0.3 + 1e-9), cell


def test_a_recovery_forgets_what_is_low_but_not_near_the_robot() -> None:
    grid, robot = Costmap(), (6.3, 2.0)
    near, far = (robot[0] + REMEMBERED_M - 0.15, robot[1]), (robot[0], robot[1] - REMEMBERED_M - 0.35)
    grid.look_down(np.empty((0, 2)), np.array([near, far]))
    grid.clear(robot)
    assert math.isinf(grid.cost[grid.cell(*near)]) and math.isfinite(grid.cost[grid.cell(*far)])
    assert grid.low_near(robot, 0.0) == pytest.approx(math.dist(robot, near), abs=CELL_M)
    assert math.isinf(grid.low_near(robot, math.pi))


def tried(one: Any) -> dict[str, tuple[str, bool, float]]:
    """Every option of the patrol in a scene of the house → verdict, whether a person is touched, and the force (N)."""
    loaded = load_campaign(CAMPAIGN)
    stored = json.loads(one.spec)
    spec = {**stored, "options": {**stored["options"], "camera": False}}
    asked = ask_in(SceneRecord(one.scene, "house", one.kind, one.seed, one.split, json.dumps(spec)), loaded.subject)
    assert asked.decision is not None
    found = rollouts(asked.decision, loaded.subject.options, longest_s=90.0)
    asked.decision.world.close()
    return {
        name: (each.verdict, each.measures["touched_person"], each.measures["struck_n"]) for name, each in found.items()
    }


LYING = [one for one in scenes("house", 200) if one.kind == "lies"]
STRUCK_FORMERLY = scenes("house", 1, 2071)
"""A scene in which `wait` struck the door frame with 142 N, on its way back past the person on the floor."""
OTHERS = [one for one in scenes("house", 60) if one.kind != "lies"]


@pytest.mark.parametrize(
    "one", [*STRUCK_FORMERLY, *(pytest.param(one, marks=pytest.mark.drill) for one in LYING + OTHERS)]
)
def test_no_option_of_the_patrol_touches_a_person_or_strikes_anything(one: Any) -> None:
    """Offered or refused, in any scene of the campaign's generator."""
    assert {each[1:] for each in tried(one).values()} == {(False, 0.0)}, one.seed
