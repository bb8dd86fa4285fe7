# SPDX-License-Identifier: Apache-2.0
"""Answers with an option's own words, and with the values that it takes: `ab in die Kammer`, `wait ten minutes`."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import pytest

from rai_missions.conversation import Dialogue, Settings, StatusView, Utterance
from rai_missions.engine.decision import Offer, Question
from tests.conversation.judged import ordered


def number(name: str, least: int, most: int) -> dict[str, Any]:
    return {"type": "object", "properties": {name: {"type": "integer", "minimum": least, "maximum": most}}}


LIFT = (
    Offer("wait", "wartet weiter auf den Aufzug", number("minutes", 1, 20)),
    Offer("basement", "fährt durch den Keller"),
    Offer("call", "ruft auf der Station an", number("ward", 1, 4)),
    Offer("return", "fährt zurück in die Wäschekammer"),
)
RINK = (
    Offer("wait", "wait until the ice is free", number("minutes", 1, 30)),
    Offer("horn", "sound the horn", number("times", 1, 5)),
    Offer("yard", "take the long way through the yard"),
    Offer("cool", "make the ice colder", number("degrees", 1, 9)),
    Offer("hand_over", "hand the key to a person", {"properties": {"person": {"enum": ["Ms Lee", "the coach"]}}}),
)
OFFERS: Mapping[str, tuple[Offer, ...]] = {"de": LIFT, "en": RINK}


def asked(code: str, text: str, *, is_spoken: bool = False) -> list[Mapping[str, Any]]:
    """What a sentence orders while the question is open."""
    question = Question(1, "asking", "operator", "What now?", OFFERS[code])
    view = StatusView(run="r1", mode="running", mission="round", robot="rob", questions=(question,))
    readings = (text, text) if is_spoken else ()
    utterance = Utterance(text, "operator", "voice" if is_spoken else "terminal", at=1.0, readings=readings)
    return ordered(Dialogue(Settings(language=code), view).on_utterance(utterance, view))


@pytest.mark.parametrize(("code", "text", "option", "values"), [
    ("de", "ab in die Wäschekammer", "return", {}), ("de", "zurück in die Kammer für die Wäsche", "return", {}),
    ("de", "fahr über den Keller", "basement", {}),
    ("de", "Keller, weil der Aufzug heute nicht mehr kommt", "basement", {}),
    ("de", "warte noch drei Minuten", "wait", {"minutes": 3}), ("de", "ruf die Station vier an", "call", {"ward": 4}),
    ("en", "wait ten minutes and then try again", "wait", {"minutes": 10}), ("en", "honk twice", "horn", {"times": 2}),
    ("en", "honk three times, people never notice", "horn", {"times": 3}), ("en", "wait a bit", "wait", {}),
    ("en", "through the yard, it is empty", "yard", {}), ("en", "we'd better wait till she is off", "wait", {}),
    ("en", "you could go by the yard", "yard", {}), ("en", "4 degrees colder", "cool", {"degrees": 4}),
    ("en", "hand the key to Ms Lee", "hand_over", {"person": "Ms Lee"}),
    ("en", "wait a minute or two", "wait", {"minutes": 1}),
])  # fmt: skip
def test_an_answer_has_the_option_and_its_values_and_is_read_back(
    code: str, text: str, option: str, values: Mapping[str, Any]
) -> None:
    (found,) = asked(code, text)
    assert (found.get("option"), found.get("parameters", {})) == (option, values)
    assert "is_given" not in found, "it was given out at once"


@pytest.mark.parametrize(("code", "text"), [
    ("de", "Der Keller ist frisch gestrichen."), ("de", "Wir waren im Keller."), ("de", "nicht durch den Keller"),
    ("de", "alles außer dem Keller"), ("de", "was würde der Keller denn dauern?"), ("en", "The yard is wet."),
    ("en", "anything but the yard"), ("en", "if the yard is free"), ("en", "she crossed the yard yesterday"),
    ("en", "the yard or whatever"), ("en", "wait or do something else"), ("en", "wait ninety minutes"),
])  # fmt: skip
def test_what_asks_for_no_option_is_no_answer(code: str, text: str) -> None:
    assert not [each for each in asked(code, text) if each["order"] == "answer"]


@pytest.mark.parametrize(("code", "text"), [("de", "ab in die Kammer"), ("en", "off to the yard")])
def test_a_direction_without_a_verb_answers_an_open_question(code: str, text: str) -> None:
    assert [each["order"] for each in asked(code, text)] == ["answer"]


def test_two_options_are_asked_about() -> None:
    assert not asked("en", "the yard or the horn") and not asked("de", "durch den Keller oder zurück in die Kammer")


def test_a_pause_counts_at_once_where_no_option_is_meant() -> None:
    assert [each["order"] for each in asked("en", "hang on")] == ["pause"]
    assert asked("en", "stop")[0]["order"] == "stop"
