# SPDX-License-Identifier: Apache-2.0
"""What is asked of a model's process, and what it answers, as plain data.

Rule: the engine checks every reply, field by field; what is wrong breaks the process off, not the engine.
"""

from __future__ import annotations

import json
import math
from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from langchain_core.messages import BaseMessage, HumanMessage, SystemMessage, ToolMessage

from rai_missions.answerers.model.chat import Abilities, BudgetExceeded, ModelFault
from rai_missions.answerers.model.parse_reply import CALLS, LONGEST, ModelReply, excess, plain
from rai_missions.connectors.process.frames import Broken
from rai_missions.redaction import Redaction, cut, redacted

__all__ = ("abilities_in", "ability_words", "messages_in", "packed", "reply_in", "reply_words")

LONGEST_NAME = 400
LONGEST_CALLS = 150_000
"""Characters of JSON of all calls in one message."""
LONGEST_WORDS = 20_000
"""Characters of an exception that are sent."""
NUMBER = 2**53


def packed(messages: Iterable[BaseMessage]) -> tuple[list[dict[str, Any]], list[bytes]]:
    """Messages as JSON, with the pictures in them next to it."""
    blobs: list[bytes] = []
    written = []
    for message in messages:
        words: dict[str, Any] = {"role": message.type, "content": _packed_content(message.content, blobs)}
        if isinstance(message, ToolMessage):
            words |= {"call": message.tool_call_id, "name": message.name, "status": message.status}
        written.append(words)
    return written, blobs


def _packed_content(content: Any, blobs: list[bytes]) -> Any:
    if isinstance(content, str):
        return content
    return [_packed_block(block, blobs) for block in content]


def _packed_block(block: Any, blobs: list[bytes]) -> Any:
    if not isinstance(block, Mapping) or not isinstance(block.get("base64"), str):
        return block
    blobs.append(block["base64"].encode())
    return {**block, "base64": len(blobs) - 1}


def messages_in(written: Sequence[Mapping[str, Any]], blobs: Sequence[bytes]) -> list[BaseMessage]:
    """Messages of langchain's, of what `packed` wrote; in the model's process."""
    return [_message(words, _content(words["content"], blobs)) for words in written]


def _message(words: Mapping[str, Any], content: Any) -> BaseMessage:
    if words["role"] == "system":
        return SystemMessage(content)
    if words["role"] == "tool":
        return ToolMessage(content, tool_call_id=words["call"], name=words["name"], status=words["status"])
    return HumanMessage(content)


def _content(content: Any, blobs: Sequence[bytes]) -> Any:
    if isinstance(content, str):
        return content
    return [
        {**block, "base64": blobs[block["base64"]].decode()} if isinstance(block, dict) and "base64" in block else block
        for block in content
    ]


# -- replies: made in the model's process, read in the engine's --------------------------------------------------------


def ability_words(able: Abilities) -> dict[str, Any]:
    """What a model can do, once it is opened."""
    return {"ready": {**able._asdict(), "name": cut(able.name, LONGEST_NAME)}}


def abilities_in(message: Mapping[str, Any]) -> Abilities:
    """What a model can do, by its process's report.

    Raises:
        Broken: The report is of another form.
    """
    given = message.get("ready")
    if not isinstance(given, dict) or set(given) != set(Abilities._fields):
        raise Broken("it sent abilities that are none")
    name = _text(given, "name", LONGEST_NAME)
    flags = {word: flag for word, flag in given.items() if word != "name"}
    if not all(isinstance(flag, bool) for flag in flags.values()):
        raise Broken("it sent abilities that are none")
    return Abilities(**flags, name=name)


def reply_words(answer: ModelReply | BaseException | None) -> dict[str, Any]:
    """What came of one call, no longer than what is read of it, and without secrets."""
    if isinstance(answer, BudgetExceeded):
        return {"spent": cut(answer, LONGEST_NAME)}
    if isinstance(answer, BaseException):
        raised = answer if isinstance(answer, ModelFault) else ModelFault.by(answer)
        what = cut(raised.what, LONGEST_WORDS)
        words = {"raised": cut(raised.kind, LONGEST_NAME), "what": what, "unfit": raised.unfit}
        return {**words, "after_s": raised.after_s}
    if answer is None:
        return {"nothing": True}
    if why := excess(answer):
        return {"spent": why}
    calls = [_call_words(call) for call in answer.calls]
    if len(json.dumps(calls)) > LONGEST_CALLS:
        return {"spent": f"asked for calls of tools in more than {LONGEST_CALLS} characters"}
    counts = {"in": min(answer.tokens_in, NUMBER), "out": min(answer.tokens_out, NUMBER), "broken": answer.broken}
    return {"text": redacted(answer.text), "calls": calls, **counts, "model": cut(answer.model, LONGEST_NAME)}


def _call_words(call: Mapping[str, Any]) -> dict[str, Any]:
    """Arguments that are not JSON, too deep or too long, are none: null."""
    words = {"name": cut(call["name"], LONGEST_NAME), "id": cut(call.get("id") or "", LONGEST_NAME)}
    return {**words, "args": Redaction().json(plain(call["args"]))}


def reply_in(message: Mapping[str, Any]) -> ModelReply | None:
    """What came of a call, by the report of the model's process.

    Raises:
        ModelFault: The model raised.
        BudgetExceeded: Its answer is longer than what is read.
        Broken: The reply is none.
    """
    if "raised" in message:
        kind, what = _text(message, "raised", LONGEST_NAME), _text(message, "what", LONGEST_WORDS)
        raise ModelFault(kind, what, unfit=message.get("unfit") is True, after_s=_seconds(message, "after_s"))
    if "spent" in message:
        raise BudgetExceeded(_text(message, "spent", LONGEST_NAME))
    if message.get("nothing") is True:
        return None
    calls = message.get("calls")
    if not isinstance(calls, list) or len(calls) > CALLS:
        raise Broken("it sent calls that are none")
    text, model = _text(message, "text", LONGEST), _text(message, "model", LONGEST_NAME)
    broken, tokens_in, tokens_out = (_count(message, name) for name in ("broken", "in", "out"))
    return ModelReply(text, [_call(call) for call in calls], broken, tokens_in, tokens_out, model)


def _call(call: Any) -> dict[str, Any]:
    if not isinstance(call, dict) or not isinstance(call.get("args"), dict | None):
        raise Broken("it sent a call that is none")
    name, number = _text(call, "name", LONGEST_NAME), _text(call, "id", LONGEST_NAME)
    return {"name": name, "args": call.get("args"), "id": number, "type": "tool_call"}


def _text(message: Mapping[str, Any], name: str, longest: int) -> str:
    text = message.get(name)
    if not isinstance(text, str) or len(text) > longest:
        raise Broken(f"it sent no '{name}' of {longest} characters at the most")
    return text


def _seconds(message: Mapping[str, Any], name: str) -> float:
    """A time above 0; 0 where there is none."""
    given = message.get(name)
    return given if isinstance(given, float) and 0 < given < math.inf else 0.0


def _count(message: Mapping[str, Any], name: str) -> int:
    count = message.get(name)
    if type(count) is not int or not 0 <= count <= NUMBER:
        raise Broken(f"it sent no count '{name}'")
    return count
