# SPDX-License-Identifier: Apache-2.0
"""A read-only tool used while a model thinks: its answer as data, its picture where pictures are shown, a note of it.

Rule: what a tool returns is data, marked as such, and nothing that it returns or raises ends the conversation.
"""

from __future__ import annotations

import asyncio
import json
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from langchain_core.messages import HumanMessage, ToolMessage
from langchain_core.tools import BaseTool

from rai_missions.answerers.model.prompt import quoted
from rai_missions.redaction import cut
from rai_missions.tools.result import outline

__all__ = ("ToolLookup", "look_up", "shown")

LONGEST_NAME, LONGEST_ID, LONGEST_NOTE = 100, 200, 500
LONGEST_TEXT = 64_000
"""Characters of a result that are looked at; a longer one would keep the interpreter, and so the engine, for long."""
MOST_PICTURES, LARGEST_PICTURES = 8, 32 * 1024 * 1024
"""How many pictures of one call are shown, and the characters of all of them as they are sent."""


class ToolLookup(NamedTuple):
    """What came of one call."""

    message: ToolMessage
    note: Mapping[str, str]
    """For the journal, next to the answer: `tool`, `arguments` as JSON, and the beginning of its result as `said`."""
    pictures: tuple[Mapping[str, Any], ...] = ()
    """Content blocks."""


def look_up(tools: Mapping[str, BaseTool], call: Mapping[str, Any], clean: Callable[[str], str]) -> ToolLookup:
    """Run a tool, if there is one of that name.

    Args:
        tools: Those that may be used.
        call: As langchain has it: `name`, `args`, `id`.
        clean: Takes secrets out of a text.
    """
    name, number = cut(call["name"], LONGEST_NAME), cut(call.get("id") or "", LONGEST_ID)
    tool = tools.get(name)
    pictures: tuple[Mapping[str, Any], ...] = ()
    if tool is None:
        text, status = quoted(f"refused: no tool '{name}' here; there is: {', '.join(tools) or 'none'}"), "error"
    else:
        try:
            made = _used(tool, {"type": "tool_call", "name": name, "args": dict(call["args"]), "id": number})
            result, pictures = _parts(made)
            found = clean(cut(result, LONGEST_TEXT))
            text = found if _marks_data(tool) else quoted(found, len(result))
            status = made.status if isinstance(made, ToolMessage) else "success"
        except BaseException as error:  # noqa: BLE001 - the model is shown it, even an exit, and may choose without it
            why = cut(error, LONGEST_TEXT) or type(error).__name__
            text, status = quoted(clean(f"failed: {why}")), "error"
    message = ToolMessage(text, tool_call_id=number, name=name, status=status)
    arguments = cut(clean(json.dumps(outline(call["args"]), ensure_ascii=False)), LONGEST_NOTE)
    return ToolLookup(message, {"tool": name, "arguments": arguments, "said": cut(text, LONGEST_NOTE)}, pictures)


def shown(looks: list[ToolLookup]) -> list[HumanMessage]:
    """The pictures of some calls: a message of their own, since few servers take pictures from a tool."""
    blocks: list[Any] = []
    for look in looks:
        if look.pictures:
            blocks += [{"type": "text", "text": f"The picture that {look.message.name} gave:"}, *look.pictures]
    return [HumanMessage(blocks)] if blocks else []


def _marks_data(tool: BaseTool) -> bool:
    """Whether a tool's text marks as data what is not its own."""
    return (tool.metadata or {}).get("marks_data") is True


def _used(tool: BaseTool, call: Mapping[str, Any]) -> Any:
    """What a tool makes of a call; one that is asynchronous alone has a loop of its own."""
    if getattr(tool, "coroutine", None) is not None and getattr(tool, "func", None) is None:
        return asyncio.run(tool.ainvoke(dict(call)))
    return tool.invoke(dict(call))


def _parts(made: Any) -> tuple[str, tuple[Mapping[str, Any], ...]]:
    """The text and the pictures of what a tool gave; what is no picture to be shown is named in the text."""
    content = made.content if isinstance(made, ToolMessage) else made
    if not isinstance(content, list):
        return content if isinstance(content, str) else str(content), ()
    texts, pictures, size = list[str](), list[Mapping[str, Any]](), 0
    for block in content:
        data = _picture_data(block) if isinstance(block, Mapping) else None
        if data is None:
            texts.append(str(block.get("text", "")) if isinstance(block, Mapping) else str(block))
        elif not data:
            texts.append("(a picture that is not shown: only its address is given)")
        elif len(pictures) == MOST_PICTURES or size + len(data) > LARGEST_PICTURES:
            texts.append("(a picture that is not shown: there are too many, or too large ones)")
        else:
            pictures.append(block)  # type: ignore[arg-type]  # a mapping, since it has data
            size += len(data)
    return "\n".join(text for text in texts if text), tuple(pictures)


def _picture_data(block: Mapping[str, Any]) -> str | None:
    """The bytes of a content block's picture as text; empty where they are elsewhere, None where it is no picture."""
    if block.get("type") == "image_url":
        given = block.get("image_url")
        url = given.get("url") if isinstance(given, Mapping) else given
        return url if isinstance(url, str) and url.startswith("data:") else ""
    if block.get("type") == "image":
        data = block.get("base64", block.get("data"))
        return data if isinstance(data, str) else ""
    return None
