# SPDX-License-Identifier: Apache-2.0
"""A request is refused in its own language: every sentence exists in each, with the same places to fill in."""

from __future__ import annotations

import string
from typing import Any

import pytest

from rai_missions.planning import Refusal, planned
from rai_missions.planning.reading import language_of, reading_of
from rai_missions.planning.sentences import refusal_templates
from tests.planning.drawn import goal_from
from tests.planning.scenes import scene, thing
from tests.planning.test_feasibility import CASES, SEEN

DESK = scene(
    thing("red_cube", 0.5, 0.0, colour="red"),
    thing("blue_cube", 0.4, 0.1, colour="blue"),
    thing("apple", 0.3, 0.2),
    thing("carrot", 0.6, 0.2),
    thing("tomato", 0.3, -0.1),
    thing("tomato_2", 0.3, -0.2),
    thing("tray", 0.55, -0.4),
)
GERMAN = [
    ("stell die Karotte auf den Apfel", "auf 'apple' bleibt nichts liegen: es rollt"),
    ("staple die Tomaten", "kein Turm aus Tomaten: sie rollen"),
    ("leg den roten Würfel in den blauen Würfel",
     "in 'blue_cube' passt nichts hinein; Dinge kommen in eine Schale oder einen Eimer"),
    ("leg den roten Würfel bei x 2 y 0 hin", "(2, 0) liegt nicht auf dem Tisch: 'red_cube' würde fallen"),
    ("leg den roten Würfel bei x 0.9 y 0.2 hin", "der Arm reicht nicht bis (0.9, 0.2)"),
    ("leg den roten Würfel auf den blauen und den blauen auf den roten", "'red_cube' läge über andere auf sich selbst"),
    ("leg die Schale auf den roten Würfel", "'tray' bleibt, wo es ist: Schalen bewegt der Arm nicht"),
]  # fmt: skip


@pytest.mark.parametrize(("request_", "about"), GERMAN)
def test_a_german_request_is_refused_in_german(request_: str, about: str) -> None:
    goal = reading_of(request_, DESK).goal
    assert goal is not None
    found = planned(goal, DESK, language=language_of(request_))
    assert isinstance(found, Refusal) and found.about == about


def places(template: str) -> list[tuple[str | None, str | None]]:
    return sorted((name or "", form) for _, name, form, _ in string.Formatter().parse(template) if name is not None)


def test_both_languages_have_every_sentence_and_fill_in_the_same() -> None:
    english, german = refusal_templates("en"), refusal_templates("de")
    assert english.keys() == german.keys()
    for name, sentence in english.items():
        assert {*places(german[name])} == {*places(sentence)}, name


@pytest.mark.parametrize(("code", "predicates", "about"), CASES)
def test_every_refusal_has_a_german_sentence(code: str, predicates: list[dict[str, Any]], about: str) -> None:
    found = planned(goal_from(predicates), SEEN, language="de")
    assert isinstance(found, Refusal) and found.refused == code
    assert found.about != about and not {"{", "}"} & {*found.about}


def test_a_language_without_a_file_is_answered_in_english() -> None:
    assert refusal_templates("nl") == refusal_templates("en") == refusal_templates("../de")


@pytest.mark.parametrize(
    ("request_", "code"),
    [("stack the tomatoes", "en"), ("staple die Tomaten", "de"), ("apple", "en"), ("", "en"), ("Würfel", "de")],
)
def test_the_language_is_that_with_most_of_the_words(request_: str, code: str) -> None:
    assert language_of(request_) == code
