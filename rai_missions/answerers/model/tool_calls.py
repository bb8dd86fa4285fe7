# SPDX-License-Identifier: Apache-2.0
"""A read-only tool used while a model thinks: its answer as data, its picture where pictures are shown, a note of it.

Rule: what a tool returns is data, marked as such, and nothing that it returns or raises ends the conversation.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from langchain_core.messages import HumanMessage, ToolMessage
from langchain_core.tools import BaseTool

from rai_missions.answerers.model.prompt import quoted
from rai_missions.redaction import cut
from rai_missions.tools.result import outline

__all__ = ("ToolLookup", "is_read_only", "look_up", "shown")

LONGEST_NAME, LONGEST_ID, LONGEST_NOTE = 100, 200, 500


class ToolLookup(NamedTuple):
    """What came of one call."""

    message: ToolMessage
    note: Mapping[str, str]
    """For the journal, next to the answer: `tool`, `arguments` as JSON, and the beginning of its result as `said`."""
    pictures: tuple[Mapping[str, Any], ...] = ()
    """Content blocks."""


def is_read_only(tool: BaseTool) -> bool:
    """Whether a tool is marked as one that only looks: `metadata={"read_only": True}`."""
    return (tool.metadata or {}).get("read_only") is True


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
            made = tool.invoke({"type": "tool_call", "name": name, "args": dict(call["args"]), "id": number})
            result, pictures = _parts(made)
            text = clean(result) if _marks_data(tool) else quoted(clean(result))
            status = made.status if isinstance(made, ToolMessage) else "success"
        except Exception as error:  # noqa: BLE001 - the model is shown it, and may choose without it
            text, status = quoted(clean(f"failed: {error}")), "error"
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


def _parts(made: Any) -> tuple[str, tuple[Mapping[str, Any], ...]]:
    """The text and the pictures of what a tool gave."""
    content = made.content if isinstance(made, ToolMessage) else made
    if not isinstance(content, list):
        return content if isinstance(content, str) else str(content), ()
    blocks = [block for block in content if isinstance(block, Mapping) and block.get("type") == "image"]
    texts = [str(block.get("text", "")) if isinstance(block, Mapping) else str(block) for block in content]
    return "\n".join(text for text in texts if text), tuple(blocks)
