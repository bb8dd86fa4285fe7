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


@pytest.mark.parametrize("verb", ["is", "looks", "was"])
@given(WORDS)
def test_a_remark_ahead_of_a_wish_gives_what_its_pronoun_means(verb: str, word: str) -> None:
    for text in (
        f"the apple {verb} {word}, put it in the tray", f"I {word} that apple. It should be in the tray",
        f"der Apfel ist {word}, leg ihn aufs Tablett", f"der Apfel ist {word}. Aufs Tablett damit",
    ):  # fmt: skip
        assert goal_of(text) == IN_TRAY, text
    both = [{"swapped": ["apple", "carrot"]}]
    assert goal_of(f"the apple and the carrot {verb} {word}, swap them") == both


@pytest.mark.parametrize(
    "text",
    ["quux the apple, put it in the tray", "the apple is for the carrot, put it in the tray",
     "put the apple down, quux it", "the apples are quux, put it in the tray",
     "the apple until quux, put it in the tray",
     "the apple is quux, put the carrot next to it, then it in the tray"],
)  # fmt: skip
def test_a_remark_that_may_ask_for_something_or_is_of_two_things_leaves_no_goal(text: str) -> None:
    assert goal_of(text) is None


def test_what_is_taken_back_is_no_goal_and_a_whole_wish_after_it_is() -> None:
    assert goal_of("blue on green, never mind") is None
    assert goal_of("blue on green, never mind, red on green") == [{"on": ["red_cube", "green_cube"]}]
    assert goal_of("the apple in the tray, scrap that, in the bin") == [{"in": ["apple", "bin"]}]


def test_who_is_addressed_formally_is_not_what_is_put() -> None:
    assert goal_of("Legen Sie den Apfel aufs Tablett") == IN_TRAY
    assert goal_of("Nehmen Sie bitte den Apfel und legen Sie ihn aufs Tablett") == IN_TRAY


@given(WORDS)
def test_a_word_where_a_thing_is_named_is_asked_about_as_one(word: str) -> None:
    for text in (f"put {word} on the tray", f"put the apple on {word}", f"leg den {word} in den Eimer"):
        found = reading_of(text, FLAT)
        assert (found.goal, found.reason, found.candidates) == (None, "unknown_word", ())
        assert word in found.question and "red cube" in found.question


@pytest.mark.parametrize(
    ("text", "goal"),
    [("the fruit is for the bin, but without the apple", None),
     ("everything in the tray, but without the cubes and the carrot", IN_TRAY),
     ("alles aufs Tablett, aber ohne die Würfel und die Karotte", IN_TRAY),
     ("the tray is for fruit", IN_TRAY), ("das Tablett bekommt den Apfel", IN_TRAY)],
)  # fmt: skip
def test_what_is_left_out_and_what_a_container_is_for(text: str, goal: list[dict[str, object]] | None) -> None:
    assert goal_of(text) == goal
