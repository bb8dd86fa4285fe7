# SPDX-License-Identifier: Apache-2.0
"""A model's message is read strictly: a wish, calls of tools, or why it is neither; never a guess."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import example, given
from hypothesis import strategies as st
from langchain_core.messages import AIMessage

from rai_missions.answerers.model.parse_reply import LONGEST, ParsedReply, callable_name, read, reply_of
from rai_missions.engine.decision import Offer
from rai_missions.testing import QUESTION, answer_fault, call
from tests.answerers.messages import ANY_CALL, OFFERED, TEXTS


def read_text(text: str) -> ParsedReply:
    return read(reply_of(AIMessage(text)), QUESTION)


def wish(option: str, why: str = "", /, **parameters: Any) -> dict[str, Any]:
    return {"option": option, "parameters": parameters, "why": why}


# ── Laws ────────────────────────────────────────────────────────────────────────────────────────────────────────


@given(TEXTS, st.lists(ANY_CALL, max_size=3))
@example("", [call("abort", why="\ud800")])
@example('{"option": "abort", "why": "\\ud800"}', [])
@example('{"option": "abort", "parameters": {"x": 1e999}}', [])
def test_whatever_a_message_holds_one_thing_is_read_from_it(text: str, calls: list[Any]) -> None:
    reading = read(reply_of(AIMessage(text, tool_calls=calls)), QUESTION)
    filled = [part for part in reading if part]
    assert len(filled) == 1, reading
    if reading.choice is not None:
        assert not answer_fault(reading.choice)


@given(TEXTS)
def test_a_wish_is_in_the_text_word_by_word(text: str) -> None:
    reading = read_text(text)
    if reading.choice is not None:
        assert json.dumps(reading.choice["option"]) in text or reading.choice["option"] == text.strip()


@given(st.lists(ANY_CALL, min_size=2, max_size=5))
def test_of_several_calls_with_an_option_none_is_taken(calls: list[Any]) -> None:
    reading = read(reply_of(AIMessage("", tool_calls=calls)), QUESTION)
    if any(each["name"] in OFFERED for each in calls):
        assert reading.failed == f"answered with {len(calls)} calls; one was asked for"


@pytest.mark.parametrize("depth", [29, 31, 300, 3000])
def test_an_answer_that_is_nested_too_deeply_is_none(depth: int) -> None:
    nested: Any = 1
    for _ in range(depth):
        nested = {"x": nested}
    called = read(
        reply_of(AIMessage.model_construct(content="", tool_calls=[{**call("abort"), "args": nested}])), QUESTION
    )
    written = read_text('{"option": "abort", "parameters": ' + '{"x": ' * depth + "1" + "}" * (depth + 1))
    assert bool(called.choice) == bool(written.choice) == (depth < 30)


# ── Examples ────────────────────────────────────────────────────────────────────────────────────────────────────


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("abort", wish("abort")),
        (" replan\n", wish("replan")),
        ('{"option": "abort"}', wish("abort")),
        (
            'Sure! Here it is:\n```json\n{"option": "signal", "why": "a deer", "parameters": {}}\n```',
            wish("signal", "a deer"),
        ),
        ('<think>{"option": "abort"}? no.</think>{"option": "replan"}', wish("replan")),
        ('{"option": "fly", "parameters": null, "why": 3}', wish("fly")),
        ('{"option": "signal", "parameters": {"times": 2}}', wish("signal", times=2)),
        ('{"why": "障害物は枝です", "option": "replan"}', wish("replan", "障害物は枝です")),
    ],
)
def test_one_object_or_one_name_is_a_wish(text: str, expected: dict[str, Any]) -> None:
    assert read_text(text).choice == expected


@pytest.mark.parametrize(
    ("text", "why"),
    [
        ("", "answered nothing"),
        ("<think>hm</think>", "answered nothing"),
        ("I would abort.", "answered without naming an option in JSON: 'I would abort.'"),
        ("Abort", "answered without naming an option in JSON: 'Abort'"),
        ("abort replan", "answered without naming an option in JSON: 'abort replan'"),
        ('["abort"]', "answered without naming an option in JSON: '[\"abort\"]'"),
        ('{"answer": {"option": "abort"}}', "answered without naming an option in JSON"),
        ('{"examples": [{"option": "abort"}], "option": "rep', "answered with JSON that is broken"),
        ('{"option": "abo', 'answered with JSON that is broken: \'{"option": "abo\''),
        ('{"option": "abort", "option": "replan"}', "answered with JSON that is broken"),
        ('{"option": "abort", "parameters": {"x": NaN}}', "answered with JSON that is broken"),
        ('{"option": "abort"} or {"option": "replan"}', "answered with 2 objects; one was asked for"),
        ('{"option": "abort", "state": "done"}', "answered with 'state', which was not asked for"),
        ('{"option": ["abort"]}', "'option' is the name of one option, not ['abort']"),
        ('{"option": "abort", "parameters": [1]}', "'parameters' is an object, not [1]"),
        (json.dumps({"option": "x" * 300}), "'option' is the name of one option, not 300 characters"),
        ("{" * 10_000, "answered with JSON that is broken"),
        ('{"a":' * 3_000, "answered with JSON that is broken"),
        ("x" * (LONGEST + 1), f"answered with {LONGEST + 1} characters; at most {LONGEST} are read"),
    ],
)
def test_anything_looser_is_reported_as_what_it_is(text: str, why: str) -> None:
    reading = read_text(text)
    assert reading.failed.startswith(why)
    assert reading.choice is None


def test_a_call_of_an_option_is_a_wish_with_its_reason_apart() -> None:
    message = AIMessage("", tool_calls=[call("signal", times=2, why="a deer")])
    assert read(reply_of(message), QUESTION).choice == wish("signal", "a deer", times=2)


def test_a_parameter_called_why_stays_a_parameter() -> None:
    asks_why = Offer("report", parameters={"type": "object", "properties": {"why": {"type": "string"}}})
    question = QUESTION._replace(options=(asks_why,))
    message = AIMessage("", tool_calls=[call("report", why="rain")])
    assert read(reply_of(message), question).choice == wish("report", why="rain")


def test_a_call_of_something_else_is_a_call_of_a_tool() -> None:
    assert read(reply_of(AIMessage("", tool_calls=[call("look", at="crate")])), QUESTION).calls == (
        call("look", at="crate"),
    )


def test_a_call_that_is_not_json_is_reported() -> None:
    broken = {"name": "abort", "args": "{", "id": "1", "error": None, "type": "invalid_tool_call"}
    reading = read(reply_of(AIMessage("", invalid_tool_calls=[broken])), QUESTION)
    assert reading.failed == "answered with 1 call whose arguments are not JSON"


@pytest.mark.parametrize("name", ["abort", "look"])
@pytest.mark.parametrize("argument", [float("nan"), object(), "x" * (LONGEST + 1)])
def test_arguments_that_are_not_json_or_too_long_are_refused(name: str, argument: object) -> None:
    message = AIMessage("").model_copy(update={"tool_calls": [{**call(name), "args": {"x": argument}}]})
    assert (
        read(reply_of(message), QUESTION).failed == "answered with a call whose arguments are not JSON, or are too long"
    )


def test_an_option_of_an_included_mission_has_a_name_that_can_be_called() -> None:
    question = QUESTION._replace(options=(Offer("dock/back_off"),))
    assert callable_name("dock/back_off") == "dock__back_off"
    assert read(reply_of(AIMessage("", tool_calls=[call("dock__back_off")])), question).choice == wish("dock/back_off")


def test_a_text_is_cleaned_before_it_is_cut() -> None:
    text = "x" * 100 + " my-secret-value-that-is-long"
    reading = read(reply_of(AIMessage(text)), QUESTION, lambda text: text.replace("my-secret-value-that-is-long", "*"))
    assert "my-secret" not in reading.failed
