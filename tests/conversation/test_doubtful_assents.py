# SPDX-License-Identifier: Apache-2.0
"""A yes with a doubt in it, in any of its forms, confirms nothing; one without does. Nor do the words of others."""

from __future__ import annotations

from itertools import product

import pytest

from rai_missions.conversation import Dialogue, Order, TalkNote, Utterance
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.language.language import language
from rai_missions.engine.decision import Offer, Question
from tests.conversation.stored import ASSISTING, settings_in

GO = {"en": "go to the kitchen", "de": "geh in die Küche"}
PHRASES = {"en": "go to [the] {place}", "de": "geh (in|zu) die {place}"}
ASSENTS = {
    "en": ("yes", "okay", "sure", "yes please", "do it", "that is right", "perfect"),
    "de": ("ja", "okay", "klar", "ja gern", "mach das", "das stimmt"),
}
DOUBTS = {
    "en": (
        "maybe", "perhaps", "I guess", "I suppose", "I think", "probably", "mabye", "later",
        "or not", "not now", "if it is dry", "when I am gone", "hardly", "whatever", "not", "as if", "ask my wife",
    ),
    "de": (
        "vielleicht", "glaube ich", "denke ich", "vermutlich", "vielleicht nicht", "später", "oder nicht",
        "noch nicht", "wenn es trocken ist", "kaum", "nicht", "von wegen", "na und", "sagt meine Frau",
    ),
}  # fmt: skip
REFUSALS = {"en": ("never mind", "forget it"), "de": ("vergiss es", "lass das")}
ALONE = {
    "en": ("maybe", "I suppose so", "I guess", "could be", "I think so", "probably not", "well, perhaps"),
    "de": ("vielleicht", "ich glaube schon", "könnte sein", "denke ich", "wahrscheinlich", "na vielleicht"),
}
SURE = {
    "en": ("yes", "yes, now", "yes please", "right, go ahead", "sure mate"),
    "de": ("ja", "ja, jetzt", "ja bitte", "na klar", "ja, mach das", "passt so"),
}


def came_of(text: str, code: str) -> tuple[bool, bool]:
    """Whether a sentence confirms what was read back, and whether it has it read back again."""
    settings = settings_in(code, {PHRASES[code]: {"task": "go"}}, {"kitchen": "kitchen", "küche": "kitchen"})
    view = ASSISTING._replace(mode="ready", awaits_start=True)
    talk = Dialogue(settings, view)
    talk.on_utterance(Utterance(GO[code], "operator", "terminal", "Eve", 1.0), view)
    found = talk.on_utterance(Utterance(text, "operator", "terminal", "Eve", 4.0), view)
    notes = (each.kind for each in found if isinstance(each, TalkNote))
    return any(isinstance(each, Order) for each in found), "read_back" in notes


@pytest.mark.parametrize("code", GO)
def test_a_yes_with_a_doubt_is_none_that_confirms(code: str) -> None:
    grammar, ways = Grammar(language(code)), ("{0} {1}", "{0}, {1}", "{1} {0}", "{1}, {0}", "{0} - {1}.")
    every = [way.format(*each) for each in product(ASSENTS[code], DOUBTS[code] + REFUSALS[code]) for way in ways]
    sure = Sense("yes")
    assert [each for each in every if sure in grammar.senses(each, ASSISTING)] == []


@pytest.mark.parametrize(("code", "option"), [("en", "the first one"), ("de", "die erste")])
def test_an_answer_with_a_doubt_is_read_back(code: str, option: str) -> None:
    offers = (Offer("wait", "wait for the lift"), Offer("leave", "leave it"))
    view = ASSISTING._replace(questions=(Question(1, "asking", "operator", "What now?", offers),))
    grammar = Grammar(language(code))
    assert [each.is_partial for each in grammar.senses(option, view)] == [False]
    every = [way.format(option, doubt) for doubt in DOUBTS[code] for way in ("{0}, {1}", "{1}, {0}")]
    certain = [each for each in every for sense in grammar.senses(each, view) if sense.option and not sense.is_partial]
    assert certain == []


@pytest.mark.parametrize("code", GO)
def test_a_doubtful_answer_has_the_order_read_back_again(code: str) -> None:
    assert [each for each in ALONE[code] if came_of(each, code) != (False, True)] == []


@pytest.mark.parametrize("code", GO)
def test_a_certain_yes_confirms(code: str) -> None:
    assert [each for each in SURE[code] if not came_of(each, code)[0]] == []


@pytest.mark.parametrize(("code", "order"), [("en", "keep going"), ("de", "weiter")])
def test_a_resume_in_the_words_of_another_person_resumes_nothing(code: str, order: str) -> None:
    grammar, view = Grammar(language(code)), ASSISTING._replace(mode="paused")
    others = {"en": "he wrote", "de": "sagte Mila"}[code]
    assert Sense("order", "resume") in grammar.senses(order, view)
    assert Sense("order", "resume") not in grammar.senses(f"{order}, {others}", view)
