# SPDX-License-Identifier: Apache-2.0
"""Questions and reports about the desk are no wishes: who asks whether a thing should move has moved nothing."""

from __future__ import annotations

import re

import pytest

from rai_missions.planning.reading import reading_of
from tests.planning.reading.stored import SCENES, goal


@pytest.mark.parametrize(
    ("request_", "word"),
    [
        ("have you put the apple in the bin?", "have you"),
        ("thanks, you have put the apple in the bin", "you have"),
        ("should the apple go in the bin?", "should"),
        ("hey robot, must the apple be in the bin?", "must"),
        ("the apple must have been in the bin", "must have been"),
        ("you should have put the apple in the bin", "should have put"),
        ("red on blue. should the apple be in the bin?", "should"),
        ("soll der Apfel in den Eimer?", "soll"),
        ("gehört der Apfel in den Eimer?", "gehört"),
        ("du hast den Apfel in den Eimer gelegt", "du hast"),
    ],
)
def test_a_question_or_a_report_moves_nothing(request_: str, word: str) -> None:
    found = reading_of(request_, SCENES["full"])
    assert (found.goal, found.candidates, found.reason) == (None, (), "unread") and f"'{word}'" in found.question


@pytest.mark.parametrize(
    "request_",
    [
        "you should put the apple in the bin", "the apple should go in the bin", "could you put the apple in the bin?",
        "please, the apple must be in the bin", "in den Eimer soll der Apfel", "der Apfel gehört in den Eimer",
    ],
)  # fmt: skip
def test_a_wish_with_a_verb_of_a_question_stays_one(request_: str) -> None:
    assert reading_of(request_, SCENES["full"]).goal == goal({"in": ["apple", "bin"]})


@pytest.mark.parametrize("verb", ["could", "can"])
def test_a_request_that_two_things_trade_places_is_one_and_a_question_how_they_lie_is_none(verb: str) -> None:
    found = reading_of(f"{verb} the apple and the carrot trade places?", SCENES["full"])
    assert found.goal == goal({"swapped": ["apple", "carrot"]})
    assert reading_of(f"{verb} the apple and the carrot touch each other?", SCENES["full"]).goal is None


@pytest.mark.parametrize("seen", SCENES)
@pytest.mark.parametrize("colour", ["red", "blue", "green"])
def test_a_question_which_thing_is_meant_names_each_once(seen: str, colour: str) -> None:
    found = reading_of(f"put things that are not {colour} in the bin", SCENES[seen])
    names = re.findall(r"'([^']+)'", found.question.partition("There are")[2])
    assert len({*names}) == len(names)
