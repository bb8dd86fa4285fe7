# SPDX-License-Identifier: Apache-2.0
"""Whatever a model's process sends is read as a reply, or refused with a reason; nothing else comes of it."""

from __future__ import annotations

import json
import struct
from typing import Any

import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st
from langchain_core.messages import AIMessage, HumanMessage, SystemMessage, ToolMessage

from rai_missions.answerers.model.chat import Abilities, BudgetExceeded, ModelFault
from rai_missions.answerers.model.parse_reply import LONGEST, ModelReply, read, reply_of
from rai_missions.answerers.model.process.words import (
    LONGEST_NAME,
    abilities_in,
    ability_words,
    messages_in,
    packed,
    reply_in,
    reply_words,
)
from rai_missions.connectors.process.frames import LONGEST_REPLY, Broken, Inlet, outward
from rai_missions.testing import QUESTION
from tests.answerers.messages import ANY_CALL, TEXTS
from tests.providers.langchain_hostile import FORGED, GOOD

PLAIN = st.recursive(
    st.none() | st.booleans() | st.integers() | st.floats() | st.text(max_size=9),
    lambda inner: st.lists(inner, max_size=3) | st.dictionaries(st.text(max_size=5), inner, max_size=3),
    max_leaves=9,
)
WORDS = st.sampled_from(["ready", "absent", "dropped", "reply", "raised", "what", "unfit", "spent", "nothing", *GOOD])
REPLIES = st.dictionaries(WORDS, PLAIN, max_size=9) | st.builds(lambda more: GOOD | more, st.dictionaries(WORDS, PLAIN))


@given(REPLIES)
@example({"text": "stay"})
def test_any_reply_is_read_or_refused(message: dict[str, Any]) -> None:
    for reader in (reply_in, abilities_in):
        try:
            made = reader(message)
        except (Broken, ModelFault, BudgetExceeded):
            continue
        if isinstance(made, ModelReply):
            assert read(made, QUESTION) is not None
            json.dumps([made.text, list(made.calls), made.model])


@pytest.mark.parametrize("message", [each for each in FORGED if isinstance(each, dict) and "text" in each])
def test_a_forged_reply_is_refused(message: dict[str, Any]) -> None:
    if message == {"reply": message["reply"], **GOOD}:  # forged by its number alone, which the engine knows
        return
    with pytest.raises(Broken):
        reply_in(message)


MESSAGES = st.dictionaries(WORDS, st.integers() | st.text(), max_size=3).map(lambda words: outward(words)[0])


@given(st.lists(st.one_of(MESSAGES, MESSAGES, st.binary(max_size=40)), max_size=9), st.integers(1, 9))
def test_any_bytes_are_messages_or_refused(parts: list[bytes], size: int) -> None:
    inlet = Inlet()
    try:
        for part in parts:
            for start in range(0, len(part), size):
                assert all(isinstance(each, dict) for each in inlet.feed(part[start : start + size]))
    except Broken:
        pass


@given(st.lists(st.dictionaries(st.text(max_size=5), PLAIN.filter(lambda each: each == each), max_size=3), max_size=4))
def test_what_was_sent_in_pieces_comes_whole(messages: list[dict[str, Any]]) -> None:
    messages = [json.loads(json.dumps(each).replace("Infinity", "0").replace("NaN", "0")) for each in messages]
    data, inlet = b"".join(outward(each)[0] for each in messages), Inlet()
    came = [each for start in range(len(data)) for each in inlet.feed(data[start : start + 1])]
    assert [{name: each[name] for name in each if name != "blobs"} for each in came] == [
        {name: each[name] for name in each if name != "blobs"} for each in messages
    ]


@pytest.mark.parametrize(
    "data", [struct.pack(">I", LONGEST_REPLY + 1), struct.pack(">I", 2) + b"[]", struct.pack(">I", 4) + b"{} x",
             struct.pack(">I", 200_000) + b"[" * 200_000],
)  # fmt: skip
def test_what_is_too_long_or_no_object_is_refused(data: bytes) -> None:
    with pytest.raises(Broken):
        list(Inlet().feed(data))


@given(TEXTS, st.lists(ANY_CALL, max_size=4))
@settings(max_examples=60)
def test_an_answer_is_read_alike_over_the_pipe_and_here(text: str, calls: list[Any]) -> None:
    reply = reply_of(AIMessage.model_construct(content=text, tool_calls=calls))
    frame = outward({"reply": 1, **reply_words(reply)})[0]
    (message,) = Inlet().feed(frame)
    here = read(reply, QUESTION)
    try:
        there = reply_in(message)
    except BudgetExceeded:
        there = None
    if there is None:
        assert here.failed
        return
    over = read(there, QUESTION)
    assert (over.choice, bool(over.calls), bool(over.failed)) == (here.choice, bool(here.calls), bool(here.failed))


@example("\x01" * LONGEST)
@example("\x01" * 120)
@given(st.text(max_size=2 * LONGEST_NAME))
def test_no_answer_is_longer_than_what_may_be_sent(text: str) -> None:
    calls = [{"name": text, "args": {text: text}, "id": text}] * 100
    for answer in (ModelReply(text * 3), ModelReply(text, calls), RuntimeError(text * 9), BudgetExceeded(text)):
        assert len(outward({"reply": 1, **reply_words(answer)})[0]) <= LONGEST_REPLY


def test_messages_and_pictures_come_as_they_were_sent() -> None:
    picture = {"type": "image", "base64": "aGVsbG8=", "mime_type": "image/png"}
    messages = [
        SystemMessage("rules"),
        HumanMessage([{"type": "text", "text": "see"}, picture, {"type": "text", "text": "and"}, picture]),
        ToolMessage("found", tool_call_id="7", name="look", status="error"),
    ]
    written, blobs = packed(messages)
    assert blobs == [b"aGVsbG8=", b"aGVsbG8="]
    came = messages_in(json.loads(json.dumps(written)), blobs)
    assert [each.model_dump() for each in came] == [each.model_dump() for each in messages]


def test_abilities_come_as_they_were_sent() -> None:
    able = Abilities(schemas=True, tools=False, images=True, name="small")
    assert abilities_in(ability_words(able)) == able
