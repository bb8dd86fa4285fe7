# SPDX-License-Identifier: Apache-2.0
"""A chat model in a conversation: it answers in words, looks with tools, and may propose an order as data.

Rule: each request has a thread of its own, and what a model does costs that request alone. A proposal is passed on as
it came; whether it is one, and counts, the dialogue decides.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from langchain_core.language_models import BaseChatModel
from langchain_core.messages import BaseMessage
from langchain_core.tools import BaseTool

from rai_missions.agents.talk.prompt import forms, talk_messages
from rai_missions.answerers.model.chat import Absent, BudgetExceeded, Chat, ModelExit, ModelFault, ThreadChat
from rai_missions.answerers.model.output_modes import Mode, modes_of
from rai_missions.answerers.model.parse_reply import ModelReply
from rai_missions.answerers.model.pending import PendingQuestion
from rai_missions.answerers.model.tool_calls import look_up, shown
from rai_missions.connectors.worker import Worker
from rai_missions.conversation import AskModel, ModelText, StatusView
from rai_missions.embodiment.identity import Identity
from rai_missions.engine.decision import Limits, Question
from rai_missions.plain_data import json_object
from rai_missions.redaction import Redaction, cut, first_line

__all__ = ("LookTools", "OnModelText", "TalkModel")

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
        self._lock = threading.Lock()
        self._pending: dict[int, PendingQuestion] = {}
        self._threads: set[threading.Thread] = set()
        self._deadlines = Worker("conversation's deadlines")
        self._clean = Redaction().text

    def run(self) -> None:
        """Have the model get ready; returns at once."""
        self._deadlines.start()
        self._chat.open()

    def stop(self, within_s: float = 1.0) -> None:
        """Drop every request and end the model's process; a model in this process that hangs keeps its thread."""
        with self._lock:
            dropped, threads = list(self._pending.values()), list(self._threads)
            self._pending.clear()
        for pending in dropped:
            pending.close()
        self._deadlines.close(within_s)
        self._chat.close()
        ends = time.monotonic() + within_s
        for thread in (each for each in threads if each.ident is not None):  # one may be about to begin
            thread.join(max(0.0, ends - time.monotonic()))

    def drop(self, number: int) -> None:
        """The answer is waited for no longer."""
        with self._lock:
            pending = self._pending.pop(number, None)
        if pending is not None:
            pending.close()

    def ask(self, request: AskModel, view: Callable[[], StatusView], on_text: OnModelText) -> None:
        """Have a sentence answered; never waits.

        Args:
            request: The sentence, and what is known.
            view: The run as it is when a tool looks.
            on_text: Receives the answer, or why there is none.
        """
        seconds = max(0.5, request.until - request.at)
        question = Question(request.number, "conversation", "agent", request.text, (), budget=Limits(seconds=seconds))
        pending = PendingQuestion(question, lambda answer: on_text(_model_text(request.number, answer)))
        thread = threading.Thread(
            target=self._work, args=(request, view, pending), name=f"sentence {request.number}", daemon=True
        )
        with self._lock:
            busy = len(self._threads)
            if busy < MOST_AT_ONCE:
                self._threads.add(thread)
                self._pending[request.number] = pending
        if busy >= MOST_AT_ONCE:
            pending.reply({"failed": f"the model has not come back from {busy} earlier sentences"})
            return
        late = {"failed": f"no answer within {seconds:g} s"}
        pending.when_closed(self._deadlines.after(seconds, lambda: pending.reply(late)))
        thread.start()

    def _work(self, request: AskModel, view: Callable[[], StatusView], pending: PendingQuestion) -> None:
        try:
            answer = self._answer(request, view, pending)
        except (Absent, BudgetExceeded, ModelExit) as ended:
            answer = {"failed": cut(ended, 300)}
        except ModelFault as error:
            answer = {"failed": f"the model raised {error.kind}: {first_line(error.what)}"}
        except BaseException as error:  # noqa: BLE001 - even an exit that a package asks for is only a failed answer
            answer = {"failed": f"the model raised {type(error).__name__}: {first_line(error)}"}
        with self._lock:
            self._threads.discard(threading.current_thread())
            if self._pending.get(request.number) is pending:
                del self._pending[request.number]
        pending.reply(answer)

    def _answer(self, request: AskModel, view: Callable[[], StatusView], pending: PendingQuestion) -> dict[str, Any]:
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
        self, request: AskModel, pending: PendingQuestion, mode: Mode, tools: Mapping[str, BaseTool], *, images: bool
    ) -> dict[str, Any]:
        given = tools if mode == "tools" else {}
        exchange = self._chat.converse(mode, forms(request, given), pending)
        messages: Sequence[BaseMessage] = talk_messages(request, self._identity, mode, tuple(given))
        left = MOST_LOOKS
        for _ in range(MOST_CALLS):
            _check_open(pending)
            reply = exchange.ask(messages)
            if reply is None:
                return {"failed": "answered nothing"}
            reading = _read(reply, mode, request)
            if not reading.calls:
                return {"text": cut(self._clean(reading.text), MOST_TEXT), "order": reading.order}
            left -= len(reading.calls)
            if left < 0:
                raise BudgetExceeded(f"asked for more than the {MOST_LOOKS} calls of tools that a sentence has")
            looks = []
            for call in reading.calls:
                _check_open(pending)
                looks.append(look_up(given, call, self._clean))
            messages = [*(look.message for look in looks), *(shown(looks) if images else [])]
        raise BudgetExceeded(f"the budget of {MOST_CALLS} calls is spent")


def _check_open(pending: PendingQuestion) -> None:
    if not pending.open:
        raise BudgetExceeded("the answer is waited for no longer")


def _model_text(number: int, answer: Mapping[str, Any]) -> ModelText:
    order = answer.get("order")
    return ModelText(
        number, str(answer.get("text", "")), order if isinstance(order, Mapping) else None, is_end=True,
        failed=str(answer.get("failed", "")),
    )  # fmt: skip


def _read(reply: ModelReply, mode: Mode, request: AskModel) -> TalkReply:
    """A model's message: its words, what it proposes, what it wants to look up."""
    if mode == "json_schema":
        found = json_object(reply.text)
        return (
            TalkReply(reply.text)
            if found is None
            else TalkReply(_text(found.get("answer")), _order(found.get("order")))
        )
    answers = [call for call in reply.calls if call["name"] == "answer"]
    proposes = [call for call in reply.calls if call["name"] == "propose_order"]
    looks = tuple(call for call in reply.calls if call["name"] not in ("answer", "propose_order"))
    if looks and not answers and not proposes:
        return TalkReply(calls=looks)
    spoken = " ".join(_text(call["args"].get("text")) for call in answers) or (reply.text if not answers else "")
    order = _order(proposes[0]["args"].get("order")) if len(proposes) == 1 else None
    return TalkReply(spoken, order)


def _text(given: Any) -> str:
    return given if isinstance(given, str) else ""


def _order(given: Any) -> Mapping[str, Any] | None:
    return given if isinstance(given, Mapping) and given else None
