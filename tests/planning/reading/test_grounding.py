# SPDX-License-Identifier: Apache-2.0
"""What a request says of a goal: each thing and relation by a word, each number in its unit; nothing else is said."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.planning import Scene, at_first_poses
from rai_missions.planning.reading import is_said, reading_of, unsaid
from tests.planning.reading.stored import SCENES, goal

AT = {"at": "red_cube", "x": 0.5, "y": -0.1}


@pytest.mark.parametrize(
    ("request_", "predicate", "missing"),
    [
        ("put the red cube on the blue one", {"on": ["red_cube", "blue_cube"]}, ()),
        ("put the red cube on the blue one", {"on": ["red_cube", "green_cube"]}, ("green_cube",)),
        ("put the red apple in the tray", {"in": ["red_cube", "tray"]}, ("red_cube",)),
        ("stack the cubes", {"on": ["green_cube", "yellow_cube"]}, ()),
        ("stack the cubes", {"on": ["green_cube", "apple"]}, ("apple",)),
        ("stack red on blue", {"on": ["green_cube", "blue_cube"]}, ("green_cube",)),
        ("make a tower with red on top", {"on": ["red_cube", "blue_cube"]}, ()),
        ("vegetables into the bin", {"in": ["carrot", "bin"]}, ()),
        ("vegetables into the bin", {"in": ["apple", "tray"]}, ("apple", "tray")),
        ("put everything in the tray", {"in": ["apple", "tray"]}, ()),
        ("put the cube on the other one", {"on": ["red_cube", "apple"]}, ()),
        ("the red cubes in the tray", {"in": ["blue_cube", "tray"]}, ("blue_cube",)),
        ("red cube at x 50 cm, 10 cm to its right", AT, ()),
        ("red cube at x 50 cm, 10 cm to its left", AT, ("-0.1",)),
        ("red cube at 0.5 and minus zero point one", AT, ()),
        ("red cube at 0.5", AT, ("-0.1",)),
        ("red cube 5 cm left of the blue cube", {"left_of": ["red_cube", "blue_cube"], "gap_m": 0.05}, ()),
        ("red cube left of the blue cube", {"left_of": ["red_cube", "blue_cube"], "gap_m": 0.05}, ("0.05",)),
        ("stell den roten Würfel auf den blauen", {"on": ["red_cube", "blue_cube"]}, ()),
        ("stell den roten Würfel auf den blauen", {"on": ["red_cube", "green_cube"]}, ("green_cube",)),
        ("put the red cube next to the blue one", {"on": ["red_cube", "blue_cube"]}, ("on",)),
        ("put the red cube on the blue one", {"next_to": ["red_cube", "blue_cube"]}, ("next_to",)),
        ("put the red cube on the blue one", {"apart": ["red_cube", "blue_cube"]}, ("apart",)),
        ("do not put the red cube on the blue one", {"on": ["red_cube", "blue_cube"]}, ("on",)),
        ("what about the red cube and the blue cube?", {"grouped": ["red_cube", "blue_cube"]}, ("grouped",)),
        ("the apple and the tray", {"in": ["apple", "tray"]}, ("in",)),
        ("the red cube left of the blue cube", {"left_of": ["red_cube", "blue_cube"]}, ()),
        ("den roten Würfel neben den blauen", {"on": ["red_cube", "blue_cube"]}, ("on",)),
        ("", {"on": ["red_cube", "blue_cube"]}, ("red_cube", "blue_cube", "on")),
    ],
)  # fmt: skip
def test_each_thing_number_and_relation_needs_a_word(request_: str, predicate: Any, missing: tuple[str, ...]) -> None:
    assert unsaid(goal(predicate), request_, SCENES["full"]) == missing
    if "other" not in request_:
        assert unsaid(goal(predicate), request_) == missing


def test_a_name_without_a_type_in_it_needs_the_scene() -> None:
    apple = SCENES["kitchen"].thing("apple").model_copy(update={"name": "thing_7"})
    scene = Scene(things=(apple,))
    wanted = goal({"on": ["thing_7", "desk"]})
    assert is_said(wanted, "the apple on the desk", scene)
    assert not is_said(wanted, "the apple on the desk")


def test_a_swap_says_the_places_of_its_things() -> None:
    scene = SCENES["cubes"]
    wanted = at_first_poses(goal({"swapped": ["red_cube", "blue_cube"]}), scene)
    assert is_said(wanted, "swap the red and the blue cube", scene)
    assert not is_said(wanted, "put the red and the blue cube together", scene)
    assert not is_said(goal({"at": "red_cube", "x": 0.4, "y": 0.1}), "swap the red and the blue cube", scene)


@pytest.mark.parametrize(
    "request_", ["take the apple out of the tray", "remove the apple from the tray", "nimm den Apfel aus dem Tablett"]
)
def test_what_is_taken_out_is_wanted_on_the_desk(request_: str) -> None:
    wanted = reading_of(request_, SCENES["full"]).goal
    assert wanted == goal({"on": ["apple", "desk"]}) and is_said(wanted, request_, SCENES["full"])


def test_where_a_thing_comes_from_says_nothing_of_where_it_is_to_be() -> None:
    assert reading_of("put the apple from the tray in the bin", SCENES["full"]).goal == goal({"in": ["apple", "bin"]})
