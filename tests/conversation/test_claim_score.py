# SPDX-License-Identifier: Apache-2.0
"""The score of a sentence's words: learned from what is stored, and good for writers of whom nothing was learned."""

from __future__ import annotations

import hashlib
import json

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.conversation import StatusView
from rai_missions.conversation.claims.claim_score import claim_weights, features
from rai_missions.conversation.claims.claims import Claims
from rai_missions.conversation.claims.judged_sentence import CERTAIN
from tests.conversation.stored import CLAIMS, read

VIEW = StatusView(robot="rosbot, simulated", mission="rosbot_patrol")
CODES = ("en", "de")
MOST_REPLACED = 0.2
"""Of the harmless sentences of a writer of whom nothing was learned."""


GROUPS = [CLAIMS, *read("claims_learned.json")["writers"]]


@pytest.mark.parametrize("code", CODES)
def test_the_weights_were_learned_from_the_sentences_that_are_stored(code: str) -> None:
    """Else `scripts/claim_weights.py` is to be run again."""
    stored = [[group["claims"][code], group["harmless"][code]] for group in GROUPS]
    digest = hashlib.sha256(json.dumps(stored, ensure_ascii=False).encode()).hexdigest()
    assert claim_weights(code).learned_from == digest


@pytest.mark.parametrize("code", CODES)
def test_nothing_was_learned_from_what_is_held_out(code: str) -> None:
    learned = {text for group in GROUPS for kind in ("claims", "harmless") for text in group[kind][code]}
    held_out = read("claims_held_out.json")
    assert not learned & {*held_out["claims"][code], *held_out["harmless"][code]}


@pytest.mark.parametrize("code", CODES)
def test_of_a_writer_who_is_unknown_no_claim_passes_and_few_other_sentences_are_replaced(code: str) -> None:
    claims, held_out = Claims(code), read("claims_held_out.json")
    assert [each for each in held_out["claims"][code] if not claims.why_replaced(each, VIEW)] == []
    replaced = [each for each in held_out["harmless"][code] if claims.why_replaced(each, VIEW)]
    assert len(replaced) <= MOST_REPLACED * len(held_out["harmless"][code]), replaced


@pytest.mark.parametrize("code", CODES)
def test_the_score_takes_back_no_certain_claim(code: str) -> None:
    claims, held_out = Claims(code), read("claims_held_out.json")
    for sentence in (*held_out["claims"][code], *held_out["harmless"][code]):
        suspected = claims.why_suspected(sentence, VIEW)
        assert claims.why_replaced(sentence, VIEW) == suspected or suspected not in CERTAIN


@pytest.mark.parametrize("code", CODES)
def test_a_claim_that_no_rule_finds_is_found_by_its_words(code: str) -> None:
    claims = Claims(code)
    missed = [each for group in GROUPS for each in group["claims"][code] if not claims.why_suspected(each, VIEW)]
    found = [each for each in missed if claims.why_replaced(each, VIEW)]
    assert missed
    assert len(found) > 0.6 * len(missed)


@pytest.mark.parametrize("code", CODES)
def test_words_that_are_unknown_leave_a_sentence_in_doubt(code: str) -> None:
    weights = claim_weights(code)
    assert weights.score("Qwx zzyq vvxj.") > weights.least


@given(st.text(max_size=60))
def test_a_score_depends_on_the_text_alone(text: str) -> None:
    weights = claim_weights("en")
    assert weights.score(text) == weights.score(text)
    assert features(text, {"it"}) == features(text, {"it"})


def test_a_sentence_is_its_runs_of_words_and_of_letters_its_form_and_its_pairs() -> None:
    found = features("It’s 45 m for Ida.", {"for"})
    by_kind = {kind: {each[1:] for each in found if each[0] == kind} for kind in "wcsp"}
    assert {"it's", "#", "^ it's", "it's # m", ". $"} <= by_kind["w"]
    assert {"^it", "^it'", "ida$", "^.$"} <= by_kind["c"]
    assert {"^ -'s", "# -m for N", "for N . $"} <= by_kind["s"]
    assert by_kind["p"] == {"# for", "# .", "for ."}


@pytest.mark.parametrize("code", CODES)
def test_the_form_of_a_claim_about_unknown_things_is_that_of_a_claim(code: str) -> None:
    claim, other = {
        "en": ("The zwib is ploft again.", "A zwib is a ploft."),
        "de": ("Der Zwib ist wieder ploft.", "Ein Zwib ist ein Ploft."),
    }[code]
    assert claim_weights(code).score(claim) > 0 > claim_weights(code).score(other)
