# SPDX-License-Identifier: Apache-2.0
"""Words that are repeated for emphasis count once: `go go go` is `go`, in each language and for each of its phrases."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import product

import pytest

from rai_missions.conversation import StatusView
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.language.language import language, languages
from rai_missions.conversation.language.phrases import example_of
from tests.conversation.stored import ASSISTING
from tests.conversation.test_forms_of_orders import PHRASES, PLACES
from tests.conversation.test_order_lists import ORDERS

LONGEST = 4
"""Words of the longest sentence that is repeated here."""
SIGNS = (" ", ", ", "! ", "... ")
VIEWS = {"running": ASSISTING, "paused": ASSISTING._replace(mode="paused"), "": ASSISTING._replace(mode="", mission="")}


def plain_sentences(code: str) -> Iterator[str]:
    """The plainest sentence of each phrase of a language that needs no value, and orders of a robot's own."""
    data = language(code).data
    lists = [data[name] for name in ("yes", "no", "quiet", "withdraw", "again", "start")]
    lists += [phrases for group in ("orders", "questions") for phrases in data[group].values()]
    found = (example_of(phrase) for phrases in lists for phrase in phrases)
    yield from (each for each in found if each and "…" not in each and len(each.split()) <= LONGEST)
    yield from ORDERS[code].values()


def meant(grammar: Grammar, text: str, view: StatusView) -> list[str]:
    """What a sentence means."""
    return [sense.identity for sense in grammar.senses(text, view)]


@pytest.mark.parametrize("mode", VIEWS)
@pytest.mark.parametrize("code", languages())
def test_a_sentence_that_is_repeated_for_emphasis_means_what_it_means_once(code: str, mode: str) -> None:
    words = language(code)
    grammar = Grammar(words, StartPhrases(PHRASES[code], PLACES[code], words))
    wrong = dict[str, list[str]]()
    for sentence, sign, count in product(plain_sentences(code), SIGNS, (2, 3, 5)):
        once, text = meant(grammar, sentence, VIEWS[mode]), sign.join([sentence] * count)
        if once and (found := meant(grammar, text, VIEWS[mode])) != once:
            wrong[text] = found
    assert wrong == {}


@pytest.mark.parametrize(("code", "text"), [("en", "go go go"), ("en", "Go! Go! Go!"), ("de", "los los los")])
def test_a_cry_to_go_resumes_a_run_that_has_begun_and_starts_none(code: str, text: str) -> None:
    words = language(code)
    found = {mode: Grammar(words).senses(text, view) for mode, view in VIEWS.items()}
    assert {mode: [sense.name for sense in senses] for mode, senses in found.items()} == {
        "running": ["resume"],
        "paused": ["resume"],
        "": ["start"],
    }
