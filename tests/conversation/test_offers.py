# SPDX-License-Identifier: Apache-2.0
"""Sentences that no rule reads: what is offered for them, that it counts by a yes alone, and what gets no offer."""

from __future__ import annotations

from cProfile import Profile

import pytest

from rai_missions.conversation import Dialogue, KeyView, MissionView, Order, Output, StatusView, Utterance
from rai_missions.conversation.outputs import TalkNote
from rai_missions.engine.decision import Offer, Question
from rai_missions.event import Role
from tests.conversation.stored import SENTENCES, offered, settings_in

ARGUMENTS = tuple(KeyView(name, "string", "argument") for name in ("task", "object", "place"))
WAIT = KeyView("wait_s", "integer", "argument", minimum=1, maximum=600)
THINGS = {"en": "cup, book, ball", "de": "Tasse, Buch, Ball"}
PLACES = {"en": {"kitchen": "kitchen", "study": "study"}, "de": {"Küche": "kitchen", "Büro": "study"}}
PHRASES = {
    "en": {
        "find {object}": {"task": "find"},
        "find {object} in {place}": {"task": "find"},
        "go to {place}": {"task": "go"},
        "(check|look around in) {place}": {"task": "look"},
        "wait {wait_s}": {"task": "wait"},
        "come back": {"task": "back"},
    },
    "de": {
        "such {object}": {"task": "find"},
        "such {object} in {place}": {"task": "find"},
        "fahr in {place}": {"task": "go"},
        "sieh dich um in {place}": {"task": "look"},
        "warte {wait_s}": {"task": "wait"},
        "komm zurück": {"task": "back"},
    },
}
OPTIONS = {"reverse": "drive backwards to the gate", "lift": "raise the mower and cross the ditch"}
UNREAD = {
    "en": {
        "how about a trip to the kitchen": {"task": "go", "place": "kitchen"},
        "sleuth for my cup": {"task": "find", "object": "cup"},
        "sleuth for my book in the study": {"task": "find", "object": "book", "place": "study"},
        "grant me 20 seconds of peace": {"task": "wait", "wait_s": 20},
        "I need my keys": {"task": "find", "object": "keys"},
        "I've lost the bloody remote": {"task": "find", "object": "bloody remote"},
        "My husband has hidden the remote again, go sniff it out would you": {"task": "find", "object": "remote"},
        "my glasses are gone": {"task": "find", "object": "glasses"},
        "I can't find my remote anywhere...": {"task": "find", "object": "remote"},
    },
    "de": {
        "auf in Richtung Küche": {"task": "go", "place": "kitchen"},
        "spür mir mal die Tasse auf": {"task": "find", "object": "tasse"},
        "gönn mir 20 Sekunden Ruhe": {"task": "wait", "wait_s": 20},
        "ich brauche meine Schlüssel": {"task": "find", "object": "schlüssel"},
        "mein Ladekabel ist weg": {"task": "find", "object": "ladekabel"},
        "ich finde meine Brille nicht mehr": {"task": "find", "object": "brille"},
    },
}
"""Sentences that no rule reads → the arguments of what is offered first."""
READ = {
    "en": {
        "where is my lamp?": {"task": "find", "object": "lamp"},
        "where did I leave my keys?": {"task": "find", "object": "keys"},
    },
    "de": {
        "wo ist meine Brille?": {"task": "find", "object": "brille"},
    },
}
"""Questions that are read, for what no fact names → what is offered behind the reply."""
YES = {"en": "yes", "de": "ja"}
NOTHING = {
    "en": (
        "the kitchen smells amazing today",
        "my cup broke yesterday",
        "she left the study hours ago",
        "never mind the kitchen again",
        "if it rains the kitchen floods",
        'the sign in front reads "kitchen"',
        "how lovely",
        "I need a break",
        "we want to know the time",
        "make your way to the garden",
        "I'm going to the study now, see you tonight",
        "Had I known about the sale I would have gone to the kitchen",
        "> how about a trip to the kitchen",
        "fine by me\n> how about a trip to the kitchen",
        "go to the attic",
        "wait 9000 seconds",
        "where is Paris?",
        "where is your battery?",
        "how warm is it?",
        "I need your help",
        "do you ever go to the kitchen?",
        "will you find the way to the kitchen tomorrow?",
    ),
    "de": (
        "die Küche duftet heute herrlich",
        "gestern lag der Ball noch in der Küche",
        "meine Tasse zerbrach gestern",
        "bloß nicht die Küche",
        "wenn es regnet Küche unter Wasser",
        "wie schön",
        "ich will die Wahrheit nicht",
        "> auf in Richtung Küche",
        "fahr in den Keller",
        "wo liegt Paris?",
        "wo ist deine Batterie?",
        "suchst du morgen etwas in der Küche?",
        "Nächste Woche putzt du die Küche.",
    ),
}
MOST_OFFERED = 0.05
"""The share of stored talk, which has the words of orders in it, for which an order may be offered."""
CODES = tuple(UNREAD)


def run(code: str, mode: str = "succeeded", *questions: Question) -> StatusView:
    keys = {"known": KeyView("known", "string", value=THINGS[code])}
    missions = (MissionView("assist", "", (*ARGUMENTS, WAIT)),)
    return StatusView(
        run="r1", mode=mode, mission="assist", robot="rob", missions=missions, keys=keys, questions=questions
    )


