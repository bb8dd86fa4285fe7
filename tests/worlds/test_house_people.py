# SPDX-License-Identifier: Apache-2.0
"""The people of the house: where they go, that they spare the robot, and that the robot spares them."""

from __future__ import annotations

import math
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.errors import UsageError
from rai_missions.worlds import open_world
from rai_missions.worlds.house.costmap import Costmap
from rai_missions.worlds.house.layout import DOORS
from rai_missions.worlds.house.people import residents
from tests.worlds.test_house import Visit, visit  # noqa: F401 - a fixture

pytestmark = pytest.mark.sim
LEGS_M = 0.17


@settings(max_examples=15)
@given(seed=st.integers(0, 10_000), x=st.floats(0.4, 9.6), y=st.floats(0.4, 7.6))
def test_no_one_walks_into_the_robot_or_through_a_wall(seed: int, x: float, y: float) -> None:
    grid, [one] = Costmap(), residents(seed, 1)
    away = math.dist((one.x, one.y), (x, y))
    for step in range(600):
        before = one.x, one.y
        one.step(step * 0.1, 0.1, (x, y), ())
        assert math.dist(before, (one.x, one.y)) <= 0.2 + 1e-9, "no jumps"
        assert grid.is_free_on_the_map(one.x, one.y)
        nearer = math.dist((one.x, one.y), (x, y))
        assert nearer >= min(away, 0.55), "a person who is near already may only walk away"
        away = nearer


def test_people_follow_the_seed_and_the_clock(visit: Any) -> None:  # noqa: F811
    runs = [visit(seed=seed, people=2) for seed in (1, 1, 2)]
    for house in runs:
        house.run(lambda: False, 30.0)
    prints = [house.world.fingerprint() for house in runs]
    assert prints[0] == prints[1] != prints[2]
    starts = [tuple(one.plan.at) for one in runs[0].world.residents.people]
    ends = [(one.x, one.y) for one in runs[0].world.residents.people]
    assert all(math.dist(start, end) > 0.5 for start, end in zip(starts, ends, strict=True)), "they walk"


def test_a_person_on_the_way_is_passed(visit: Any) -> None:  # noqa: F811
    house = visit(objects=[], people=[{"at": [3.0, 2.8]}])
    house.send("kitchen")
    nearest: list[float] = []
    house.run(lambda: bool(nearest.append(house.to_person()) or len(house.statuses()) > 1))
    assert house.statuses()[-1] == "succeeded" and min(nearest) > LEGS_M + 0.1, min(nearest)
    assert house.world.navigator.recoveries == 0


def test_a_person_in_the_only_door_is_waited_for(visit: Any) -> None:  # noqa: F811
    house = visit(objects=[], people=[{"at": "study_pantry", "walks": ["study"], "from_s": 14, "pause_s": 60}])
    house.send("pantry")
    assert house.finish().status == "succeeded"
    assert house.world.navigator.recoveries > 0, "it waited"


def test_a_person_who_stays_in_the_only_door_ends_the_goal_honestly(visit: Any) -> None:  # noqa: F811
    house = visit(objects=[], people=[{"at": "study_pantry"}], recoveries=3)
    house.send("pantry")
    report = house.finish()
    assert report.status == "failed" and "after 3 recoveries" in report.why
    assert house.to_person() > LEGS_M + 0.2, "it did not push"


def test_a_person_in_one_of_two_doors_is_gone_round(visit: Any) -> None:  # noqa: F811
    house = visit(objects=[], people=[{"at": "kitchen_study"}])
    house.send("study")
    assert house.finish().status == "succeeded" and house.world.at > 25


def test_no_one_walks_through_a_crate(visit: Any) -> None:  # noqa: F811
    walk = {"at": "kitchen", "walks": ["living_room", "kitchen"], "pause_s": 0}
    house = visit(objects=[], blocked=["kitchen_living"], people=[walk])
    one, door, nearest = house.world.residents.people[0], DOORS["kitchen_living"], math.inf
    for _ in range(600):
        house.world.step()
        nearest = min(nearest, math.dist((one.x, one.y), door))
    assert 0.5 < nearest < 1.5, "they come, and stop before it"


@pytest.mark.parametrize(("at", "helps", "clears"), [
    ((1.9, 3.3), True, True), ((1.9, 3.3), False, False), ((4.0, 2.8), True, False),
], ids=["near", "unwilling", "out_of_reach"])  # fmt: skip
def test_a_person_who_helps_clears_the_doorway_next_to_them_once_asked(
    visit: Any,  # noqa: F811
    at: tuple[float, float],
    helps: bool,
    clears: bool,
) -> None:
    house = visit(objects=[], blocked=["kitchen_living"], people=[{"at": list(at), "helps": helps}])
    doors = house.world.doors
    house.run(lambda: False, 5.0)
    assert doors.is_blocked("kitchen_living"), "no one helps unasked"
    house.connector.publish("/ask_for_help", "std_msgs/msg/String", {"data": "my way is blocked"})
    house.run(lambda: False, 2.9)
    assert doors.is_blocked("kitchen_living"), "it takes a while"
    house.run(lambda: False, 0.2)
    assert doors.is_blocked("kitchen_living") is not clears


def test_a_person_who_blocks_the_only_door_walks_on_once_asked_and_a_far_one_stays(visit: Any) -> None:  # noqa: F811
    stays = {"at": "study_pantry", "walks": [[8.7, 0.6]], "from_s": 1000, "helps": True}
    near = visit(objects=[], people=[stays])
    near.send((6.2, 1.9, 0.0))
    near.finish()
    far = visit(objects=[], people=[stays])
    for house in (near, far):
        house.connector.publish("/ask_for_help", "std_msgs/msg/String", {"data": "my way is blocked"})
        house.run(lambda: False, 8.0)
    moved = [
        math.dist(DOORS["study_pantry"], (one.x, one.y))
        for house in (near, far)
        for one in house.world.residents.people
    ]
    assert moved[0] > 1.0 and moved[1] == 0.0


@pytest.mark.parametrize(
    ("people", "why"),
    [
        (7, "7 is no number of people; give 0 to 6"),
        ("two", "give a number, or a list of at most 6, not 'two'"),
        ([{"at": "cellar"}], "no place 'cellar'"),
        ([{"at": [5.05, 3.0]}], "(5.05, 3) is in a wall, in furniture or outside; the nearest free place is (4.8, 3)"),
        ([{"at": [100, -1]}], "(100, -1) is in a wall, in furniture or outside; the nearest free place is (9.7, 2.9)"),
        ([{"at": [1]}], "[1] is no place; give a name, or x and y"),
        ([{"walks": "kitchen"}], "walks takes a list of places, not 'kitchen'"),
        ([{"speed": 1}], "no field 'speed'"),
        ([{"speed_mps": 9}], "speed_mps takes a number from 0.1 to 2, not 9"),
        ([{"from_s": "now"}], "from_s takes a number from 0 to 1000000, not 'now'"),
        ([{"turn_deg": 400}], "turn_deg takes a number from -360 to 360, not 400"),
        ([{"helps": 1}], "helps takes true or false, not 1"),
        ([{"at": "study", "lies": True, "walks": ["kitchen"]}], "a person who lies does not walk; drop 'lies' or"),
        ([3], "3 is no person"),
    ],
)
def test_people_that_cannot_be_are_reported(people: Any, why: str) -> None:
    with pytest.raises(UsageError) as error:
        open_world("house", camera=False, people=people)
    assert why in str(error.value)
