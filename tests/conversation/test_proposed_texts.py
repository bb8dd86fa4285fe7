# SPDX-License-Identifier: Apache-2.0
"""A text that a model puts into an order is shown as it is read back, so it is judged as any other text of a model."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

import pytest

from rai_missions.conversation import (
    AskModel,
    Dialogue,
    KeyView,
    MissionView,
    ModelText,
    Output,
    Settings,
    Speech,
    Utterance,
)
from rai_missions.engine.decision import Offer, Question
from tests.conversation.stored import CLAIMS, PATROLLING
from tests.conversation.test_hostile_models import MODELS, QUESTION, letters

TEXT = {"type": "string"}
NOTE = {"type": "object", "properties": {"text": TEXT, "mood": {"enum": ["done", "open"]}, "tags": {"type": "array"}}}
ARGUMENTS = (
    KeyView("words", "string", "argument"),
    KeyView("thing", "string", "argument"),
    KeyView("state", "string", "argument", enum=("done", "open")),
    KeyView("list", "list", "argument"),
    KeyView("more", "object", "argument"),
)
VIEW = PATROLLING._replace(
    missions=(MissionView("announce", "", ARGUMENTS),),
    questions=(Question(1, "asking", "operator", "And now?", (Offer("note", parameters=NOTE), Offer("wait"))),),
)
ORDERS = (
    lambda text: start(words=text),
    lambda text: start(thing="cup", words=text),
    lambda text: start(words=" ".join(text.split()[:2]), thing=" ".join(text.split()[2:])),
    lambda text: start(list=[text]),
    lambda text: start(more={"a": {"b": [text]}}),
    lambda text: start(more={text: 1}),
    lambda text: {"order": "answer", "question": 1, "option": "note", "parameters": {"text": text}},
    lambda text: {"order": "answer", "question": 1, "option": "note", "parameters": {"tags": [text]}},
)
"""Orders that a text can be put into."""


def start(**arguments: Any) -> Mapping[str, Any]:
    """An order to start with these arguments."""
    return {"order": "start", "mission": "announce", "arguments": arguments}


def replies(order: Mapping[str, Any], code: str, asked: str = "") -> tuple[Output, ...]:
    """What goes out once a model has proposed an order for a sentence."""
    dialogue = Dialogue(Settings(has_model=True, language=code), VIEW)
    outputs = dialogue.on_utterance(Utterance(asked or QUESTION[code], "operator", "terminal", at=1.0), VIEW)
    (request,) = [each for each in outputs if isinstance(each, AskModel)]
    return dialogue.on_model(ModelText(request.number, order=order, is_end=True, at=2.0))


def shown(outputs: tuple[Output, ...]) -> str:
    """All that is shown."""
    return letters("".join(each.text for each in outputs if isinstance(each, Speech)))


def drawn(code: str, every: int) -> Iterator[tuple[str, Mapping[str, Any]]]:
    """Claims, each as a hostile model writes it into an order."""
    for at, claim in enumerate(CLAIMS["claims"][code][::every]):
        dress = [*MODELS.values()][at % len(MODELS)]
        yield claim, ORDERS[at % len(ORDERS)]("".join(dress(claim)))


@pytest.mark.parametrize("code", sorted(QUESTION))
def test_no_claim_is_read_back_in_an_order(code: str) -> None:
    every = [*drawn(code, 13)]
    assert [order for claim, order in every if letters(claim) in shown(replies(order, code))] == []


@pytest.mark.parametrize("code", sorted(QUESTION))
def test_in_the_place_of_an_order_with_a_claim_is_the_status(code: str) -> None:
    status = {"en": "patrol", "de": "patrol"}
    (text,) = [
        each.text for each in replies(start(words="I have arrived at the dock."), code) if isinstance(each, Speech)
    ]
    assert status[code] in text


@pytest.mark.parametrize(
    ("code", "order"),
    [
        ("en", start(thing="cup")),
        ("en", start(thing="the red cup")),
        ("en", start(words="Anna", thing="milk and sugar")),
        ("en", start(state="done")),
        ("en", start(list=["kitchen", "hall"])),
        ("en", {"order": "answer", "question": 1, "option": "note", "parameters": {"mood": "done"}}),
        ("de", start(thing="Tasse")),
        ("de", start(thing="die rote Tasse")),
        ("de", start(list=["Küche", "Flur"])),
    ],
)
def test_a_name_and_a_listed_value_are_read_back(code: str, order: Mapping[str, Any]) -> None:
    texts = [each.text for each in replies(order, code) if isinstance(each, Speech)]
    assert any("?" in each for each in texts), texts


@pytest.mark.parametrize(
    ("code", "asked", "text"),
    [
        ("en", "please let all of them know that I have watered the plants", "I have watered the plants."),
        ("de", "lass alle wissen: ich habe die Blumen gegossen", "Ich habe die Blumen gegossen"),
    ],
)
def test_the_words_of_the_person_are_read_back(code: str, asked: str, text: str) -> None:
    assert letters(text) in shown(replies(start(words=text), code, asked))
