# SPDX-License-Identifier: Apache-2.0
"""What is offered of a request that is not read as a whole: what the words that are read mean, to be confirmed."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.bench_requests import LANGUAGES, Request, corpus
from rai_missions.planning.reading import read_answer, reading_of
from rai_missions.planning.reading.lexicon import lexicon, lexicons
from tests.planning.reading.test_rewrites import FLAT

REQUESTS = [each for code in LANGUAGES for each in corpus(code)]
ASIDES = (" quux", ", quux", ". Quux xyzzy", ", never mind the quux")
IN_BIN = {"en": "put the apple in the bin", "de": "leg den Apfel in den Eimer"}
TURNING = [f"{word} quux {IN_BIN[code]}" for code in lexicons() for word in sorted(lexicon(code).turning)]


def is_read(each: Request) -> bool:
    return reading_of(each.text, each.scene).goal is not None


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(REQUESTS).filter(is_read), st.sampled_from(ASIDES))
def test_a_request_with_an_aside_is_offered_without_it(request_: Request, aside: str) -> None:
    text, scene, _ = request_
    wanted, found = reading_of(text, scene).goal, reading_of(text.rstrip(".!?") + aside, scene)
    assert wanted is not None
    assert found.goal is None and found.question
    assert not found.candidates or wanted.meaning in {each.meaning for each in found.candidates}


@pytest.mark.parametrize(
    "text",
    ["put that manky apple in the bin", "put the apple in the bin; hygiene matters", "Oi quux! bin the apple",
     "so my teacher wishes, put the apple in the bin, mkay",
     "put the apple in the bin, not in the tray, and do not squint", "put the aple in the binn", "bin the appel",
     "tu den ollen Apfel in den Eimer", "Apfel in den Eimer, nicht werfen"],
)  # fmt: skip
def test_what_is_read_of_a_request_is_offered_and_a_yes_means_it(text: str) -> None:
    found = reading_of(text, FLAT)
    offered = [each.written() for each in ([found.goal] if found.goal is not None else found.candidates)]
    assert offered == [{"all": [{"in": ["apple", "bin"]}]}]
    assert found.goal is not None or read_answer("yes", offered, FLAT)["goal"] == offered[0]


def test_a_list_is_offered_as_a_whole_next_to_a_part_that_is_not_read() -> None:
    found = reading_of("put the apple and the carrot in the bin. no cubes", FLAT)
    assert [each.written()["all"] for each in found.candidates] == [
        [{"in": ["apple", "bin"]}, {"in": ["carrot", "bin"]}]
    ]


@pytest.mark.parametrize("text", TURNING)
def test_without_a_word_that_turns_a_request_nothing_is_offered(text: str) -> None:
    found = reading_of(text, FLAT)
    assert (found.goal, found.candidates) == (None, ())


@pytest.mark.parametrize(
    "text",
    ["do not put the apple in the bin", "quux, smash the carrot and bin the apple", "put { the apple in the bin",
     "should the quux apple go in the bin?", "throw the quux at the wall, put the apple in the bin"],
)  # fmt: skip
def test_of_what_is_negated_forbidden_asked_or_no_language_nothing_is_offered(text: str) -> None:
    found = reading_of(text, FLAT)
    assert (found.goal, found.candidates) == (None, ())
