# SPDX-License-Identifier: Apache-2.0
"""What `it`, `them`, `there` and `too` lean on: the clause before."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.planning.reading import reading_of
from tests.planning.reading.stored import goal
from tests.planning.reading.test_things import FILLED

CARROT, TOMATO, CUBE = ({"in": [name, "tray"]} for name in ("carrot", "tomato", "blue_cube"))
NEXT_TO = {"next_to": ["carrot", "tomato"]}


@pytest.mark.parametrize(
    ("request_", "predicates"),
    [
        ("put the carrot in the tray. put the tomato there", [CARROT, TOMATO]),
        ("put the carrot in the tray and the tomato there too", [CARROT, TOMATO]),
        ("put the carrot in the tray and put the tomato into there", [CARROT, TOMATO]),
        ("put the carrot in the bin, and put it in the tray", [{"in": ["carrot", "bin"]}, CARROT]),
        ("put the carrot in the tray, the tomato too, and the blue cube too", [CARROT, TOMATO, CUBE]),
        ("take the vegetables out of the tray and put them in the bin", [{"in": ["tomato", "bin"]}]),
        (
            "put the carrot between the red cube and the blue cube and put it in the tray",
            [{"between": ["carrot", "red_cube", "blue_cube"]}, CARROT],
        ),
    ],
)
def test_what_leans_on_the_clause_before_is_what_that_is_about(request_: str, predicates: list[Any]) -> None:
    assert reading_of(request_, FILLED).goal == goal(*predicates)


def test_after_two_things_side_by_side_it_may_be_either() -> None:
    found = reading_of("put the carrot next to the tomato and put it in the tray", FILLED)
    assert found.goal is None and found.candidates == (goal(NEXT_TO, CARROT), goal(NEXT_TO, TOMATO))


@pytest.mark.parametrize(
    "request_",
    [
        "put it in the tray", "put the tomato there", "swap the carrot and the tomato and put it in the tray",
        "put the carrot in the tray and put them in the bin",
        "build a tower with red at the bottom, yellow in the middle and green on top and put the tomato there",
    ],
)  # fmt: skip
def test_what_leans_on_nothing_that_was_said_is_asked_back(request_: str) -> None:
    assert reading_of(request_, FILLED).outcome == "unclear"
