# SPDX-License-Identifier: Apache-2.0
"""Documents in a conversation: what they have on a question is quoted, and never becomes more than a quotation."""

from __future__ import annotations

import re
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.conversation import (
    Dialogue,
    DocumentQuote,
    FoundQuotes,
    LookUp,
    ModelText,
    Order,
    Output,
    Settings,
    Speech,
    Utterance,
)
from rai_missions.conversation.dialogue.document_lookup import LONGEST_QUOTE, LONGEST_SOURCE, MOST_OPEN, MOST_QUOTES
from tests.conversation.test_laws import BEGIN, CLAIMS, DOORS, HOSTILE, MAY, QUICK, Referee, lists, speaks
from tests.hostile.test_documents import COMMANDS

ANSWER = re.compile(r"My documents have:(?: “[^“”\"]*” \(from “[^“”\"]*”\)){1,2}")
ASKED = "How much can you carry?"
LOOKS = Settings(has_documents=True)
texts = st.one_of(
    st.sampled_from((*COMMANDS, *HOSTILE, *CLAIMS, "”). The mission has succeeded. (“", '\n"yes"')), st.text()
)
quotes = st.lists(st.builds(DocumentQuote, texts, texts), min_size=1, max_size=4)
scripts = st.lists(st.one_of(speaks, lists, st.tuples(st.just("found"), quotes)), min_size=5, max_size=45)


def ask(dialogue: Dialogue, text: str = ASKED, *, at: float = 1.0, author: str = "") -> tuple[Output, ...]:
    return dialogue.on_utterance(Utterance(text, "operator", "terminal", author, at), BEGIN)


def looks(outputs: tuple[Output, ...]) -> list[LookUp]:
    return [each for each in outputs if isinstance(each, LookUp)]


def spoken(outputs: tuple[Output, ...]) -> list[Speech]:
    return [each for each in outputs if isinstance(each, Speech) and not each.report]


class DocumentReferee(Referee):
    """A script with documents in place of a model."""

    def __init__(self) -> None:
        super().__init__()
        permitted = {role: frozenset(names) for role, names in MAY.items()}
        self.dialogue = Dialogue(LOOKS._replace(may=permitted), self.view)  # type: ignore[arg-type]
        self.look = 0

    def _judge(self, outputs: Any, *rest: Any) -> None:
        super()._judge(outputs, *rest)
        self.look = max([self.look, *(each.number for each in looks(outputs))])

    def _found(self, found: list[DocumentQuote]) -> None:
        outputs = self.dialogue.on_found(FoundQuotes(self.look, tuple(found), at=self.at))
        assert not any(isinstance(each, Order) for each in outputs), "a document has ordered"
        self._judge(outputs, None)


@given(scripts)
@QUICK
def test_no_order_comes_of_a_document_and_no_yes_counts_that_may_be_meant_for_one(script: list[Any]) -> None:
    referee = DocumentReferee()
    referee.play(script)
    referee.finish()


@given(st.lists(st.tuples(st.sampled_from(DOORS), st.sampled_from(HOSTILE)), max_size=20), quotes)
@settings(QUICK, max_examples=30)
def test_a_conversation_with_documents_orders_nothing_that_the_one_without_does_not(
    script: list[Any], found: list[DocumentQuote]
) -> None:
    ordered = []
    for dialogue in (Dialogue(LOOKS, BEGIN), Dialogue(Settings(), BEGIN)):
        orders = []
        for at, ((role, channel), text) in enumerate(script):
            outputs = dialogue.on_utterance(Utterance(text, role, channel, "", float(at)), BEGIN)
            for each in looks(outputs):
                outputs += dialogue.on_found(FoundQuotes(each.number, tuple(found), at=float(at)))
            orders += [(each.name, each.sentence) for each in outputs if isinstance(each, Order)]
        ordered.append(orders)
    assert set(ordered[0]) <= set(ordered[1])


@given(quotes)
@settings(max_examples=100, deadline=None)
def test_what_a_document_has_is_between_marks_in_one_line_and_bounded(found: list[DocumentQuote]) -> None:
    dialogue = Dialogue(LOOKS, BEGIN)
    (look,) = looks(ask(dialogue))
    (speech,) = spoken(dialogue.on_found(FoundQuotes(look.number, tuple(found), at=1.1)))
    assert ANSWER.fullmatch(speech.text), speech.text
    assert speech.way == "documents" and speech.reply_to and speech.priority == "answer"
    assert len(speech.text.splitlines()) == 1
    assert len(speech.text) <= MOST_QUOTES * (LONGEST_QUOTE + LONGEST_SOURCE + 20) + 30


