# SPDX-License-Identifier: Apache-2.0
"""One question put to a chat model, within its budget: the modes tried, the tools it looks things up with, the reading.

Rule: a tool runs only if it is marked read-only and the question names it; no call is begun once the budget is spent.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping
from typing import Any, NamedTuple

from langchain_core.callbacks import BaseCallbackHandler
from langchain_core.language_models import BaseChatModel
from langchain_core.messages import AIMessage, BaseMessage
from langchain_core.tools import BaseTool

from rai_missions.agents.lookup import Looked, look_up, shown
from rai_missions.agents.modes import Bound, Mode, bound, modes_of
from rai_missions.agents.pending import Pending
from rai_missions.agents.prompt import messages_of
from rai_missions.agents.reading import LONGEST, Reading, read
from rai_missions.cut import cut
from rai_missions.embodiment.identity import Identity

__all__ = ("Manner", "Spent", "Thought")

UNFIT = frozenset({400, 415, 422, 500, 501})
"""HTTP statuses by which servers refuse a form of answer that they do not know; the next mode may do."""


class Spent(BaseException):
    """The budget is spent, or nobody waits any more; the text says which.

    No `Exception`, so that nothing on the way out of a provider's package logs it or takes it for a fault.
    """


class Watch(BaseCallbackHandler):
    """Ends a stream that nobody waits for any more, or that says too much."""

    def __init__(self, pending: Pending) -> None:
        self.pending, self.heard = pending, 0

    def on_llm_new_token(self, token: Any, **_: Any) -> None:
        self.heard += len(token) if isinstance(token, str) else 1
        if not self.pending.open:
            raise Spent("nobody waits for the answer any more")
        if self.heard > LONGEST:
            raise Spent(f"answered with more than {LONGEST} characters")


class Manner(NamedTuple):
    """A model, and how it is asked."""

    model: BaseChatModel
    mode: str
    """`auto`, or the one mode in which it is asked."""
    tools: Mapping[str, BaseTool]
    """The read-only tools there are, by name."""
    identity: Identity | None
    images: bool
    """Whether it is shown pictures."""
    clean: Callable[[str], str]
    """Takes secrets out of a text."""


class Thought:
    """The work on one question.

    Args:
        pending: The question, and whether anybody still waits.
        manner: Who thinks, and how it is asked.
        without: The modes that its server is known to refuse.
    """

    def __init__(self, pending: Pending, manner: Manner, without: Collection[Mode] = ()) -> None:
        self.pending, self.manner, self.without = pending, manner, without
        self.tools = {name: manner.tools[name] for name in pending.question.tools if name in manner.tools}
        self.calls = self.tokens_in = self.tokens_out = 0
        self.model_name = ""
        self.looked: list[Mapping[str, str]] = []
        """What was looked up, in order; it goes with the answer."""
        self.unfit: list[Mode] = []
        """The modes that the model's server refused."""

    def think(self) -> Reading:
        """A wish, or why there is none.

        Raises:
            Spent: The budget is spent, or nobody waits any more.
            Exception: Whatever the model or its provider's package raises, where no other mode is left.
        """
        *firsts, last = self._modes()
        for mode in firsts:
            try:
                reading, called = self._converse(mode)
            except Exception as error:
                if not _is_unfit(error):
                    raise
                self.unfit.append(mode)
            else:
                if reading.wish or called or mode != "tools":
                    return reading
        return self._converse(last)[0]

    def _modes(self) -> tuple[Mode, ...]:
        modes = modes_of(self.manner.model, self.manner.mode, uses_tools=bool(self.tools))
        return tuple(mode for mode in modes if mode not in self.without) or modes

    def _converse(self, mode: Mode) -> tuple[Reading, bool]:
        """The reading of the last message in a mode, and whether the model called anything on the way."""
        question, called = self.pending.question, False
        tools = self.tools if mode == "tools" else {}
        chain = bound(self.manner.model, mode, question, tools)
        messages = messages_of(question, self.manner.identity, mode=mode, images=self.manner.images, tools=tuple(tools))
        while True:
            message = self._invoke(chain, messages)
            if message is None:
                return Reading(failed="answered nothing"), called
            reading = read(message, question, self.manner.clean)
            called = called or bool(message.tool_calls or message.invalid_tool_calls)
            if not reading.calls:
                return reading, called
            left = question.budget.calls - self.calls
            if len(reading.calls) >= left:
                raise Spent(f"asked for {len(reading.calls)} calls of tools; {max(0, left - 1)} of the budget are left")
            looks = [self._look_up(call) for call in reading.calls]
            pictures = shown(looks) if self.manner.images else []
            messages = [*messages, message, *(look.message for look in looks), *pictures]

    def _invoke(self, chain: Bound, messages: list[BaseMessage]) -> AIMessage | None:
        self._afford()
        self.calls += 1
        said = chain.invoke(messages, config={"callbacks": [Watch(self.pending)]})
        if not isinstance(said, AIMessage):
            return None
        self._count(said)
        return said

    def _afford(self) -> None:
        budget = self.pending.question.budget
        if not self.pending.open:
            raise Spent("nobody waits for the answer any more")
        if self.calls >= budget.calls:
            raise Spent(f"the budget of {budget.calls} calls is spent")
        if self.tokens_in + self.tokens_out >= budget.tokens:
            raise Spent(f"the budget of {budget.tokens} tokens is spent")

    def _count(self, message: AIMessage) -> None:
        used: Mapping[str, Any] = message.usage_metadata or {}
        self.tokens_in += max(0, used.get("input_tokens", 0))
        self.tokens_out += max(0, used.get("output_tokens", 0))
        name = message.response_metadata.get("model_name") or message.response_metadata.get("model")
        if isinstance(name, str) and not name.startswith("/"):  # a local server may tell the path of a file
            self.model_name = name

    def usage(self) -> dict[str, Any]:
        """What was used so far."""
        return {
            "calls": self.calls,
            "tokens_in": self.tokens_in,
            "tokens_out": self.tokens_out,
            "seconds": round(self.pending.taken_s, 3),
            "model": cut(self.model_name or _name_of(self.manner.model), 100),
        }

    def _look_up(self, call: Mapping[str, Any]) -> Looked:
        """What a tool says; one that is not here costs nothing."""
        if cut(call["name"], 100) in self.tools:
            self._afford()
            self.calls += 1
        looked = look_up(self.tools, call, self.manner.clean)
        self.looked.append(looked.note)
        return looked


def _name_of(model: BaseChatModel) -> str:
    """What a model is called; its class's name where it has none, or none that can be told."""
    try:
        return str(getattr(model, "model_name", None) or getattr(model, "model", None) or type(model).__name__)
    except Exception:  # noqa: BLE001 - a question must be given up in time, whatever a model's package does
        return type(model).__name__


def _is_unfit(error: Exception) -> bool:
    """Whether an exception says that the model cannot be asked in this way, rather than that it failed."""
    return isinstance(error, NotImplementedError) or getattr(error, "status_code", None) in UNFIT