def replies(code: str, view: StatusView, *sentences: str, role: Role = "operator") -> tuple[Output, ...]:
    """What goes out at the last of some typed sentences."""
    dialogue, found = Dialogue(settings_in(code, PHRASES[code], PLACES[code]), view), tuple[Output, ...]()
    for at, text in enumerate(sentences, start=1):
        found = dialogue.on_utterance(Utterance(text, role, "terminal", at=float(at)), view)
    return found


def given(outputs: tuple[Output, ...]) -> list[Order]:
    return [each for each in outputs if isinstance(each, Order)]


MEANT = {code: UNREAD[code] | READ[code] for code in CODES}


@pytest.mark.parametrize(("code", "text"), [(code, text) for code in CODES for text in MEANT[code]])
def test_what_a_sentence_may_mean_is_offered_and_counts_by_a_yes_alone(code: str, text: str) -> None:
    view, arguments = run(code), MEANT[code][text]
    outputs = replies(code, view, text)
    assert [{**each["arguments"]} for each in offered(outputs)] == [arguments] and not given(outputs)
    (order,) = given(replies(code, view, text, YES[code]))
    assert (order.name, order.arguments, order.mapper, order.sentence) == ("start", arguments, "nearest", text)
    assert not given(replies(code, view, text, *NOTHING[code][:1], YES[code])), "another sentence was between"


@pytest.mark.parametrize("code", CODES)
def test_nothing_is_offered_to_who_may_not_order_it_aloud_or_next_to_a_read_back(code: str) -> None:
    view = run(code)
    for text in MEANT[code]:
        assert not offered(replies(code, view, text, role="person"))
        dialogue = Dialogue(settings_in(code, PHRASES[code], PLACES[code]), view)
        assert not offered(dialogue.on_utterance(Utterance(text, "operator", "voice", readings=(text, text)), view))
        first = {"en": "go to the study", "de": "fahr ins Büro"}[code]
        assert not offered(replies(code, view, first, text))


@pytest.mark.parametrize("why", ["no request waits", "no more requests wait", "the program ends", "one begins"])
def test_no_start_is_offered_that_would_be_refused(why: str) -> None:
    settings, view = settings_in("en", PHRASES["en"], PLACES["en"]), run("en", "running")
    if why == "no request waits":
        settings = settings._replace(requests="refuse")
    elif why == "no more requests wait":
        settings = settings._replace(most_requests=0)
    elif why == "one begins":
        settings, view = settings._replace(requests="refuse"), run("en")
    dialogue = Dialogue(settings, view)
    if why == "the program ends":
        dialogue.on_last_run(0.5)
    elif why == "one begins":
        for at, text in ((0.1, "go to the study"), (0.5, "yes")):
            dialogue.on_utterance(Utterance(text, "operator", "terminal", at=at), view)
    outputs = dialogue.on_utterance(Utterance("how about a trip to the kitchen", "operator", "terminal", at=1.0), view)
    assert not [each for each in outputs if "kitchen" in getattr(each, "text", "")]
    assert {each.kind for each in outputs if isinstance(each, TalkNote)}.isdisjoint(("mapped", "refused"))


@pytest.mark.parametrize(("code", "text"), [(code, text) for code in CODES for text in NOTHING[code]])
def test_a_statement_a_negation_a_condition_and_a_quotation_get_no_offer(code: str, text: str) -> None:
    assert not offered(replies(code, run(code), text))


@pytest.mark.parametrize("code", CODES)
def test_talk_with_the_words_of_orders_gets_few_offers_and_orders_nothing(code: str) -> None:
    talk = SENTENCES["talk"][code]
    found = {text: replies(code, run(code, "running"), text) for text in talk}
    assert not [text for text, outputs in found.items() for each in given(outputs) if each.mapper == "nearest"]
    many = [text for text, outputs in found.items() if offered(outputs)]
    assert len(many) <= MOST_OFFERED * len(talk), many


def test_an_answer_in_words_of_its_about_counts_by_a_yes() -> None:
    question = Question(1, "deciding", "operator", "What now?", tuple(map(Offer, OPTIONS, OPTIONS.values())))
    view = run("en", "running", question)
    for text, option in (("raise that mower and over the ditch", "lift"),):
        assert not given(replies("en", view, text))
        assert [each.option for each in given(replies("en", view, text, "yes"))] == [option]


def test_what_else_is_near_is_named_with_the_offer() -> None:
    outputs = replies("en", run("en"), "how about a trip to the kitchen")
    assert any("look" in text and "Or else" in text for text in (getattr(each, "text", "") for each in outputs))


LONG_TEXTS = (
    "me " * 650, "kitchen there " * 130, "kitchen me " * 28, ("kitchen me " * 19 + ", ") * 7, ", " * 1_000,
    ("you go there " * 13 + ", ") * 8, ("could you find me there " * 8 + ", ") * 8, "where is the cup, " * 111,
    ("go there and " * 13 + ". ") * 7, "'a " * 666, "xqy " * 500,
)  # fmt: skip
MOST_CALLS = 600_000
"""Calls of functions that the longest text may cost: some 200 ms of CPU."""


@pytest.mark.parametrize("text", LONG_TEXTS)
def test_no_text_keeps_the_conversation_long(text: str) -> None:
    dialogue, calls = Dialogue(settings_in("en", PHRASES["en"], PLACES["en"]), run("en")), Profile()
    calls.runcall(dialogue.on_utterance, Utterance(text, "person", "terminal", at=1.0), run("en"))
    assert sum(each.callcount for each in calls.getstats()) < MOST_CALLS
