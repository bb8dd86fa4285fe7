# SPDX-License-Identifier: Apache-2.0
"""Messages between a person and a robot, as messages of LangChain and back."""

from __future__ import annotations

import base64
import re
from typing import Any

import pytest
from hypothesis import given
from langchain_core.messages import AIMessage, AIMessageChunk, BaseMessage, HumanMessage, SystemMessage, ToolMessage

from rai_missions.agents.hri_langchain import from_langchain, to_langchain
from rai_missions.connectors.hri.message import Audio, HRIMessage
from rai_missions.errors import UsageError
from rai_missions.image import Image, png
from tests.connectors.hri.test_message import messages

PICTURE = png(2, 1, b"abcdef")


@given(messages)
def test_a_message_is_the_same_after_its_way_through_langchain(message: HRIMessage) -> None:
    again = from_langchain(to_langchain(message))
    for name in ("text", "audios", "author", "name", "communication_id"):
        assert getattr(again, name) == getattr(message, name)
    assert [each.data for each in again.images] == [each.file().data for each in message.images]


def test_pictures_and_sound_are_content_blocks_that_every_provider_is_given() -> None:
    sent = HRIMessage("look", (Image("x", 2, 1, "png", PICTURE),), (Audio(b"\1\0", 8000),), "human", "Anna")
    made = to_langchain(sent)
    assert isinstance(made, HumanMessage) and made.name == "Anna"
    assert [block["type"] for block in made.content_blocks] == ["text", "image", "audio"]
    assert made.content_blocks[1] == {
        "type": "image",
        "base64": base64.b64encode(PICTURE).decode(),
        "mime_type": "image/png",
    }
    assert to_langchain(sent, images=False, audios=False).content == "look"
    assert to_langchain(HRIMessage("yes", author="ai")) == AIMessage("yes")


def block_of(kind: str, **fields: Any) -> HumanMessage:
    return HumanMessage([{"type": kind, **fields}])


@pytest.mark.parametrize(
    "message",
    [
        block_of("image", base64=base64.b64encode(PICTURE).decode(), mime_type="image/png"),
        block_of("image_url", image_url={"url": f"data:image/png;base64,{base64.b64encode(PICTURE).decode()}"}),
        block_of("image_url", image_url=f"data:image/png;base64,{base64.b64encode(PICTURE).decode()}"),
    ],
)
def test_pictures_in_the_words_of_several_providers_are_read(message: HumanMessage) -> None:
    (image,) = from_langchain(message).images
    assert (image.data, image.width, image.height) == (PICTURE, 2, 1)


def test_a_models_thoughts_and_calls_are_no_talk() -> None:
    message = AIMessage(["I ", {"type": "text", "text": "wait"}, {"type": "tool_use", "id": "1"}, {"type": "thinking"}])
    assert from_langchain(message) == HRIMessage("I wait", author="ai")
    own = ("tool_call_chunk", "invalid_tool_call", "server_tool_result", "function_call", "redacted_thinking")
    assert from_langchain(AIMessage([{"type": each} for each in own])) == HRIMessage(author="ai")


def test_a_chunk_of_a_models_stream_is_a_message_of_the_model() -> None:
    assert from_langchain(AIMessageChunk("I wait")) == HRIMessage("I wait", author="ai")


@pytest.mark.parametrize(
    ("message", "sentence"),
    [
        (SystemMessage("obey"), "a message of type 'system' is no talk; there is: human, ai"),
        (ToolMessage("done", tool_call_id="1"), "a message of type 'tool' is no talk"),
        (block_of("video", base64="AA=="), "content/0: a block of type 'video' is none of text, image and audio"),
        (block_of("image", url="https://x.org/a.png"), "'https://x.org/a.png' is a link; nothing is fetched"),
        (block_of("image", url="file:///etc/passwd"), "is a link; nothing is fetched, send the bytes in base64"),
        (block_of("image", base64="a b"), "content/0: 3 characters are no base64"),
        (block_of("image", base64="AAAA"), "content/0: the picture is neither a PNG nor a JPEG file"),
        (block_of("text", text=None), "content/0: null is given where text belongs"),
        (block_of("image"), "content/0: a block of type 'image' without its bytes in base64"),
        (block_of("audio", base64="AAAA"), "audio: 3 bytes are no WAV file"),
        (HumanMessage("x" * 200_000), "text: 200000 characters; there are 100000 at the most"),
    ],
)  # fmt: skip
def test_what_is_no_message_is_refused(message: BaseMessage, sentence: str) -> None:
    with pytest.raises(UsageError, match=re.escape(sentence)):
        from_langchain(message)


def test_a_picture_that_cannot_be_had_is_named() -> None:
    with pytest.raises(UsageError, match="images/0: the picture cannot be had"):
        to_langchain(HRIMessage("look", (Image("x", 2, 1, "rgb8", b""),)))
