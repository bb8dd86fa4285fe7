# SPDX-License-Identifier: Apache-2.0
"""A chat model in a conversation: it answers in words, looks with tools, and may propose an order as data.

Rule: each request has a thread of its own, and what a model does costs that request alone. A proposal is passed on as
it came; whether it is one, and counts, the dialogue decides.
"""

from __future__ import annotations

import logging
from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

from langchain_core.language_models import BaseChatModel
from langchain_core.messages import BaseMessage
from langchain_core.tools import BaseTool

from rai_missions.agents.talk.prompt import forms, talk_messages
from rai_missions.answerers.model.chat import (
    BudgetExceeded,
    Chat,
    ModelFault,
    ThreadChat,
    check_open,
    why_failed,
)
from rai_missions.answerers.model.output_modes import OutputMode, modes_of
from rai_missions.answerers.model.parse_reply import ModelReply
from rai_missions.answerers.model.pending import PendingQuestion, QuestionThreads
from rai_missions.answerers.model.tool_calls import look_up, shown
from rai_missions.conversation import AskModel, ModelText, StatusView
from rai_missions.embodiment.identity import Identity
from rai_missions.engine.decision import Limits, Question
from rai_missions.plain_data import json_object
from rai_missions.redaction import Redaction, cut

__all__ = ("LookTools", "OnModelText", "TalkModel")

log = logging.getLogger(__name__)

OnModelText = Callable[[ModelText], None]
"""Receives the model's text, from any thread; the last one has `is_end`."""
LookTools = Callable[[Callable[[], StatusView]], Sequence[BaseTool]]
"""The tools that only look, for one request; they read the run by the view that is given."""
MOST_CALLS = 6
"""Calls of the model for one sentence."""
MOST_LOOKS = 12
"""Calls of tools for one sentence."""
MOST_AT_ONCE = 3
MOST_TEXT = 4_000
"""Characters of an answer that are passed on."""


class TalkReply(NamedTuple):
    """What one message of a model holds."""

    text: str = ""
    order: Mapping[str, Any] | None = None
    calls: tuple[Mapping[str, Any], ...] = ()


