# SPDX-License-Identifier: Apache-2.0
"""Questions in words of a person's own: what they ask for, and questions of the world, which none answers."""

from __future__ import annotations

import pytest

from rai_missions.conversation import Dialogue, KeyView, Order, Settings, Speech, StatusView, TalkNote, Utterance
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.language.language import language
from tests.conversation.stored import SENTENCES, read

STORED = read("questions.json")
CODES = tuple(STORED)
MEANT = [(code, name, text) for code in CODES for name, texts in STORED[code]["meant"].items() for text in texts]
KEYS = {
    "battery": KeyView("battery", "number", "robot", value=0.5, age_s=0.1),
    "obstacle": KeyView("obstacle", "string", "robot", value="a branch", age_s=0.1),
}  # fmt: skip
VIEW = StatusView(run="r1", mode="running", mission="rows", robot="rob", keys=KEYS)
MOST_ANSWERED = 0.02
"""The share of other talk that may be answered as a question of the run."""


def asked_for(code: str, text: str) -> str:
    """The question that a sentence is by the grammar, or by sense; empty for any other sentence."""
    grammar = Grammar(language(code))
    found = (*grammar.senses(text, VIEW), grammar.question_by_sense(text, VIEW))
    return next((each.name for each in found if each is not None), "")


@pytest.mark.parametrize(("code", "name", "text"), MEANT)
def test_a_question_in_own_words_is_answered_and_orders_nothing(code: str, name: str, text: str) -> None:
    assert asked_for(code, text) == name
    outputs = Dialogue(Settings(language=code), VIEW).on_utterance(Utterance(text, "viewer", "page", at=1.0), VIEW)
    assert not any(
        isinstance(each, Order) or (isinstance(each, TalkNote) and each.kind == "mapped") for each in outputs
    )
    spoken = [each.text for each in outputs if isinstance(each, Speech)]
    assert spoken and language(code).text("unknown") not in spoken[-1]


@pytest.mark.parametrize(("code", "text"), [(code, text) for code in CODES for text in STORED[code]["others"]])
def test_a_question_of_the_world_is_none_of_the_run(code: str, text: str) -> None:
    assert not asked_for(code, text)


@pytest.mark.parametrize("code", CODES)
def test_other_talk_asks_for_nothing_by_sense(code: str) -> None:
    grammar, talk = Grammar(language(code)), SENTENCES["talk"][code]
    found = [each for each in talk if not grammar.senses(each, VIEW) and grammar.question_by_sense(each, VIEW)]
    assert len(found) <= MOST_ANSWERED * len(talk) + 1, found


@pytest.mark.parametrize(("code", "text"), [("en", "where are you?"), ("de", "wo bist du?")])
@pytest.mark.parametrize(("names", "meant"), [
    (("position",), "Position: B4"), (("position_m",), "Position: B4"), (("current_location", "floor"), "B4"),
    (("aisle", "position"), "Position: B4"), (("room_temperature",), ""), (("battery",), ""),
])  # fmt: skip
def test_a_robot_without_a_pose_is_where_a_key_of_that_name_has_it(
    code: str, text: str, names: tuple[str, ...], meant: str
) -> None:
    keys = {name: KeyView(name, "string", "robot", value="B4", age_s=0.1) for name in names}
    outputs = Dialogue(Settings(language=code), VIEW).on_utterance(
        Utterance(text, "viewer", "page", at=1.0), VIEW._replace(keys=keys)
    )
    spoken = [each.text for each in outputs if isinstance(each, Speech)][-1]
    assert meant in spoken if meant else language(code).text("no_position") in spoken