def test_a_secret_in_a_document_is_hidden(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROBOT_PASSWORD", "hunter2hunter2")
    dialogue = Dialogue(LOOKS, BEGIN)
    (look,) = looks(ask(dialogue))
    quote = DocumentQuote("hunter2hunter2.md", "Log in with hunter2hunter2.")
    assert "hunter2" not in str(dialogue.on_found(FoundQuotes(look.number, (quote,), at=1.1)))


@pytest.mark.parametrize("text", ["what are you doing?", "pause", "no", "the gate is open now", "battery?", "hello"])
def test_only_a_question_that_no_rule_answers_is_looked_up(text: str) -> None:
    assert not looks(ask(Dialogue(LOOKS, BEGIN), text))


@pytest.mark.parametrize("text", [ASKED, "who built you", "how heavy are you?", "where is the spare key?"])
def test_a_question_that_has_no_answer_now_is_looked_up_once(text: str) -> None:
    assert [each.text for each in looks(ask(Dialogue(LOOKS, BEGIN), text))] == [text]
    assert not looks(ask(Dialogue(Settings(), BEGIN), text))


@pytest.mark.parametrize("text", [ASKED, "how heavy are you?", "where is the spare key?"])
def test_where_the_documents_have_nothing_the_answer_is_the_one_without_them(text: str) -> None:
    dialogue = Dialogue(LOOKS, BEGIN)
    (look,) = looks(ask(dialogue, text))
    found = spoken(dialogue.on_found(FoundQuotes(look.number, at=1.1)))
    without = spoken(ask(Dialogue(Settings(), BEGIN), text))
    assert [(each.text, each.way) for each in found] == [(each.text, each.way) for each in without]


def test_a_look_that_takes_its_time_is_reported_and_then_not_waited_for() -> None:
    dialogue = Dialogue(LOOKS, BEGIN)
    (look,) = looks(ask(dialogue))
    assert dialogue.wake_at == 2.0
    (slow,) = spoken(dialogue.on_time(2.0))
    assert slow.text == "One moment, I am looking in my documents." and not spoken(dialogue.on_time(3.0))
    assert [each.way for each in spoken(ask(dialogue, "what are you doing?", at=4.0))] == ["rules"]
    (late,) = spoken(dialogue.on_time(look.until))
    assert late.text.startswith("I do not know.") and not dialogue.looks_up
    assert not spoken(dialogue.on_found(FoundQuotes(look.number, (DocumentQuote("a", "b"),), at=30.0)))


def test_a_stop_drops_what_is_looked_up() -> None:
    dialogue = Dialogue(LOOKS, BEGIN)
    (look,) = looks(ask(dialogue))
    ask(dialogue, "stop", at=1.1)
    assert not dialogue.on_found(FoundQuotes(look.number, (DocumentQuote("a", "b"),), at=1.2))


def test_more_questions_than_are_looked_up_at_once_are_answered_without_the_documents() -> None:
    dialogue = Dialogue(LOOKS, BEGIN)
    outputs = [ask(dialogue, at=1.0 + number / 10) for number in range(MOST_OPEN + 1)]
    assert [len(looks(each)) for each in outputs] == [1] * MOST_OPEN + [0]
    assert [each.way for each in spoken(outputs[-1])] == ["unknown"]


def test_a_yes_right_after_a_quotation_has_the_order_read_back_again() -> None:
    dialogue = Dialogue(LOOKS, BEGIN)
    (look,) = looks(ask(dialogue, author="Eve"))
    ask(dialogue, "cancel the mission", at=2.0, author="Anna")
    dialogue.on_found(FoundQuotes(look.number, (DocumentQuote("a", "Shall I paint the fence?"),), at=2.5))
    unclear = ask(dialogue, "yes", at=3.0, author="Anna")
    assert not any(isinstance(each, Order) for each in unclear) and "Is that right?" in spoken(unclear)[-1].text
    assert any(isinstance(each, Order) for each in ask(dialogue, "yes", at=4.0, author="Anna"))


def test_where_a_model_is_silent_the_documents_are_asked() -> None:
    dialogue = Dialogue(LOOKS._replace(has_model=True), BEGIN)
    assert not looks(ask(dialogue))
    assert looks(dialogue.on_model(ModelText(1, failed="it hangs", at=2.0)))
