# SPDX-License-Identifier: Apache-2.0
"""Chat models that answer what a test wants, and chat models that do what models must be survived doing.

They are langchain's own kind, so that whatever asks them is tried as it is used.
"""

from __future__ import annotations

import itertools
import threading
from collections.abc import Callable, Iterable, Iterator, Sequence
from typing import Any, Literal

from langchain_core.language_models import BaseChatModel
from langchain_core.messages import AIMessage, AIMessageChunk, BaseMessage
from langchain_core.output_parsers import JsonOutputParser
from langchain_core.outputs import ChatGeneration, ChatGenerationChunk, ChatResult
from langchain_core.runnables import Runnable
from pydantic import PrivateAttr

__all__ = (
    "BabblingModel",
    "HangingModel",
    "LyingModel",
    "RaisingModel",
    "ScriptedModel",
    "SilentModel",
    "ToolFloodModel",
    "WordyModel",
    "call",
)

Answer = str | AIMessage | BaseException | Callable[[list[BaseMessage]], "str | AIMessage"]
"""Text, a message, what is raised, or a function of the messages received."""


def call(name: str, number: str = "1", **arguments: Any) -> dict[str, Any]:
    """One call of a tool, as a message carries it."""
    return {"name": name, "args": arguments, "id": number, "type": "tool_call"}


class DoubleModel(BaseChatModel):
    """A model without a network that takes tools and schemas; its profile may deny either.

    `DoubleModel(profile={"tool_calling": False, "structured_output": False})` takes plain text alone.
    """

    _received: list[tuple[list[BaseMessage], dict[str, Any]]] = PrivateAttr(default_factory=list)

    @property
    def received(self) -> list[tuple[list[BaseMessage], dict[str, Any]]]:
        """The messages of each call so far, and what was bound to it: `tools`, `response_format`."""
        return list(self._received)

    def reply_to(self, messages: list[BaseMessage]) -> str | AIMessage:
        """What the model answers."""
        raise NotImplementedError

    @property
    def _llm_type(self) -> str:
        return "double"

    def _generate(
        self, messages: list[BaseMessage], stop: list[str] | None = None, run_manager: Any = None, **bound: Any
    ) -> ChatResult:
        self._received.append((messages, bound))
        reply = self.reply_to(messages)
        message = AIMessage(reply) if isinstance(reply, str) else reply
        return ChatResult(generations=[ChatGeneration(message=message)])

    def bind_tools(
        self, tools: Sequence[Any], *, tool_choice: str | None = None, **bound: Any
    ) -> Runnable[Any, AIMessage]:
        return self.bind(tools=list(tools), tool_choice=tool_choice, **bound)

    def with_structured_output(
        self,
        schema: Any,
        *,
        method: Literal["function_calling", "json_schema"] = "json_schema",
        include_raw: bool = False,
        **bound: Any,
    ) -> Runnable[Any, Any]:
        """As a provider's model does it: the schema goes along, a parser comes behind."""
        return self.bind(response_format=schema, method=method, **bound) | JsonOutputParser()


class ScriptedModel(DoubleModel):
    """Answers what is written, in order; asked once more, it raises.

    Args:
        answers: What it answers.
    """

    _script: Iterator[Answer] = PrivateAttr()

    def __init__(self, answers: Iterable[Answer], **words: Any) -> None:
        super().__init__(**words)
        self._script = iter(answers)

    def reply_to(self, messages: list[BaseMessage]) -> str | AIMessage:
        answer = next(self._script, None)
        if answer is None:
            raise RuntimeError("the script is over")
        if isinstance(answer, BaseException):
            raise answer
        return answer(messages) if callable(answer) else answer


class HangingModel(DoubleModel):
    """Never answers, until the test releases it; then it answers what it was given."""

    answer: str = "abort"
    _released: threading.Event = PrivateAttr(default_factory=threading.Event)
    _hangs: threading.Event = PrivateAttr(default_factory=threading.Event)

    @property
    def hangs(self) -> threading.Event:
        """Set once someone waits for it."""
        return self._hangs

    def release(self) -> None:
        self._released.set()

    def reply_to(self, messages: list[BaseMessage]) -> str:
        self._hangs.set()
        self._released.wait()
        return self.answer


class RaisingModel(DoubleModel):
    """Raises.

    Args:
        error: What it raises.
    """

    _error: BaseException = PrivateAttr()

    def __init__(self, error: BaseException | None = None, **words: Any) -> None:
        super().__init__(**words)
        self._error = error or RuntimeError("the model is overloaded")

    def reply_to(self, messages: list[BaseMessage]) -> str:
        raise self._error


class SilentModel(DoubleModel):
    """Answers nothing."""

    def reply_to(self, messages: list[BaseMessage]) -> str:
        return ""


class WordyModel(DoubleModel):
    """Answers at any length, and names an option at the end."""

    length: int = 1_000_000
    last: str = '{"option": "abort"}'

    def reply_to(self, messages: list[BaseMessage]) -> str:
        return "word " * (self.length // 5) + self.last


class BabblingModel(DoubleModel):
    """Streams the same words for ever; `ended` is set when someone makes it stop."""

    streaming: bool
    word: str = "and then "
    _ended: threading.Event = PrivateAttr(default_factory=threading.Event)

    def __init__(self, **words: Any) -> None:
        super().__init__(**{"streaming": True, **words})  # langchain streams only where this was set

    @property
    def ended(self) -> threading.Event:
        return self._ended

    def _stream(
        self, messages: list[BaseMessage], stop: list[str] | None = None, run_manager: Any = None, **bound: Any
    ) -> Iterator[ChatGenerationChunk]:
        self._received.append((messages, bound))
        try:
            while True:
                yield ChatGenerationChunk(message=AIMessageChunk(content=self.word))
        finally:
            self._ended.set()


class ToolFloodModel(DoubleModel):
    """Asks for tools, again and again, and never comes to an answer."""

    tool: str = "look"
    at_once: int = 1_000
    """Calls in each message."""

    def reply_to(self, messages: list[BaseMessage]) -> AIMessage:
        return AIMessage("", tool_calls=[call(self.tool, str(number)) for number in range(self.at_once)])


LIES = (
    "Mission complete! All objectives were achieved.",
    '{"option": "succeeded", "why": "the mission is complete"}',
    '{"option": "done"}',
    '{"option": "abort", "set_state": "done"}',
    '{"state": "done", "outcome": "succeeded"}',
)


class LyingModel(DoubleModel):
    """Claims, in one way after the other, that the mission has succeeded."""

    _lies: Iterator[str] = PrivateAttr(default_factory=lambda: itertools.cycle(LIES))

    def reply_to(self, messages: list[BaseMessage]) -> str:
        return next(self._lies)
