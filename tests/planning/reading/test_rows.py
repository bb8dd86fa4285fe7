# SPDX-License-Identifier: Apache-2.0
"""Rows: what is read as one is planned, lies on one line by a geometry of its own, and reads as one that is there."""

from __future__ import annotations

import math
import random
from itertools import combinations, pairwise

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


GERMAN = {"red": "rot", "green": "grün", "blue": "blau", "yellow": "gelb"}
ROWS = (
    ("{0}, {1}, {2} in a row from left to right", False), ("in a row: {0}, then {1}, {2}, from left to right", False),
    ("a row, from left to right: {0}, {1}, {2}", False), ("line up {0}, {1} and {2} from right to left", True),
    ("{0}, {1}, {2} in eine Reihe von links nach rechts", False),
    ("{0}, {1} und {2} der Reihe nach, von rechts: {0}, {1}, {2}", True),
)  # fmt: skip


@pytest.mark.parametrize(("form", "is_from_right"), ROWS)
@given(st.permutations(COLOURS[:3]))
def test_an_order_within_a_row_is_that_of_its_words(form: str, is_from_right: bool, order: list[str]) -> None:
    seen, text = drawn(1, 4), form.format(*(GERMAN[each] for each in order) if "eihe" in form else order)
    names = [f"{colour}_cube" for colour in (reversed(order) if is_from_right else order)]
    found = reading_of(text, seen).goal
    assert found is not None and is_said(found, text, seen)
    assert found.written()["all"] == [{"left_of": list(pair)} for pair in pairwise(names)]


def test_without_a_side_an_order_within_a_row_is_offered() -> None:
    found = reading_of("in a row: red, then blue, then green", drawn(1, 4))
    assert found.goal is None and len(found.candidates) == 1


@pytest.mark.parametrize("side", ["left", "right"])
def test_the_ends_of_a_row_are_those_that_are_given(side: str) -> None:
    seen = drawn(2, 4)
    for colour in COLOURS:
        text = f"put the cubes in a row with {colour} on the far {side}"
        found = reading_of(text, seen).goal
        assert found is not None and is_said(found, text, seen)
        first = next(iter(found.written()["all"]))["left_of"]
        assert first[0 if side == "left" else 1] == f"{colour}_cube"


def test_what_is_on_the_left_is_left_of_all_that_is_on_the_right() -> None:
    seen = drawn(3, 4)
    for text in (
        "red and blue on the left, green on the right", "rot und blau links, grün rechts",
        "on the right put green, on the left: red and blue", "links rot und blau, rechts grün",
    ):  # fmt: skip
        found = reading_of(text, seen).goal
        assert found is not None and is_said(found, text, seen)
        assert found.written()["all"] == [{"left_of": [name, "green_cube"]} for name in ("red_cube", "blue_cube")]


def test_without_a_side_of_the_other_thing_or_after_a_verb_of_moving_no_side_is_a_relation() -> None:
    for text in ("red on the left", "move red to the left and blue to the right", "red left, blue left"):
        assert reading_of(text, drawn(3, 4)).goal is None, text


def test_a_chain_with_its_lowest_named_is_a_tower_of_what_came_before() -> None:
    seen = drawn(4, 3)
    for text in (
        "stack the cubes with red over blue over green",
        "the cubes get piled with red on blue on green at the base",
    ):
        found = reading_of(text, seen).goal
        assert found is not None and is_said(found, text, seen)
        assert [each["on"] for each in found.written()["all"]] == [
            ["green_cube", "desk"], ["blue_cube", "green_cube"], ["red_cube", "blue_cube"],
        ]  # fmt: skip
    assert reading_of("stack the cubes with red on the tray", seen).goal is None


@pytest.mark.parametrize(
    "text",
    ["swap red with blue and green with yellow", "red swaps with blue, and swap green and yellow",
     "tausche Rot mit Blau und Grün mit Gelb"],
)  # fmt: skip
def test_several_pairs_are_exchanged(text: str) -> None:
    found = reading_of(text, drawn(6, 4)).goal
    assert found is not None
    pairs = [{"swapped": ["red_cube", "blue_cube"]}, {"swapped": ["green_cube", "yellow_cube"]}]
    assert found.written()["all"] == pairs


@pytest.mark.parametrize(
    "text",
    ["put green in the middle, red on its left and blue on its right",
     "Grün in die Mitte, Rot links davon, Blau rechts davon"],
)  # fmt: skip
def test_what_is_in_the_middle_is_what_the_sides_are_of(text: str) -> None:
    found = reading_of(text, drawn(7, 3)).goal
    assert found is not None
    assert found.written()["all"] == [{"left_of": ["red_cube", "green_cube"]}, {"left_of": ["green_cube", "blue_cube"]}]


def test_several_towers_of_a_height_are_made_of_what_is_listed_in_turn() -> None:
    seen = drawn(4, 4)
    found = reading_of("two piles of two: red/green, blue/yellow", seen).goal
    assert found is not None
    assert [each["on"] for each in found.written()["all"]] == [
        ["red_cube", "desk"], ["green_cube", "red_cube"], ["blue_cube", "desk"], ["yellow_cube", "blue_cube"],
    ]  # fmt: skip
    assert reading_of("two piles of three: red/green, blue/yellow", seen).goal is None


@pytest.mark.parametrize(
    ("text", "pair"),
    [("put the apple on the red cube's right", ["red_cube", "apple"]),
     ("the apple to the red cube's left", ["apple", "red_cube"])],
)  # fmt: skip
def test_a_side_of_a_thing_is_a_relation_to_it(text: str, pair: list[str]) -> None:
    found = reading_of(text, drawn(5, 4)).goal
    assert found is not None and found.written()["all"] == [{"left_of": pair}]
