# SPDX-License-Identifier: Apache-2.0
"""Where things are to be: behind and between others, so far from where they are, where they are; and which, if any."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.planning import Goal, at_first_poses
from rai_missions.planning.reading import is_said, read_request, reading_of
from tests.planning.reading.stored import SCENES, goal

CUBES, KITCHEN = SCENES["cubes"], SCENES["uncoloured"]


def read(request: str, scene: Any = KITCHEN) -> Goal | None:
    found = reading_of(request, scene)
    assert found.goal is None or is_said(found.goal, request, scene)
    return found.goal


@pytest.mark.parametrize(
    ("request_", "predicate"),
    [
        ("put the red cube behind the blue one", {"behind": ["red_cube", "blue_cube"]}),
        ("place the carrot in front of the red cube", {"behind": ["red_cube", "carrot"]}),
        ("put the red cube 10 cm behind the blue cube", {"behind": ["red_cube", "blue_cube"], "gap_m": 0.1}),
        ("behind the blue cube, put the red cube", {"behind": ["red_cube", "blue_cube"]}),
        ("stell den roten Würfel hinter den blauen", {"behind": ["red_cube", "blue_cube"]}),
        ("leg die Karotte vor den roten Würfel", {"behind": ["red_cube", "carrot"]}),
        ("put the apple between the red and the blue cube", {"between": ["apple", "red_cube", "blue_cube"]}),
        ("between the tray and the bin, put the corn", {"between": ["corn", "tray", "bin"]}),
        ("leg den Apfel zwischen den roten und den blauen Würfel", {"between": ["apple", "red_cube", "blue_cube"]}),
    ],
)
def test_behind_and_between_are_relations_to_other_things(request_: str, predicate: dict[str, Any]) -> None:
    assert read(request_) == goal(predicate)


@pytest.mark.parametrize(
    "request_",
    [
        "put the apple between the cubes", "put the apple between the red cube", "put it behind the red cube",
        "put the apple and the corn between the red and the blue cube", "take the cube behind the apple",
        "put the apple with a gap of 5 cm between the red and the blue cube", "is the apple behind the red cube",
    ],
)  # fmt: skip
def test_what_leaves_open_where_is_asked_back(request_: str) -> None:
    assert read(request_) is None


SIDES = {"to the left": (0, 1), "to the right": (0, -1), "forward": (1, 0), "backwards": (-1, 0), "left": (0, 1)}


@given(st.integers(1, 30), st.sampled_from(sorted(SIDES)), st.sampled_from(["move", "push", "slide"]))
def test_so_far_to_a_side_is_counted_from_where_a_thing_is(centimetres: int, side: str, verb: str) -> None:
    request = f"{verb} the red cube {centimetres} cm {side}"
    dx, dy = (round(sign * centimetres * 0.01, 6) for sign in SIDES[side])
    assert read(request, CUBES) == goal({"shifted": "red_cube", "dx": dx, "dy": dy})
    here, data = CUBES.thing("red_cube"), read_request(request, CUBES)
    (at,) = data["goal"]["all"]
    assert (at["x"], at["y"]) == pytest.approx((here.x + dx, here.y + dy), abs=1e-4)
    assert not data["covers_all"], "read once more it would be moved once more"
    assert is_said(goal(at), request, CUBES)
    assert not is_said(goal({**at, "x": at["x"] + 0.0137}), request, CUBES)


def test_what_is_shifted_is_not_read_again_over_what_is_seen_later() -> None:
    shifted, put = (read_request(text, CUBES) for text in ("move the cubes 5 cm forward", "put the cubes on the desk"))
    assert len(shifted["goal"]["all"]) == len(CUBES.things)
    assert (shifted["covers_all"], put["covers_all"]) == (False, True)


@pytest.mark.parametrize(
    "request_",
    [
        "move the red cube 10 to the left", "put the red cube 10 cm to the left", "move the red cube to the left",
        "move the red cube 10 cm to the left and put it on the blue one",
        "move the red cube 5 cm ahead, 10 cm to the left",
    ],
)  # fmt: skip
def test_a_shift_needs_one_side_a_unit_and_no_other_place(request_: str) -> None:
    assert read(request_, CUBES) is None


@pytest.mark.parametrize(
    "request_",
    [
        "leave the red cube where it is and put the blue cube on it",
        "put the blue cube on the red one and leave the red one where it is",
        "lass den roten Würfel, wo er ist, und stell den blauen auf den roten",
    ],
)
def test_what_stays_where_it_is_has_the_place_first_seen(request_: str) -> None:
    found, stays = read(request_, CUBES), {"shifted": "red_cube", "dx": 0.0, "dy": 0.0}
    assert found is not None and found.meaning == goal(stays, {"on": ["blue_cube", "red_cube"]}).meaning
    there = at_first_poses(found, CUBES)
    here = CUBES.thing("red_cube")
    assert {"at": "red_cube", "x": here.x, "y": here.y} in there.written()["all"]


def test_where_it_was_is_no_place() -> None:
    assert read("put the red cube where it was", CUBES) is None


def test_the_rest_of_a_tower_is_what_can_be_stacked() -> None:
    found = read("leave the red cube where it is and stack the others")
    assert found is not None and {*found.things()} == {"red_cube", "blue_cube", "green_cube", "yellow_cube"}


@pytest.mark.parametrize(
    ("request_", "count"),
    [
        ("put any cube in the tray", 1), ("put any two cubes in the tray", 2), ("any one of the cubes in the bin", 1),
        ("leg zwei beliebige Würfel in das Tablett", 2), ("put any four cubes in the tray", 4),
    ],
)  # fmt: skip
def test_any_leaves_the_choice_to_the_arm(request_: str, count: int) -> None:
    found = read(request_)
    assert found is not None and len(found.all) == count
    assert all(KITCHEN.thing(each.things()[0]).type == "cube" for each in found.all)
    assert not read_request(request_, KITCHEN)["covers_all"] or count == 4


def test_any_is_none_of_those_that_are_named() -> None:
    found = read("put any cube on the red cube")
    assert found is not None and found.all[0].things() != ("red_cube", "red_cube")
    both = read("put the blue cube in the bin and any two cubes in the tray")
    assert both is not None and [each.things()[0] for each in both.all].count("blue_cube") == 1
    assert read("put any five cubes in the tray") is None


def test_what_lies_under_something_is_chosen_last() -> None:
    blue = KITCHEN.thing("blue_cube")
    on_red = blue.moved(KITCHEN.thing("red_cube").x, KITCHEN.thing("red_cube").y, blue.z + 0.044)
    things = tuple(on_red if each.name == "blue_cube" else each for each in KITCHEN.things)
    found = read("put any three cubes in the tray", KITCHEN.model_copy(update={"things": things}))
    assert found is not None and "red_cube" not in found.things()


@pytest.mark.parametrize(
    ("request_", "thing"),
    [
        ("put the apple in the tray, no, the tomato", "tomato"),
        ("put the apple in the tray. No, the tomato", "tomato"),
        ("leg den Apfel in das Tablett, nein, die Tomate", "tomato"),
        ("put the blue cube in the tray, no, the red one", "red_cube"),
    ],
)  # fmt: skip
def test_a_no_alone_takes_back_what_was_said(request_: str, thing: str) -> None:
    assert read(request_) == goal({"in": [thing, "tray"]})


def test_of_two_that_may_be_meant_by_a_correction_none_is_taken() -> None:
    assert read("put the apple on the red cube, no, the tomato") is None


def test_no_before_a_thing_negates() -> None:
    assert read("put the apple in the tray, no tomato") is None