class TalkModel:
    """A model that takes part in a conversation.

    Args:
        model: A model of langchain's, asked on a thread, or a `ModelProcess`.
        identity: Who it is, as an embodied being.
        tools: What it may look things up with.
    """

    def __init__(
        self, model: BaseChatModel | Chat, *, identity: Identity | None = None, tools: LookTools = lambda view: ()
    ) -> None:
        self._chat: Chat = ThreadChat(model) if isinstance(model, BaseChatModel) else model
        self._identity, self._tools = identity, tools
        self._sentences = QuestionThreads("sentence", MOST_AT_ONCE)
        self._redaction = Redaction()

    def run(self) -> None:
        """Have the model get ready; returns at once."""
        self._chat.open()

    def stop(self, within_s: float = 1.0) -> None:
        """Drop every request and end the model's process; a model in this process that hangs keeps its thread."""
        self._sentences.stop(within_s, self._chat.close)

    def drop(self, number: int) -> None:
        """The answer is waited for no longer."""
        self._sentences.drop(number)

    def ask(self, request: AskModel, view: Callable[[], StatusView], on_text: OnModelText) -> None:
        """Have a sentence answered; never waits.

        Args:
            request: The sentence, and what is known.
            view: The run as it is when a tool looks.
            on_text: Receives the answer, or why there is none.
        """
        seconds = max(0.5, request.until - request.at)
        question = Question(request.number, "conversation", "agent", request.text, (), budget=Limits(seconds=seconds))

        def receive(answer: Mapping[str, Any]) -> None:
            if why := answer.get("failed"):
                log.warning("the model gave no reply: %s", cut(why, 300))
            on_text(_model_text(request.number, answer))

        pending = PendingQuestion(question, receive)
        late = {"failed": f"no answer within {seconds:g} s"}
        answer_of = partial(self._answer, request, view, pending)
        self._sentences.begin(pending, answer_of, lambda: pending.reply(late), waits=True)

    def _answer(self, request: AskModel, view: Callable[[], StatusView], pending: PendingQuestion) -> dict[str, Any]:
        try:
            return self._tried(request, view, pending)
        except BaseException as error:  # noqa: BLE001 - whatever a package raises is only a failed answer
            return {"failed": cut(why_failed(error), 300)}

    def _tried(self, request: AskModel, view: Callable[[], StatusView], pending: PendingQuestion) -> dict[str, Any]:
        """The answer in the first mode that fits the model."""
        able = self._chat.abilities(pending)
        tools = {tool.name: tool for tool in self._tools(view)}
        *firsts, last = modes_of(schemas=able.schemas, tools=able.tools, wanted="auto", uses_tools=bool(tools))
        for mode in firsts:
            try:
                return self._converse(request, pending, mode, tools, images=able.images)
            except ModelFault as error:
                if not error.unfit:
                    raise
        return self._converse(request, pending, last, tools, images=able.images)

    def _converse(
        self,
        request: AskModel,
        pending: PendingQuestion,
        mode: OutputMode,
        tools: Mapping[str, BaseTool],
        *,
        images: bool,
    ) -> dict[str, Any]:
        given = tools if mode == "tools" else {}
        exchange = self._chat.converse(mode, forms(request, given), pending)
        messages: Sequence[BaseMessage] = talk_messages(request, self._identity, mode, tuple(given))
        left = MOST_LOOKS
        for _ in range(MOST_CALLS):
            check_open(pending)
            reply = exchange.ask(messages)
            if reply is None:
                return {"failed": "answered nothing"}
            reading = _read(reply, mode, request)
            if not reading.calls:
                order = self._redaction.json(reading.order)
                return {"text": cut(reading.text, MOST_TEXT), "order": order}
            left -= len(reading.calls)
            if left < 0:
                raise BudgetExceeded(f"asked for more than the {MOST_LOOKS} calls of tools that a sentence has")
            looks = []
            for call in reading.calls:
                check_open(pending)
                looks.append(look_up(given, call, self._redaction.text))
            messages = [*(look.message for look in looks), *(shown(looks) if images else [])]
        raise BudgetExceeded(f"the budget of {MOST_CALLS} calls is spent")


def _model_text(number: int, answer: Mapping[str, Any]) -> ModelText:
    order = answer.get("order")
    return ModelText(
        number,
        str(answer.get("text", "")),
        order if isinstance(order, Mapping) else None,
        is_end=True,
        failed=str(answer.get("failed", "")),
    )


def _read(reply: ModelReply, mode: OutputMode, request: AskModel) -> TalkReply:
    """A model's message: its words, what it proposes, what it wants to look up."""
    if mode == "json_schema":
        found = json_object(reply.text)
        if found is None:
            return TalkReply(reply.text)
        return TalkReply(_text(found.get("answer")), _order(found.get("order")))
    answers = [call for call in reply.calls if call["name"] == "answer"]
    proposes = [call for call in reply.calls if call["name"] == "propose_order"]
    looks = tuple(call for call in reply.calls if call["name"] not in ("answer", "propose_order"))
    if looks and not answers and not proposes:
        return TalkReply(calls=looks)
    spoken = " ".join(_text(_given(call, "text")) for call in answers) or (reply.text if not answers else "")
    order = _order(_given(proposes[0], "order")) if len(proposes) == 1 else None
    return TalkReply(spoken, order)


def _given(call: Mapping[str, Any], name: str) -> Any:
    """An argument of a call; None where there is none, or the arguments are none that are read."""
    return (call["args"] or {}).get(name)


def _text(given: Any) -> str:
    return given if isinstance(given, str) else ""


def _order(given: Any) -> Mapping[str, Any] | None:
    return given if isinstance(given, Mapping) and given else None
