# SPDX-License-Identifier: Apache-2.0
"""Messages between a person and a robot as messages of LangChain, and back.

Rule: only a person's and a model's messages cross here; a system's or a tool's text is never taken for talk.
"""

from __future__ import annotations

import base64
import binascii
from collections.abc import Mapping
from typing import Any

from langchain_core.messages import AIMessage, BaseMessage, HumanMessage

from rai_missions.connectors.hri.message import Audio, Author, HRIMessage
from rai_missions.errors import UsageError, in_words
from rai_missions.image import Image
from rai_missions.redaction import shown

__all__ = ("from_langchain", "to_langchain")

AUTHORS: Mapping[type[BaseMessage], Author] = {HumanMessage: "human", AIMessage: "ai"}
"""Kind of message → its author; a chunk of a stream is of its message's kind."""
OWN = frozenset(
    {
        "tool_use", "tool_call", "tool_call_chunk", "invalid_tool_call", "server_tool_call", "server_tool_call_chunk",
        "server_tool_result", "function_call", "input_json_delta", "reasoning", "thinking", "redacted_thinking",
    }
)  # fmt: skip
"""Blocks of a model's own thoughts and calls, which are no talk."""
WAV = "audio/wav"


def to_langchain(message: HRIMessage, *, images: bool = True, audios: bool = True) -> HumanMessage | AIMessage:
    """A message for a chat model; pictures and sound are content blocks.

    Args:
        message: A whole message.
        images: Whether pictures are sent along.
        audios: Whether sound is.

    Raises:
        UsageError: A picture cannot be had.
    """
    blocks: list[Any] = [_picture(index, image) for index, image in enumerate(message.images if images else ())]
    blocks += [
        {"type": "audio", "base64": base64.b64encode(each.wav()).decode(), "mime_type": WAV}
        for each in (message.audios if audios else ())
    ]
    content: Any = (
        [*([{"type": "text", "text": message.text}] if message.text else []), *blocks] if blocks else message.text
    )
    kind = HumanMessage if message.author == "human" else AIMessage
    return kind(content=content, name=message.name or None, id=message.communication_id or None)


def from_langchain(message: BaseMessage) -> HRIMessage:
    """A person's or a model's message.

    Raises:
        UsageError: It is of another kind, or a part of it is none that a message carries.
    """
    author = next((author for kind, author in AUTHORS.items() if isinstance(message, kind)), None)
    if author is None:
        raise UsageError(f"a message of type {shown(message.type)} is no talk; there is: human, ai")
    texts: list[str] = []
    images: list[Image] = []
    audios: list[Audio] = []
    content = [message.content] if isinstance(message.content, str) else message.content
    for index, block in enumerate(content):
        _take(index, block, texts, images, audios)
    name, ident = message.name or "", message.id or ""
    return HRIMessage("".join(texts), tuple(images), tuple(audios), author, name, ident)


def _take(index: int, block: Any, texts: list[str], images: list[Image], audios: list[Audio]) -> None:
    kind = "text" if isinstance(block, str) else block.get("type")
    if kind == "text":
        texts.append(_text(index, block if isinstance(block, str) else block.get("text", "")))
    elif kind in ("image", "image_url"):
        images.append(_image(index, _bytes(index, block)))
    elif kind in ("audio", "input_audio"):
        audios.append(Audio.of_wav(_bytes(index, block)))
    elif not isinstance(kind, str) or kind not in OWN:
        raise UsageError(f"content/{index}: a block of type {shown(kind)} is none of text, image and audio")


def _text(index: int, text: Any) -> str:
    if not isinstance(text, str):
        raise UsageError(f"content/{index}: {shown(text)} is given where text belongs")
    return text


def _picture(index: int, image: Image) -> dict[str, Any]:
    try:
        return image.file().block()
    except Exception as fault:  # the bytes are made when asked for, by whatever camera
        raise UsageError(f"images/{index}: the picture cannot be had: {shown(in_words(fault))}") from fault


def _image(index: int, data: bytes) -> Image:
    try:
        return Image.of_file(f"content/{index}", data)
    except ValueError as fault:
        raise UsageError(f"content/{index}: the picture {fault}") from None


def _bytes(index: int, block: Mapping[str, Any]) -> bytes:
    """The bytes in a content block: LangChain's own words, and those of OpenAI's."""
    nested = block.get(str(block.get("type")))
    inner = nested if isinstance(nested, Mapping) else block
    given = inner.get("base64") or inner.get("data") or inner.get("url") or nested
    if not isinstance(given, str):
        raise UsageError(f"content/{index}: a block of type {shown(block.get('type'))} without its bytes in base64")
    head, comma, body = given.partition(",")
    if given.startswith(("http:", "https:", "file:")) or (comma and not head.endswith(";base64")):
        raise UsageError(f"content/{index}: {shown(given)} is a link; nothing is fetched, send the bytes in base64")
    try:
        return base64.b64decode(body if comma else given, validate=True)
    except (binascii.Error, ValueError):
        raise UsageError(f"content/{index}: {len(given)} characters are no base64") from None
