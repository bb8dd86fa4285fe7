# SPDX-License-Identifier: Apache-2.0
"""Rows: what is read as one is planned, lies on one line by a geometry of its own, and reads as one that is there."""

from __future__ import annotations

import math
import random
from itertools import combinations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.planning import Plan, Scene, Thing, planned, reached
from rai_missions.planning.reading import is_said, reading_of
from tests.planning.oracle import executed
from tests.planning.reading.stored import goal
from tests.planning.scenes import scene, thing

COLOURS = ("red", "green", "blue", "yellow")
OFF_M = 0.03
"""The tolerance of what is between two things, and rounding."""
APART_M = 0.3
"""The ends of a drawn row leave room for what comes between them."""


def drawn(seed: int, count: int) -> Scene:
    """Cubes at least 8 cm from each other, two of them far apart, and an apple."""
    rng = random.Random(seed)
    places = [(rng.uniform(0.36, 0.6), 0.5 * APART_M), (rng.uniform(0.36, 0.6), -0.5 * APART_M)]
    while len(places) <= count:
        place = rng.uniform(0.36, 0.6), rng.uniform(-0.14, 0.14)
        if all(math.dist(place, other) > 0.08 for other in places):
            places.append(place)
    cubes = [
        thing(f"{colour}_cube", *place, colour=colour, yaw=rng.uniform(-3, 3))
        for colour, place in zip(COLOURS[:count], places, strict=False)
    ]
    return scene(*cubes, thing("apple", *places[count]))


def off_line(things: list[Thing]) -> float:
    """How far the centres are from the line between the two that are farthest from each other, at the most."""
    one, two = max(combinations(things, 2), key=lambda pair: math.hypot(pair[0].x - pair[1].x, pair[0].y - pair[1].y))
    x, y = two.x - one.x, two.y - one.y
    return max(abs((each.x - one.x) * y - (each.y - one.y) * x) / math.hypot(x, y) for each in things)


@settings(max_examples=12, deadline=None)
@given(st.integers(0, 2**32), st.integers(3, 4))
def test_a_row_that_is_read_is_made_and_is_one(seed: int, count: int) -> None:
    seen = drawn(seed, count)
    found = reading_of("put the cubes in a row", seen)
    assert found.goal is not None and found.covers_all and is_said(found.goal, "put the cubes in a row", seen)
    plan = planned(found.goal, seen)
    assert isinstance(plan, Plan)
    after = executed(plan, found.goal, seen).seen()
    assert off_line([each for each in after.things if each.type == "cube"]) < OFF_M
    again = reading_of("line up the cubes", after).goal
    assert again is not None and reached(again, after)


@pytest.mark.parametrize(
    "request_",
    ["line up the cubes", "line the cubes up in a row", "make a row of the cubes", "arrange the cubes in a line",
     "lege die Würfel in eine Reihe", "bilde eine Reihe aus den Würfeln"],
)  # fmt: skip
def test_a_row_may_be_asked_for_in_many_ways(request_: str) -> None:
    seen = scene(thing("red_cube", 0.4, 0.2), thing("green_cube", 0.5, -0.05), thing("blue_cube", 0.4, -0.2))
    assert reading_of(request_, seen).goal == goal({"between": ["green_cube", "red_cube", "blue_cube"]})


def test_a_row_of_two_is_side_by_side_and_of_one_is_asked_about() -> None:
    seen = drawn(0, 3)
    assert reading_of("put the red and the blue cube in a row", seen).goal == goal(
        {"next_to": ["red_cube", "blue_cube"]}
    )
    assert reading_of("put the red cube in a row", seen).reason == "unread"


def test_a_tower_on_the_line_is_no_part_of_a_row_and_a_row_that_is_there_is_one() -> None:
    ends = [thing("red_cube", 0.5, 0.2), thing("yellow_cube", 0.5, -0.2)]
    tower = [thing("green_cube", 0.5, 0.0), thing("blue_cube", 0.5, 0.0, level=0.044)]
    side_by_side = [thing("green_cube", 0.5, -0.05), thing("blue_cube", 0.5, 0.05)]
    for middle, is_row in ((tower, False), (side_by_side, True)):
        seen = scene(*ends, *middle)
        wanted = reading_of("line up the cubes", seen).goal
        assert wanted is not None and reached(wanted, seen) is is_row
