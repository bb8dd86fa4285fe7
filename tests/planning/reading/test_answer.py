# SPDX-License-Identifier: Apache-2.0
"""What a person answers to "did you mean" is one of the candidates, or none."""

from __future__ import annotations

import pytest

from rai_missions.planning.reading import chosen, reading_of
from tests.planning.reading.stored import SCENES


@pytest.mark.parametrize(
    ("answer", "place"),
    [
        ("the first", 0), ("The second one, please", 1), ("2", 1), ("option two", 1), ("the last one", 1),
        ("the blue one", 0),
        ("I mean the green one", 1), ("green", 1), ("put the red cube on the green cube", 1), ("das zweite", 1),
        ("den grünen", 1), ("yes", None), ("no", None), ("the red one", None), ("the third", None), ("the apple", None),
        ("whatever", None), ("", None), ("0", None),
    ],
)  # fmt: skip
def test_one_of_several_is_named_counted_or_given_in_full(answer: str, place: int | None) -> None:
    reading = reading_of("put the red cube on the blue or the green one", SCENES["cubes"])
    assert reading.question == "Did you mean: the red cube on the blue cube or the red cube on the green cube?"
    expected = None if place is None else reading.candidates[place]
    assert chosen(answer, reading.candidates, SCENES["cubes"]) == expected


@pytest.mark.parametrize(
    ("answer", "is_meant"), [("yes", True), ("Ja, genau!", True), ("no", False), ("nein", False), ("1", True)]
)
def test_a_yes_means_the_only_one(answer: str, is_meant: bool) -> None:
    reading = reading_of("throw the tomato away", SCENES["kitchen"])
    assert reading.outcome == "unclear"
    assert (chosen(answer, reading.candidates, SCENES["kitchen"]) is not None) is is_meant
    assert chosen(answer, (), SCENES["kitchen"]) is None


@pytest.mark.parametrize("part", ["in the middle", "at the bottom", "at the top"])
def test_a_part_of_the_desk_is_no_level_of_a_tower(part: str) -> None:
    reading = reading_of(f"put the red cube {part} of the desk", SCENES["cubes"])
    assert reading.question == "A place has x and y in metres. Which did you mean?"
