# SPDX-License-Identifier: Apache-2.0
"""A chat model as an answerer: it may choose an option, and that is all.

Rule: whatever the model does – raise, hang, babble, flood – its question is answered once, in time, and the next one
is taken.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, Literal, get_args

from langchain_core.language_models import BaseChatModel
from langchain_core.tools import BaseTool

from rai_missions.answerers.model.chat import Absent, Chat, ThreadChat, why_failed
from rai_missions.answerers.model.conversation import ModelConfig, ModelConversation
from rai_missions.answerers.model.output_modes import OutputMode
from rai_missions.answerers.model.parse_reply import ParsedReply
from rai_missions.answerers.model.pending import PendingQuestion, QuestionThreads
from rai_missions.answerers.model.secrets import secrets_of
from rai_missions.embodiment.identity import Identity
from rai_missions.engine.decision import Question
from rai_missions.errors import UsageError, suggestion
from rai_missions.redaction import Redaction, cut, shown
from rai_missions.tools.tool import is_read_only

__all__ = ("DecisionAgent",)

LONGEST_WHY = 300


class DecisionAgent:
    """Asks a langchain chat model, each question on a thread of its own.

    Args:
        model: Who is asked: a model of langchain's, asked on that thread, or a `ModelProcess`.
        identity: Who the model is, as an embodied being; shown with each question.
        tools: What it may look things up with, where a question names it; each is marked as one that only looks.
        mode: How it is asked: by a JSON Schema, by one function an option, in plain text; `auto` finds out.
        images: Whether it is shown pictures; `auto`: if its profile lists them.
        at_once: How many questions may be in work; one that hangs counts until it comes back.
        longest_s: Wall time for one question, where neither it nor its budget sets one.

    Raises:
        UsageError: It is no model, no such mode, or a tool that is not marked read-only.
    """

    def __init__(
        self,
        model: BaseChatModel | Chat,
        identity: Identity | None = None,
        tools: Sequence[BaseTool] = (),
        *,
        mode: Literal["auto", "json_schema", "tools", "text"] = "auto",
        images: Literal["auto", "yes", "no"] = "auto",
        at_once: int = 4,
        longest_s: float = 300.0,
    ) -> None:
        for given, known, what in (
            (mode, ("auto", *get_args(OutputMode)), "mode"),
            (images, ("auto", "yes", "no"), "images"),
        ):
            if given not in known:
                raise UsageError(f"{what} '{given}' does not exist{suggestion(given, known)}")
        for tool in tools:
            if not is_read_only(tool):
                marks = 'metadata={"read_only": True}'
                raise UsageError(
                    f"the tool '{tool.name}' is not marked as one that only looks ({marks}): a decision takes no other"
                )
        given_model: object = model
        if not isinstance(given_model, BaseChatModel | Chat):
            named = "in agents.run and RunConfig also a name, 'openai:gpt-4o'"
            raise UsageError(f"a model is a chat model of langchain, {named}; not {shown(model)}")
        own = isinstance(model, BaseChatModel)
        self._redaction = Redaction(secrets_of(model) if own else ())
        self._chat: Chat = ThreadChat(model) if isinstance(model, BaseChatModel) else model
        self._config = ModelConfig(
            self._chat,
            mode,
            {tool.name: tool for tool in tools},
            identity,
            images,
            self._redaction.text,
        )
        self._longest_s = longest_s
        self._unfit: set[OutputMode] = set()
        self._questions = QuestionThreads("question", at_once)

    def run(self) -> None:
        """Have the model get ready; a question finds its own thread, whether this was called or not."""
        self._chat.open()

    def stop(self, within_s: float = 1.0) -> None:
        """Drop every question, end the model's process and wait for the threads, so long at most.

        A model given as a Python object that hangs keeps its thread, which does not hold up the program's end.
        """
        self._questions.stop(within_s, self._chat.close)

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Think about a question on a thread of its own."""
        pending = PendingQuestion(question, answer, longest_s=self._longest_s)
        conversation = ModelConversation(pending, self._config, frozenset(self._unfit))
        answer_of, give_up = partial(self._answer, conversation), partial(self._give_up, conversation)
        if busy := self._questions.begin(pending, answer_of, give_up):
            pending.reply({"absent": f"the model has not come back from {busy} earlier questions"})

    def withdraw(self, number: int) -> None:
        """The question is no longer asked; what comes back is dropped."""
        self._questions.drop(number)

    def _answer(self, conversation: ModelConversation) -> dict[str, Any]:
        try:
            reply = conversation.think()
        except Absent as absent:
            return self._journaled(conversation, {"absent": cut(absent, LONGEST_WHY)})
        except BaseException as error:  # noqa: BLE001 - whatever a package raises is only a failed answer
            reply = ParsedReply(failed=why_failed(error))
        if reply.choice:
            self._unfit.update(conversation.unfit)
            return self._journaled(conversation, reply.choice)
        return self._journaled(conversation, {"failed": cut(reply.failed, LONGEST_WHY)})

    def _give_up(self, conversation: ModelConversation) -> None:
        pending = conversation.pending
        pending.reply(self._journaled(conversation, {"failed": f"no answer within {pending.taken_s:.1f} s"}))

    def _journaled(self, conversation: ModelConversation, answer: Mapping[str, Any]) -> dict[str, Any]:
        looked = {"looked": list(conversation.looked)} if conversation.looked else {}
        cleaned: dict[str, Any] = self._redaction.json({**answer, **looked, "usage": conversation.usage()})
        return cleaned
