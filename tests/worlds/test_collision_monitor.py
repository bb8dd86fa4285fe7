# SPDX-License-Identifier: Apache-2.0
"""The robot of the house strikes nothing that its lidar sees, wherever it is sent and however narrow the way is."""

from __future__ import annotations

import math
import random
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import UsageError
from rai_missions.profile.convert import pose_message
from rai_missions.worlds import open_world
from rai_missions.worlds.house.collision_monitor import MARGIN_M, NEAR_M, CollisionMonitor
from rai_missions.worlds.house.layout import DOORS, ROOMS, Box
from rai_missions.worlds.house.rosbot import FASTEST_MPS, FASTEST_RADPS, OUTLINE_M

pytestmark = pytest.mark.sim
PERIOD_S = 0.05
POINTS = st.lists(st.tuples(st.floats(-1, 1), st.floats(-1, 1)), min_size=1, max_size=6)
SPEEDS, TURNS = st.floats(-FASTEST_MPS, FASTEST_MPS), st.floats(-FASTEST_RADPS, FASTEST_RADPS)


def outside(points: Any, x: float, y: float, heading: float) -> float:
    """How far the nearest point is outside of the outline of a robot (m)."""
    east, north = (np.array(points) - (x, y)).T
    ahead = math.cos(heading) * east + math.sin(heading) * north
    left = math.cos(heading) * north - math.sin(heading) * east
    return float(np.maximum(np.abs(ahead) - OUTLINE_M[0], np.abs(left) - OUTLINE_M[1]).min())


@given(POINTS, st.floats(-math.pi, math.pi), st.lists(st.tuples(SPEEDS, TURNS), min_size=1, max_size=4))
def test_whatever_is_commanded_no_point_comes_within_the_margin(
    points: list[tuple[float, float]], heading: float, commands: list[tuple[float, float]]
) -> None:
    assume(outside(points, 0.0, 0.0, heading) > MARGIN_M)
    monitor, x, y = CollisionMonitor(), 0.0, 0.0
    monitor.see(np.array(points))
    for command in commands:
        for _ in range(20):
            speed, turn = monitor.reduced((x, y), heading, command)
            assert speed * command[1] == pytest.approx(turn * command[0]), "the arc is the same"
            assert 0 <= speed / command[0] <= 1 if command[0] else speed == 0
            heading += turn * PERIOD_S / 2
            x, y = x + speed * PERIOD_S * math.cos(heading), y + speed * PERIOD_S * math.sin(heading)
            heading += turn * PERIOD_S / 2
            assert outside(points, x, y, heading) > MARGIN_M - 0.015, "but for the steps of time"


@given(st.floats(NEAR_M + 0.01, 5), st.floats(-math.pi, math.pi), SPEEDS, TURNS)
def test_what_is_out_of_reach_changes_no_command(far: float, bearing: float, speed: float, turn: float) -> None:
    monitor = CollisionMonitor()
    assert monitor.reduced((0.0, 0.0), 0.0, (speed, turn)) == (speed, turn), "nothing was seen yet"
    monitor.see(far * math.sqrt(2) * np.array([[math.cos(bearing), math.sin(bearing)]]))
    assert monitor.reduced((0.0, 0.0), 0.0, (speed, turn)) == (speed, turn)


@given(st.floats(0.1, 0.17), st.floats(-0.05, 0.05))
@settings(max_examples=30)
def test_a_robot_that_touches_something_may_get_away_from_it_and_no_nearer(ahead: float, left: float) -> None:
    monitor = CollisionMonitor()
    monitor.see(np.array([[ahead, left]]))
    assert monitor.reduced((0.0, 0.0), 0.0, (-0.3, 0.0)) == (-0.3, 0.0)
    assert monitor.reduced((0.0, 0.0), 0.0, (0.3, 0.0)) == (0.0, 0.0)


def place_in(room: Box, rng: random.Random, world: Any) -> tuple[float, float]:
    """A place of a room that the robot could be at."""
    for _ in range(200):
        x, y = rng.uniform(room.west, room.east), rng.uniform(room.south, room.north)
        if world.navigator.costmap.is_free_on_the_map(x, y):
            break
    return x, y


def through_a_door(seed: int) -> tuple[Any, list[str], random.Random]:
    """A house with one or two people at a door, most of them on the floor, and the rooms that the door joins."""
    rng = random.Random(f"doors {seed}")
    door = rng.choice(list(DOORS))
    people = []
    for _ in range(rng.randint(1, 2)):
        bearing, far = rng.uniform(0, 2 * math.pi), rng.uniform(0.35, 1.1)
        x, y = DOORS[door][0] + far * math.cos(bearing), DOORS[door][1] + far * math.sin(bearing)
        at = [round(min(9.5, max(0.5, x)), 2), round(min(7.5, max(0.5, y)), 2)]
        people.append({"at": at, "lies": rng.random() < 0.8, "turn_deg": rng.randint(-180, 180)})
    words: dict[str, Any] = {"seed": seed, "objects": [], "recoveries": rng.choice([3, 6]), "camera": False}
    for count in range(len(people), -1, -1):
        try:
            world = open_world("house", people=people[:count], **words)
            break
        except UsageError:
            continue  # someone would be in a wall
    return world, [{"living": "living room"}.get(room, room) for room in door.split("_")], rng


def driven(seed: int, limit_s: float) -> Any:
    """A house in which the robot was sent to and fro through a door, often before it had arrived."""
    world, rooms, rng = through_a_door(seed)
    connector = LocalConnector(now=lambda: world.at)
    world.open(connector)
    connector.start()
    for number in range(6):
        x, y = place_in(ROOMS[rooms[number % 2]], rng, world)
        found: list[str] = []
        pose = pose_message({"x": x, "y": y, "yaw": rng.uniform(-3, 3), "frame": "map"})
        connector.send_goal(
            "/navigate_to_pose",
            "",
            {"pose": pose},
            goal_id=f"g{number}",
            on_report=lambda report, found=found: found.append(report.status),
        )
        until = world.at + (rng.uniform(3, 20) if rng.random() < 0.3 else 200)
        while world.at < min(until, limit_s) and not {"succeeded", "failed"} & set(found):
            world.step()
    return world


STRUCK_FORMERLY = {33: 39.0, 112: 23.0}
"""Seeds of scenes in which it struck furniture or a wall with 214 and 317 N, and when."""


@pytest.mark.parametrize(("seed", "limit_s"), STRUCK_FORMERLY.items())
def test_a_robot_in_a_narrow_gap_strikes_nothing(seed: int, limit_s: float) -> None:
    measures = driven(seed, limit_s).measures()
    assert (measures["struck_n"], measures["touched_person"]) == (0.0, False) and measures["driven_m"] > 5


@pytest.mark.drill
@pytest.mark.parametrize("seed", range(60))
def test_no_drive_through_a_door_with_people_at_it_strikes_anything(seed: int) -> None:
    measures = driven(seed, 150.0).measures()
    assert (measures["struck_n"], measures["touched_person"]) == (0.0, False)
