# SPDX-License-Identifier: Apache-2.0
"""What costs the most of a sentence is looked up once: a language's phrases and words, and the secrets of a process."""

from __future__ import annotations

from cProfile import Profile

from rai_missions import redaction
from rai_missions.conversation.claims.claims import Claims
from rai_missions.conversation.language.language import language
from tests.conversation.stored import PATROLLING

LONG = "The cup is on the table (a red one), and I have arrived at the dock; it was easy - you saw it, did you?"


def test_the_phrases_of_a_profile_are_compiled_once_for_all_its_dialogues() -> None:
    words = language("en")
    one, again = (words.order_phrases(["go to {place}"], {"place": "(?:kitchen|hall) "}) for _ in range(2))
    assert one is again
    assert words.order_phrases(["go to {place}"]) is not one, "any place is none of a list"


def test_the_words_of_a_language_are_joined_once() -> None:
    assert language("de").vocabulary is language("de").vocabulary


def test_a_sentence_of_a_model_is_looked_through_for_secrets_once_and_not_each_of_its_clauses() -> None:
    calls = Profile()
    calls.runcall(Claims("en").why_replaced, LONG, PATROLLING)
    looked = [each.callcount for each in calls.getstats() if each.code is redaction.cut.__code__]
    assert looked == [1]


def test_a_variable_that_stays_as_it_is_is_read_for_secrets_once() -> None:
    redaction.cut("hello", 10)
    calls = Profile()
    calls.runcall(redaction.cut, "hello", 10)
    assert not any(each.code is redaction.is_secret_name.__code__ for each in calls.getstats())
