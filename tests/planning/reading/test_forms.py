# SPDX-License-Identifier: Apache-2.0
"""A wish in other words is the wish: politeness around it, results in place of orders, lists, verbs in two parts."""

from __future__ import annotations

from collections.abc import Mapping

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from benchmarks.bench_requests import Request, corpus
from rai_missions.planning.reading import is_said, reading_of
from rai_missions.planning.reading.lexicon import lexicon
from rai_missions.planning.text.normalise import each_way
from tests.planning.reading.test_rewrites import FLAT, TOWER

OPENING = ("could", "would", "i would like", "i want", "please", "könntest du", "ich möchte", "hey", "just", "bitte")
"""What frames begin with after which any order may come."""
SAME: Mapping[str, tuple[str, ...]] = {
    "put the apple in the bin": (
        "the bin should hold the apple", "ensure that the bin contains the apple", "bin: the apple",
        "apple: bin", "apple = bin", "apple > bin", "tidy up: the apple in the bin", "chuck the apple in the bin",
        "the apple should land in the bin",
        "move the apple so that it is in the bin", "it would be great if the apple was in the bin",
        "why don't you put the apple in the bin", "der Eimer soll den Apfel enthalten", "Eimer: Apfel",
        "bitte den Apfel in den Eimer hineinlegen", "räum auf: Apfel in den Eimer", "der Apfel wandert in den Eimer",
        "du sollst den Apfel in den Eimer legen",
        "Würdest du so freundlich sein, den Apfel in den Eimer zu legen?",
    ),
    "put the apple and the carrot in the tray": (
        "put the apple in the tray and so should the carrot", "put the apple (and the carrot) in the tray",
        "tray: apple and carrot", "apple and carrot → tray", "Tablett: Apfel und Karotte",
    ),
    "put everything in the tray": (
        "clear the desk into the tray", "tidy the table into the tray", "clean the desk: everything in the tray",
        "räum den Tisch aufs Tablett", "räum alles aufs Tablett",
    ),
    "put the apple and the carrot in the bin": (
        "everything that isn't a cube goes in the bin", "anything that is not a cube in the bin",
        "alles was kein Würfel ist in den Eimer",
    ),
    "put red on blue": (
        "put red_cube on blue_cube", "pleeease put red on blue :)", "Goal: red on blue", "hello there! red on blue 🙂",
        "den roten auf den blauen stapeln", "den roten Würfel auf den blauen drauf",
        "blue on red, no, the other way round", "blauer auf roten, ach nee, andersrum",
    ),
    "put red on blue and green on red": (
        "put red on blue, and green on top", "rot auf blau, und grün obendrauf", "stack red on blue, then green on it",
    ),
    "a tower with green at the bottom, then red, then blue": (
        "green on the very bottom, then red, blue on top", "stack the cubes in this order: green, red, blue",
        "build the cubes into a tower with green at the bottom, red above it and blue on top",
        "Würfel stapeln, unten grün, dann rot",
        "Turm: unten grün, da drauf rot, ganz oben blau", "ganz unten grün, darauf rot, dann blau",
    ),
    "stack the cubes": (
        "the cubes should form a tower", "Bau aus den Würfeln einen Turm", "die Würfel bitte aufeinanderstapeln",
    ),
    "group the cubes": ("the cubes need to be in a group", "die Würfel zusammenschieben"),
    "put all the blue cubes in the bin": ("everything blue in the bin", "anything blue goes into the bin"),
    "bin the apple and leave the cubes where they are": (
        "bin the apple, the cubes stay", "bin the apple, don't touch the cubes",
        "leave the cubes alone and bin the apple",
        "lass die Würfel liegen und leg den Apfel in den Eimer",
    ),
    "put the apple in the tray and the rest in the bin": (
        "put the apple in the tray and the other four in the bin", "Apfel aufs Tablett, Rest in den Eimer",
    ),
    "keep the cubes apart": (
        "no cube may touch any other cube", "the cubes must not be near each other", "none of the cubes should touch",
        "make sure that the cubes are not next to each other", "die Würfel sollen sich nicht berühren",
        "die Würfel nicht nebeneinander",
    ),
    "red on blue, then the apple in the bin": (
        "- red on blue\n- the apple in the bin", "red on blue\nthe apple in the bin",
        "1. red on blue 2. apple in the bin", "step 1: red on blue. step 2: the apple in the bin",
    ),
    "stack red and blue": ("take red and blue and make a tower", "use red and blue to build a tower"),
    "red next to the apple, blue next to the apple": (
        "put red and blue next to the apple", "red and blue around the apple",
    ),
    "put everything in the bin": ("everything off the desk into the bin",),
    "move red 5 cm to the left": ("move red left by 5 cm", "nudge red left 5 cm"),
    "put the cubes in a row": ("line the cubes up next to each other", "reih die Würfel auf"),
    "swap the apple and the carrot": (
        "swap positions of the apple and the carrot", "apple and carrot: trade places", "Tausch Apfel gegen Karotte",
    ),
    "separate the cubes from the apple": ("Trenn die Würfel vom Apfel",),
    "red left of blue, blue left of green": ("red left of blue left of green",),
    "put red next to the apple": ("rot neben den Apfel", "put red right next to the apple", "red nxt to the apple"),
}  # fmt: skip
TWO = [(wish, other) for wish, others in SAME.items() for other in others]
STORED = [each for each in corpus("en") if len(each.wanted.get("goals", ())) == 1]
FRAMES = sorted(
    {
        " ".join(words)
        for code in ("en", "de")
        for phrase in lexicon(code).data["words"]["noise"][""]
        for words in each_way(phrase)
        if " ".join(words).startswith(OPENING)
    }
)


