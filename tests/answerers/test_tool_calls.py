# SPDX-License-Identifier: Apache-2.0
"""Whatever a tool returns or raises is data for the model, in bounds, and ends nothing."""

from __future__ import annotations

import json
from typing import Any

import pytest
from langchain_core.tools import StructuredTool

from rai_missions.answerers.model.tool_calls import LONGEST_TEXT, MOST_PICTURES, ToolLookup, look_up

SECRET = "sk-of-a-tool-0123456789"


class Nameless(Exception):
    """Has no text."""

    def __str__(self) -> str:
        raise RuntimeError("no text")


def used(gives: Any = None, *, raises: BaseException | None = None, lengths: list[int] | None = None) -> ToolLookup:
    def act() -> Any:
        """Looks."""
        if raises is not None:
            raise raises
        return gives

    def clean(text: str) -> str:
        (lengths if lengths is not None else []).append(len(text))
        return text.replace(SECRET, "[hidden]")

    tool = StructuredTool.from_function(act, name="look", description="looks", metadata={"read_only": True})
    looked = look_up({"look": tool}, {"name": "look", "args": {}, "id": "1"}, clean)
    assert SECRET not in json.dumps([looked.message.content, looked.note])
    return looked


@pytest.mark.parametrize(
    "raised", [ValueError(SECRET), Nameless(), SystemExit(3), KeyboardInterrupt(), MemoryError(), RecursionError()]
)
def test_whatever_a_tool_raises_is_an_answer(raised: BaseException) -> None:
    message = used(raises=raised).message
    assert message.status == "error" and str(message.content).startswith('"failed: ')
    assert message.content != '"failed: "'


@pytest.mark.parametrize("gives", [None, b"\xff", float("nan"), [], [None], {"a": SECRET}, "\ud800", SECRET, object()])
def test_whatever_a_tool_returns_is_a_text(gives: Any) -> None:
    message = used(gives).message
    assert message.status == "success" and isinstance(message.content, str) and message.content.encode()


@pytest.mark.parametrize("gives", ["a" * 1_000_000, ["b" * 100] * 10_000])
def test_of_a_huge_result_a_part_is_looked_at(gives: Any) -> None:
    lengths: list[int] = []
    looked = used(gives, lengths=lengths)
    assert max(lengths) <= LONGEST_TEXT
    assert str(len(gives) if isinstance(gives, str) else 1_009_999) in looked.message.content


def test_a_tool_that_is_asynchronous_alone_is_used() -> None:
    async def act(number: int) -> str:
        """Looks."""
        return f"saw {number}"

    tool = StructuredTool.from_function(coroutine=act, name="look", metadata={"read_only": True})
    looked = look_up({"look": tool}, {"name": "look", "args": {"number": 7}, "id": "1"}, str)
    assert looked.message.content == '"saw 7"'


def test_pictures_are_bounded_and_none_is_fetched() -> None:
    own = {"type": "image", "base64": "AAAA", "mime_type": "image/png"}
    quoted = {"type": "image_url", "image_url": {"url": "data:image/png;base64,AAAA"}}
    elsewhere = [{"type": "image", "url": "http://x/y.png"}, {"type": "image_url", "image_url": {"url": "http://x"}}]
    looked = used([own, quoted, *elsewhere])
    assert looked.pictures == (own, quoted)
    assert str(looked.message.content).count("only its address is given") == 2
    many = used([own] * (MOST_PICTURES + 2))
    assert len(many.pictures) == MOST_PICTURES and str(many.message.content).count("too many") == 2
