# SPDX-License-Identifier: Apache-2.0
"""What is in a model's message: the choice of one option, calls of tools, or nothing that can be read.

Rule: nothing is guessed. A choice is one call of an option, one JSON object, or one option's name and nothing else.
"""

from __future__ import annotations

import json
import re
from collections.abc import Callable, Collection, Mapping, Sequence
from typing import TYPE_CHECKING, Any, NamedTuple

from rai_missions.engine.decision import Offer, Question
from rai_missions.redaction import cut, cut_repr

if TYPE_CHECKING:
    from langchain_core.messages import AIMessage

__all__ = (
    "CALLS",
    "LONGEST",
    "ModelReply",
    "ParsedReply",
    "callable_name",
    "excess",
    "plain",
    "read",
    "reply_of",
    "too_long",
)  # fmt: skip

LONGEST = 20_000
"""Characters of an answer that are read; more is refused unread."""
DEEPEST = 30
"""How deeply an answer, or what a call is given, may be nested; anyone who walks through it later need not count."""
LONGEST_NAME = 200
LONGEST_FUNCTION = 64
LONGEST_WHY = 500
CALLS = 100
"""Calls in one message that are looked at."""
UNREADABLE = "answered with a call whose arguments are not JSON, or are too long"
THOUGHT = re.compile(r"<think>.*?</think>", re.DOTALL)
"""Thinking aloud is no part of the answer; some models send it along as text."""


class ModelReply(NamedTuple):
    """What a model answered, as far as it is read: plain data."""

    text: str
    calls: Sequence[Mapping[str, Any]] = ()
    """Calls of options and tools, as langchain has them: `name`, `args`, `id`; `args` is None where it is not read."""
    broken: int = 0
    """Calls whose arguments are not JSON."""
    tokens_in: int = 0
    tokens_out: int = 0
    model: str = ""
    """What the provider calls the model that answered."""


def reply_of(message: AIMessage) -> ModelReply:
    """A message of langchain's as what is read of it."""
    used: Mapping[str, Any] = message.usage_metadata or {}
    about = message.response_metadata or {}
    name = about.get("model_name") or about.get("model")
    calls = list(message.tool_calls or ())
    return ModelReply(
        message.text,
        [{**call, "args": plain(call["args"])} for call in calls] if len(calls) <= CALLS else calls,
        len(message.invalid_tool_calls or ()),
        _count(used.get("input_tokens")),
        _count(used.get("output_tokens")),
        name if isinstance(name, str) and not name.startswith("/") else "",  # a local server may name a file's path
    )


def excess(reply: ModelReply) -> str:
    """Why a reply is not read, as one that is too long; empty where it is read."""
    if len(reply.text) > LONGEST:
        return too_long(len(reply.text))
    return too_many(len(reply.calls)) if len(reply.calls) > CALLS else ""


def _count(tokens: Any) -> int:
    return max(0, tokens) if isinstance(tokens, int) else 0


class ParsedReply(NamedTuple):
    """What is in a message; one of the three is filled."""

    choice: Mapping[str, Any] | None = None
    """`option`, `parameters`, `why`."""
    calls: tuple[Mapping[str, Any], ...] = ()
    """Calls of tools that are no options, as langchain has them: `name`, `args`, `id`."""
    failed: str = ""


def callable_name(option: str) -> str:
    """An option's name as the name of a function: providers allow no slash in it, and 64 characters."""
    return f"{option.replace('/', '__'):.{LONGEST_FUNCTION}}"


def read(reply: ModelReply, question: Question, clean: Callable[[str], str] = str) -> ParsedReply:
    """Read a model's message as an answer to a question.

    Args:
        reply: What the model answered.
        question: What it was asked.
        clean: Takes secrets out of a text; done before a text is cut, so that no half of one is left.
    """
    if len(reply.text) > LONGEST:
        return ParsedReply(failed=too_long(len(reply.text)))
    calls, broken = reply.calls, reply.broken
    offers = {callable_name(offer.name): offer for offer in question.options}
    options = [call for call in calls if call["name"] in offers]
    if options and len(calls) + broken > 1:
        return ParsedReply(failed=f"answered with {len(calls) + broken} calls; one was asked for")
    if options:
        return _called(offers[options[0]["name"]], options[0]["args"], clean)
    if calls:
        return _asked_for(calls)
    if broken:
        return ParsedReply(failed=f"answered with {broken} call{'s' * (broken > 1)} whose arguments are not JSON")
    return _of_text(clean(reply.text), {offer.name for offer in question.options}, clean)


def too_long(characters: int) -> str:
    """Why an answer of so many characters is not read."""
    return f"answered with {characters} characters; at most {LONGEST} are read"


