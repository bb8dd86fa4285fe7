# SPDX-License-Identifier: Apache-2.0
"""Things that are meant by their place in an order: the leftmost, the second from the left, the nearest to a tray."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

import pytest
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from rai_missions.planning import Scene, Thing
from rai_missions.planning.reading import is_said, reading_of
from tests.planning.reading.stored import goal
from tests.planning.scenes import scene, thing

NAMES = ("red_cube", "green_cube", "blue_cube", "yellow_cube")
OFF_M = 0.03
"""Two places by an order are so far from each other, or the same for a person."""
ROOM = thing("tray", 0.62, 0.0)
Key = Callable[[Thing], float]
ORDERS: Mapping[str, Key] = {
    "leftmost": lambda each: -each.y,
    "rightmost": lambda each: each.y,
    "furthest to the left": lambda each: -each.y,
    "closest to you": lambda each: math.hypot(each.x, each.y),
    "farthest from the robot": lambda each: -math.hypot(each.x, each.y),
    "from the left": lambda each: -each.y,
    "from the right": lambda each: each.y,
}
BEFORE = ("leftmost", "rightmost")


@st.composite
def desks(draw: st.DrawFn) -> Scene:
    """Two to four cubes at drawn places, and a tray."""
    places = st.tuples(st.integers(8, 18), st.integers(-12, 12))
    drawn = draw(st.lists(places, min_size=2, max_size=4, unique=True))
    cubes = [thing(name, OFF_M * x, OFF_M * y) for name, (x, y) in zip(NAMES, drawn, strict=False)]
    return scene(*cubes, ROOM)


def cubes_of(desk: Scene, key: Key) -> list[Thing]:
    return sorted((each for each in desk.things if each.type == "cube"), key=key)


@settings(max_examples=60, deadline=None)
@given(desks(), st.sampled_from(sorted(ORDERS)))
def test_the_first_of_an_order_is_meant_where_it_leads_clearly_and_else_each_that_may_lead(
    desk: Scene, words: str
) -> None:
    key = ORDERS[words]
    request = f"put the {words} cube on the tray" if words in BEFORE else f"put the cube {words} on the tray"
    first, *others = cubes_of(desk, key)
    leads = [each for each in others if key(each) - key(first) < OFF_M / 2]
    found = reading_of(request, desk)
    if not leads:
        assert found.goal == goal({"in": [first.name, "tray"]}) and not found.covers_all
        assert is_said(found.goal, request, desk) and is_said(found.goal, request)
    else:
        assert {each.all[0].things()[0] for each in found.candidates} >= {each.name for each in (first, *leads)}
        assert found.goal is None


@settings(max_examples=40, deadline=None)
@given(desks(), st.integers(1, 4), st.sampled_from(["left", "right"]))
def test_a_place_of_an_order_is_counted_from_its_end(desk: Scene, place: int, side: str) -> None:
    order = cubes_of(desk, ORDERS[f"from the {side}"])
    assume(len({round(each.y, 3) for each in order}) == len(order) >= place)
    word = ("first", "second", "third", "fourth")[place - 1]
    found = reading_of(f"put the {word} cube from the {side} on the tray", desk).goal
    assert found == goal({"in": [order[place - 1].name, "tray"]})


@settings(max_examples=40, deadline=None)
@given(desks(), st.integers(1, 3))
def test_those_that_are_counted_and_all_but_those_are_all(desk: Scene, count: int) -> None:
    order = cubes_of(desk, ORDERS["leftmost"])
    assume(len({round(each.y, 3) for each in order}) == len(order) > count)
    meant = "leftmost cube" if count == 1 else f"{count} leftmost cubes"
    chosen = reading_of(f"put the {meant} on the tray", desk).goal
    others = reading_of(f"put all the cubes except the {meant} on the tray", desk)
    assert chosen is not None and others.goal is not None and not others.covers_all
    assert {*chosen.things()} - {"tray"} == {each.name for each in order[:count]}
    assert {*chosen.things()} ^ {*others.goal.things()} == {each.name for each in order}


@settings(max_examples=40, deadline=None)
@given(desks())
def test_on_a_desk_in_a_mirror_left_is_right(desk: Scene) -> None:
    mirrored = desk.model_copy(update={"things": tuple(each.moved(each.x, -each.y, each.z) for each in desk.things)})
    one, other = (
        reading_of(f"put the {words} cube on the tray", each)
        for words, each in (("leftmost", desk), ("rightmost", mirrored))
    )
    assert (one.goal, one.candidates) == (other.goal, other.candidates)


DESK = scene(
    thing("red_cube", 0.4, 0.25),
    thing("blue_cube", 0.6, -0.05),
    thing("apple", 0.33, 0.14),
    thing("carrot", 0.35, -0.2),
    thing("tray", 0.6, 0.3),
    thing("bin", 0.62, -0.3),
)


@pytest.mark.parametrize(
    ("request_", "predicate"),
    [
        ("put the left cube in the bin", {"in": ["red_cube", "bin"]}),
        ("move the cube on the left onto the cube on the right", {"on": ["red_cube", "blue_cube"]}),
        ("put the cube that is closest to the tray in the bin", {"in": ["red_cube", "bin"]}),
        ("put the thing farthest away from the bin on the tray", {"in": ["red_cube", "tray"]}),
        ("swap the leftmost and the rightmost cube", {"swapped": ["red_cube", "blue_cube"]}),
        ("put the leftmost thing that is not a cube in the bin", {"in": ["apple", "bin"]}),
        ("put all the cubes but not the rightmost in the bin", {"in": ["red_cube", "bin"]}),
        ("put the second cube from the left on the first from the left", None),
        ("put the larger of the two in the bin", None),
        ("lege den linken Würfel in den Eimer", {"in": ["red_cube", "bin"]}),
        ("lege den Würfel am weitesten links in den Eimer", {"in": ["red_cube", "bin"]}),
        ("lege den zweiten Würfel von links in den Eimer", {"in": ["blue_cube", "bin"]}),
    ],
)
def test_a_thing_is_meant_by_its_place(request_: str, predicate: object) -> None:
    assert reading_of(request_, DESK).goal == (goal(predicate) if predicate else None)


def test_the_rightmost_of_a_tower_is_one_that_can_be_stacked() -> None:
    found = reading_of("stack the cubes, the rightmost on top", DESK).goal
    assert found == goal({"on": ["red_cube", "desk"]}, {"on": ["blue_cube", "red_cube"]})


@pytest.mark.parametrize(
    ("request_", "reason"),
    [
        ("put the biggest cube on the tray", ""),
        ("put the nearest cube on the tray", ""),
        ("put the left thing on the tray", ""),
        ("put the apple on the far left next to the bin", "ambiguous"),
        ("put the leftmost cube on the far right next to the bin", "unread"),
        ("put the leftmost cubes on the tray", "ambiguous"),
        ("put the second cube on the tray", "unread"),
        ("put a leftmost cube on the tray", "unread"),
        ("put the cubes on the tray, but the leftmost one first", "negated"),
        ("move the red cube to the right side of the table", "coordinates"),
    ],
)
def test_an_order_that_is_open_is_asked_about(request_: str, reason: str) -> None:
    found = reading_of(request_, DESK)
    assert found.goal is None and found.question
    assert found.reason == reason if reason else len(found.candidates) > 1
