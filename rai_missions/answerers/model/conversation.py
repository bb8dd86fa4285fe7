# SPDX-License-Identifier: Apache-2.0
"""One question put to a chat model, within its budget: the modes tried, the tools it looks things up with, the reading.

Rule: a tool runs only if it is marked read-only and the question names it; no call is begun once the budget is spent.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Mapping, Sequence
from typing import Any, NamedTuple

from langchain_core.messages import BaseMessage
from langchain_core.tools import BaseTool

from rai_missions.answerers.model.chat import Abilities, BudgetExceeded, Chat, Conversation, ModelFault, check_open
from rai_missions.answerers.model.output_modes import OutputMode, form_of, modes_of
from rai_missions.answerers.model.parse_reply import ModelReply, ParsedReply, read
from rai_missions.answerers.model.pending import PendingQuestion
from rai_missions.answerers.model.prompt import messages_of
from rai_missions.answerers.model.tool_calls import ToolLookup, look_up, shown
from rai_missions.embodiment.identity import Identity
from rai_missions.redaction import cut

__all__ = ("ModelConfig", "ModelConversation")

LONGEST_NAME = 100


class ModelConfig(NamedTuple):
    """A model, and how it is asked."""

    chat: Chat
    mode: str
    """`auto`, or the one mode in which it is asked."""
    tools: Mapping[str, BaseTool]
    """The read-only tools there are, by name."""
    identity: Identity | None
    images: str
    """Whether it is shown pictures: `yes`, `no`, or `auto`: if it is known to take them."""
    clean: Callable[[str], str]
    """Takes secrets out of a text."""


class ModelConversation:
    """The work on one question.

    Args:
        pending: The question, and whether its answer is still waited for.
        config: Who thinks, and how it is asked.
        without: The modes that its server is known to refuse.
    """

    def __init__(self, pending: PendingQuestion, config: ModelConfig, without: Collection[OutputMode] = ()) -> None:
        self.pending, self.config, self.without = pending, config, without
        self.tools = {name: config.tools[name] for name in pending.question.tools if name in config.tools}
        self.calls = self.tokens_in = self.tokens_out = 0
        self.model_name = ""
        self.looked: list[Mapping[str, str]] = []
        """What was looked up, in order; it goes with the answer."""
        self.unfit: list[OutputMode] = []
        """The modes that the model's server refused."""

    def think(self) -> ParsedReply:
        """A choice, or why there is none.

        Raises:
            BudgetExceeded: The budget is spent, or the answer is waited for no longer.
            ModelFault: What the model or its provider's package raised, where no other mode is left.
            Absent: The model cannot be opened.
            ModelExit: Its process ended.
        """
        able = self.config.chat.abilities(self.pending)
        *firsts, last = self._modes(able)
        shows = self.config.images == "yes" or (self.config.images == "auto" and able.images)
        for mode in firsts:
            try:
                reading, called = self._converse(mode, images=shows)
            except ModelFault as error:
                if not error.unfit:
                    raise
                self.unfit.append(mode)
            else:
                if reading.choice or called or mode != "tools":
                    return reading
        return self._converse(last, images=shows)[0]

    def _modes(self, able: Abilities) -> tuple[OutputMode, ...]:
        modes = modes_of(schemas=able.schemas, tools=able.tools, wanted=self.config.mode, uses_tools=bool(self.tools))
        return tuple(mode for mode in modes if mode not in self.without) or modes

    def _converse(self, mode: OutputMode, *, images: bool) -> tuple[ParsedReply, bool]:
        """The reading of the last message in a mode, and whether the model called anything on the way."""
        question, called = self.pending.question, False
        tools = self.tools if mode == "tools" else {}
        conversation = self.config.chat.converse(mode, form_of(question, tools), self.pending)
        messages = messages_of(question, self.config.identity, mode=mode, images=images, tools=tuple(tools))
        while True:
            answer = self._ask(conversation, messages)
            if answer is None:
                return ParsedReply(failed="answered nothing"), called
            reading = read(answer, question, self.config.clean)
            called = called or bool(answer.calls or answer.broken)
            if not reading.calls:
                return reading, called
            left = question.budget.calls - self.calls
            if len(reading.calls) >= left:
                raise BudgetExceeded(
                    f"asked for {len(reading.calls)} calls of tools; {max(0, left - 1)} of the budget are left"
                )
            looks = [self._look_up(call) for call in reading.calls]
            messages = [*(look.message for look in looks), *(shown(looks) if images else [])]

    def _ask(self, conversation: Conversation, messages: Sequence[BaseMessage]) -> ModelReply | None:
        self._afford()
        self.calls += 1
        reply = conversation.ask(messages)
        if reply is not None:
            self.tokens_in += reply.tokens_in
            self.tokens_out += reply.tokens_out
            self.model_name = reply.model or self.model_name
        return reply

    def _afford(self) -> None:
        check_open(self.pending)
        budget = self.pending.question.budget
        if self.calls >= budget.calls:
            raise BudgetExceeded(f"the budget of {budget.calls} calls is spent")
        if self.tokens_in + self.tokens_out >= budget.tokens:
            raise BudgetExceeded(f"the budget of {budget.tokens} tokens is spent")

    def usage(self) -> dict[str, Any]:
        """What was used so far."""
        return {
            "calls": self.calls,
            "tokens_in": self.tokens_in,
            "tokens_out": self.tokens_out,
            "seconds": round(self.pending.taken_s, 3),
            "model": cut(self.model_name or self.config.chat.name, LONGEST_NAME),
        }

    def _look_up(self, call: Mapping[str, Any]) -> ToolLookup:
        """What a tool returns; one that is not here costs nothing."""
        if cut(call["name"], LONGEST_NAME) in self.tools:
            self._afford()
            self.calls += 1
        looked = look_up(self.tools, call, self.config.clean)
        self.looked.append(looked.note)
        return looked
