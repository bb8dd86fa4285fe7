# SPDX-License-Identifier: Apache-2.0
"""Whole wishes with `or` between them: a person chooses; no request for one of two is read as one for both."""

from __future__ import annotations

import pytest

from rai_missions.planning.reading import reading_of
from tests.planning.reading.stored import SCENES, goal

ON_BLUE = goal({"on": ["red_cube", "blue_cube"]})
ON_YELLOW = goal({"on": ["green_cube", "yellow_cube"]})


@pytest.mark.parametrize(
    "request_",
    [
        "put red on blue, or green on yellow",
        "red on blue or green on yellow",
        "either put the red cube on the blue one or put green on yellow",
        "stack red on blue or green on yellow",
        "entweder rot auf blau oder grün auf gelb",
        "stell rot auf blau, oder grün auf gelb",
    ],
)
def test_one_of_two_wishes_is_asked_back(request_: str) -> None:
    found = reading_of(request_, SCENES["full"])
    assert found.goal is None and found.candidates == (ON_BLUE, ON_YELLOW)


def test_of_two_wishes_that_exclude_each_other_one_is_chosen() -> None:
    found = reading_of("red on blue or blue on red", SCENES["full"])
    assert found.candidates == (ON_BLUE, goal({"on": ["blue_cube", "red_cube"]}))


def test_a_choice_of_things_within_a_wish_stays_one() -> None:
    found = reading_of("put the red cube on the blue or the green one, and yellow in the tray", SCENES["full"])
    in_tray = {"in": ["yellow_cube", "tray"]}
    assert found.candidates == tuple(goal({"on": ["red_cube", name]}, in_tray) for name in ("blue_cube", "green_cube"))
