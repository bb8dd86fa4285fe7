# SPDX-License-Identifier: Apache-2.0
"""Words that no list has and that ask for nothing change no goal; whatever may ask for something is not left out."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.planning.reading import reading_of
from tests.planning.reading.test_rewrites import FLAT

WORDS = st.sampled_from(["quux", "gertrude", "bruised", "verbeulte", "zupfig"])
IN_TRAY = [{"in": ["apple", "tray"]}]


def goal_of(text: str) -> list[dict[str, object]] | None:
    """The predicates that are read of a request at the flat desk; None where none are."""
    found = reading_of(text, FLAT).goal
    return None if found is None else found.written()["all"]


@given(WORDS)
def test_who_is_addressed_and_what_the_only_thing_is_like_change_nothing(word: str) -> None:
    for text in (
        f"{word}, put the apple in the tray", f"put the {word} apple in my {word} tray",
        f"{word} {word}. Apple in the tray",
        f"{word}: put that {word} apple in the tray", f"{word}, leg den {word} Apfel aufs Tablett",
    ):  # fmt: skip
        assert goal_of(text) == IN_TRAY, text


@given(WORDS)
def test_a_word_that_may_name_another_thing_or_choose_among_several_leaves_no_goal(word: str) -> None:
    for text in (
        f"{word}, apple in the tray", f"put the {word} and the apple in the tray", f"put the {word} cube in the tray",
        f"put the {word} cubes in the tray", f"put the apple {word} in the tray", f"{word}: apple, carrot",
        f"{word}. On the tray", f"{word}ly, put the apple in the tray", f"put the apple in the tray, {word}",
    ):  # fmt: skip
        assert goal_of(text) is None, text


@pytest.mark.parametrize("text", ["nicht, put the apple in the tray", "put the nur apple in the tray"])
def test_a_word_that_another_language_knows_is_no_aside(text: str) -> None:
    assert goal_of(text) is None


@pytest.mark.parametrize(
    "text",
    ["put the quux in the tray and the apple in the bin", "the apple in the bin, and a quux on the red cube",
     "apple in the bin; the carrot where the quux was", "bin the apple and quux the carrot"],
)  # fmt: skip
def test_an_offer_lacks_no_thing_and_no_place_of_the_request(text: str) -> None:
    found = reading_of(text, FLAT)
    assert (found.goal, found.candidates) == (None, ())