def too_many(calls: int) -> str:
    """Why so many calls in one message are not looked at."""
    return f"asked for {calls} calls of tools at once"


def _asked_for(calls: Sequence[Mapping[str, Any]]) -> ParsedReply:
    """Calls of tools, with arguments that are JSON and not long."""
    if len(calls) > CALLS:
        return ParsedReply(failed=too_many(len(calls)))
    readable = tuple({**call, "args": plain(call["args"])} for call in calls)
    if any(not isinstance(call["args"], dict) for call in readable):
        return ParsedReply(failed=UNREADABLE)
    return ParsedReply(calls=readable)


def _called(offer: Offer, arguments: Any, clean: Callable[[str], str]) -> ParsedReply:
    given = plain(arguments)
    if not isinstance(given, dict):
        return ParsedReply(failed=UNREADABLE)
    properties = (offer.parameters or {}).get("properties", {})
    why = given.pop("why", "") if "why" not in properties else ""
    return _choice(offer.name, given, why, clean)


def _of_text(text: str, offered: Collection[str], clean: Callable[[str], str]) -> ParsedReply:
    text = THOUGHT.sub("", text).strip()
    if not text:
        return ParsedReply(failed="answered nothing")
    if text in offered:
        return _choice(text, {}, "", clean)
    found = _objects(text)
    if found is None:
        return ParsedReply(failed=f"answered with JSON that is broken: {cut_repr(text, 120)}")
    if len(found) > 1:
        return ParsedReply(failed=f"answered with {len(found)} objects; one was asked for")
    if not found or "option" not in found[0]:
        return ParsedReply(failed=f"answered without naming an option in JSON: {cut_repr(text, 120)}")
    given = found[0]
    unknown = sorted(given.keys() - {"option", "parameters", "why"})
    if unknown:
        return ParsedReply(
            failed=f"answered with {cut_repr(unknown[0], 60)}, which was not asked for; give option, parameters, why"
        )
    parameters = given.get("parameters")
    return _choice(given["option"], {} if parameters is None else parameters, given.get("why", ""), clean)


def _choice(option: Any, parameters: Any, why: Any, clean: Callable[[str], str]) -> ParsedReply:
    if not isinstance(option, str):
        return ParsedReply(failed=f"'option' is the name of one option, not {cut_repr(option, 60)}")
    if len(option) > LONGEST_NAME:
        return ParsedReply(failed=f"'option' is the name of one option, not {len(option)} characters")
    if not isinstance(parameters, dict):
        return ParsedReply(failed=f"'parameters' is an object, not {cut_repr(parameters, 60)}")
    reason = why if isinstance(why, str) else ""
    return ParsedReply({"option": option, "parameters": parameters, "why": cut(clean(reason), LONGEST_WHY)})


def plain(value: Any) -> Any:
    """The value as JSON would bring it back, or None: not JSON, too deep or too long."""
    try:
        text = json.dumps(value, allow_nan=False)
    except (TypeError, ValueError, RecursionError):
        return None
    return _loaded(text, 0)[0] if len(text) <= LONGEST else None


def _depth(value: Any) -> int:
    """How deeply lists and objects are nested, looked at level by level."""
    depth, level = 0, [value]
    while level := [
        item
        for each in level
        if isinstance(each, dict | list)
        for item in (each.values() if isinstance(each, dict) else each)
    ]:
        depth += 1
    return depth


def _objects(text: str) -> list[dict[str, Any]] | None:
    """The JSON objects that follow each other in a text; None where a brace begins something else.

    What is inside half an object is no answer: it may be an example.
    """
    found: list[dict[str, Any]] = []
    start = text.find("{")
    while start >= 0:
        value, end = _loaded(text, start)
        if not isinstance(value, dict):
            return None
        found.append(value)
        start = text.find("{", end)
    return found


def _loaded(text: str, start: int) -> tuple[Any, int]:
    """The JSON value that begins at a place, and where it ends; None, and the next place, where there is none."""
    try:
        value, end = DECODER.raw_decode(text, start)
        json.dumps(
            value, ensure_ascii=False, allow_nan=False
        ).encode()  # half a surrogate pair could never be written down
    except (ValueError, RecursionError):
        return None, start + 1
    return (value, end) if _depth(value) <= DEEPEST else (None, start + 1)


def _unambiguous(pairs: list[tuple[str, Any]]) -> dict[str, Any]:
    if len({name for name, _ in pairs}) != len(pairs):
        raise ValueError("a name is there twice")
    return dict(pairs)


def _no_number(name: str) -> Any:
    raise ValueError(f"JSON has no {name}")


DECODER = json.JSONDecoder(object_pairs_hook=_unambiguous, parse_constant=_no_number)
