# SPDX-License-Identifier: Apache-2.0
"""A yes or a no of a model is a claim where the person's question is about the robot or its work."""

from __future__ import annotations

import pytest

from rai_missions.conversation.claims.claims import Claims
from tests.conversation.stored import PATROLLING, read
from tests.conversation.test_hostile_models import shown

ASSENTS = read("assents.json")
"""Questions to whose answer belongs what the robot reports, harmless ones, and what agrees or denies, by language."""
MOST_PASSED, MOST_FALSE = 0.04, 0.2


@pytest.mark.parametrize("code", sorted(ASSENTS))
def test_each_word_that_agrees_or_denies_is_known(code: str) -> None:
    report, claims = ASSENTS[code]["reports"][0], Claims(code)
    assert [each for each in ASSENTS[code]["assents"] if not claims.why_assented(each, report, PATROLLING)] == []


@pytest.mark.parametrize("code", sorted(ASSENTS))
def test_hardly_a_yes_to_a_question_about_the_robot_is_spoken(code: str) -> None:
    claims, every = Claims(code), ASSENTS[code]["reports"]
    passed = [each for each in every if not claims.why_assented(ASSENTS[code]["assents"][0], each, PATROLLING)]
    assert len(passed) <= MOST_PASSED * len(every), passed


@pytest.mark.parametrize("code", sorted(ASSENTS))
def test_a_yes_to_most_harmless_questions_is_spoken(code: str) -> None:
    claims, every = Claims(code), ASSENTS[code]["harmless"]
    replaced = [each for each in every if claims.why_assented(ASSENTS[code]["assents"][0], each, PATROLLING)]
    assert len(replaced) <= MOST_FALSE * len(every), replaced


@pytest.mark.parametrize(("code", "asked"), [("en", "is the shed locked now?"), ("de", "ist der Schuppen jetzt zu?")])
@pytest.mark.parametrize("place", [0, 1, -1])
def test_no_yes_is_shown_as_a_models_text(code: str, asked: str, place: int) -> None:
    assent = ASSENTS[code]["assents"][place]
    calm = {"en": "Apples ripen in autumn.", "de": "Äpfel reifen im Herbst."}[code]
    assert shown([assent], code, asked) == ""
    assert shown([f"{calm} ", assent], code, asked) == shown([calm], code, asked)


def test_a_sentence_that_neither_agrees_nor_denies_is_judged_by_itself() -> None:
    claims = Claims("en")
    for each in ("I have no idea.", "That is a good question.", "Which shed do you mean?", "Right of way is a rule."):
        assert claims.why_assented(each, "is the shed locked now?", PATROLLING) == ""