@pytest.mark.parametrize(("wish", "other"), TWO, ids=[other for _, other in TWO])
def test_a_wish_in_other_words_is_the_wish(wish: str, other: str) -> None:
    expected, found = reading_of(wish, FLAT), reading_of(other, FLAT)
    assert expected.goal is not None and found.goal is not None, found.about
    assert found.goal.meaning == expected.goal.meaning
    assert is_said(found.goal, other, FLAT)


def is_read(each: Request) -> bool:
    return reading_of(each.text, each.scene).goal is not None


@settings(max_examples=60, deadline=None)
@given(st.sampled_from(STORED).filter(is_read), st.sampled_from([frame for frame in FRAMES if frame.isascii()]))
def test_a_frame_around_a_request_changes_nothing(request_: Request, frame: str) -> None:
    expected, found = reading_of(request_.text, request_.scene), reading_of(f"{frame} {request_.text}", request_.scene)
    assert expected.goal is not None
    assert found.goal is None or found.goal.meaning == expected.goal.meaning


@settings(max_examples=40, deadline=None)
@given(st.sampled_from(STORED).filter(is_read), st.sampled_from(["because i like quux", "so that we find it, please"]))
def test_a_reason_after_a_request_changes_nothing(request_: Request, reason: str) -> None:
    expected, found = reading_of(request_.text, request_.scene), reading_of(f"{request_.text} {reason}", request_.scene)
    assert expected.goal is not None and found.goal is not None, found.about
    assert found.goal.meaning == expected.goal.meaning


def test_what_follows_a_reason_is_read_again() -> None:
    found = reading_of("put the apple in the bin because it is quux, and put the carrot in the tray", FLAT).goal
    assert found is not None
    assert found.written()["all"] == [{"in": ["apple", "bin"]}, {"in": ["carrot", "tray"]}]


@pytest.mark.parametrize(
    ("text", "reason"),
    [("anything in the bin", "unread"), ("leave the apple alone", "ambiguous"), ("apple, tray", "ambiguous"),
     ("the apple 7 cm to the left", "ambiguous"), ("red on blue and next to green", "ambiguous"),
     ("sort by colour", "ambiguous"), ("throw the apple away", "ambiguous"),
     ("put the apple in the tray and the other three in the bin", "ambiguous")],
)  # fmt: skip
def test_a_form_that_may_mean_something_else_is_asked_about(text: str, reason: str) -> None:
    found = reading_of(text, FLAT)
    assert (found.goal, found.reason) == (None, reason)


def test_what_lies_on_a_tower_is_taken_off_it() -> None:
    found = reading_of("lift blue off the stack and set it down to the right of green", TOWER)
    assert found.goal is not None
    assert found.goal.written()["all"] == [{"on": ["blue_cube", "desk"]}, {"left_of": ["green_cube", "blue_cube"]}]


@pytest.mark.parametrize(
    "text",
    ["the tray holds the apple", "the bin contains the carrot", "the apple lies in the tray",
     "the apple ends up in the bin", "the apple sits on the tray", "the apple could be in the bin",
     "the apple will be in the bin",
     "will the apple go in the bin", "would the apple fit in the bin", "who put the apple in the bin",
     "red touches blue", "you can see the apple in the bin", "bin the apple, otherwise the carrot",
     "the cubes stay in the tray", "no need to stack the cubes", "Das Tablett enthält den Apfel",
     "Der Apfel sitzt auf dem Tablett", "wird der Apfel in den Eimer gelegt", "wer hat den Apfel in den Eimer gelegt",
     "put the apple in the bin. Just kidding.", "don't touch the cubes until the apple is in the bin",
     "leg den Apfel bloß nicht in den Eimer", "2. Würfel von links in die Kiste"],
)  # fmt: skip
def test_what_reports_or_asks_in_other_words_moves_nothing(text: str) -> None:
    assert reading_of(text, FLAT).goal is None


@pytest.mark.parametrize("text", ["open the apple", "peel the carrot and put it in the bin", "den Apfel schälen"])
def test_what_an_arm_does_not_do_is_refused(text: str) -> None:
    assert reading_of(text, FLAT).reason == "forbidden"
