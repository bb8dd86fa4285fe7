# SPDX-License-Identifier: Apache-2.0
"""Where things are to be: parts of a place without numbers and gaps below nothing are asked back, rows are read."""

from __future__ import annotations

import pytest

from rai_missions.planning.reading import reading_of
from tests.planning.reading.stored import SCENES, goal


@pytest.mark.parametrize(
    "request_",
    [
        "put the red cube at the bottom of the bin", "put the red cube at the bottom of the tray",
        "put the red cube in the middle of the tray", "put the apple at the top of the desk",
    ],
)  # fmt: skip
def test_a_part_of_a_place_is_no_level_of_a_tower(request_: str) -> None:
    found = reading_of(request_, SCENES["full"])
    assert (found.goal, found.reason) == (None, "coordinates")


@pytest.mark.parametrize("request_", ["the carrot -5 cm left of the apple", "die Karotte -5 cm links vom Apfel"])
def test_a_gap_below_nothing_is_asked_back(request_: str) -> None:
    found = reading_of(request_, SCENES["full"])
    assert found.reason == "number" and "'-5'" in found.question


@pytest.mark.parametrize(
    "request_",
    [
        "arrange the cubes in a row from left to right: red, green, blue, yellow",
        "in a line from right to left: yellow, blue, green, red",
        "in einer Reihe von links nach rechts: rot, grün, blau, gelb",
    ],
)
def test_a_row_is_from_left_to_right(request_: str) -> None:
    pairs = (("red", "green"), ("green", "blue"), ("blue", "yellow"))
    wanted = goal(*({"left_of": [f"{one}_cube", f"{other}_cube"]} for one, other in pairs))
    assert reading_of(request_, SCENES["full"]).goal == wanted
