# SPDX-License-Identifier: Apache-2.0
"""What a decision needs of a chat model, wherever the model lives: on a thread of this process, or in one of its own.

Rule: whatever a model raises comes out as `ModelFault`; of its replies, no more than is read.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Mapping, Sequence
from email.utils import parsedate_to_datetime
from typing import Any, NamedTuple, Protocol, runtime_checkable

from langchain_core.callbacks import BaseCallbackHandler
from langchain_core.language_models import BaseChatModel
from langchain_core.messages import AIMessage, BaseMessage

from rai_missions.answerers.model.foreign_server import address_of, foreign_reply
from rai_missions.answerers.model.output_modes import (
    AnswerForm,
    OutputMode,
    bound,
    calls_tools,
    fills_schemas,
    takes_images,
)
from rai_missions.answerers.model.parse_reply import LONGEST, ModelReply, excess, reply_of
from rai_missions.answerers.model.pending import PendingQuestion
from rai_missions.redaction import first_line

__all__ = (
    "UNWANTED",
    "Abilities",
    "Absent",
    "BudgetExceeded",
    "Chat",
    "Conversation",
    "ModelExit",
    "ModelFault",
    "ThreadChat",
    "check_open",
    "name_of",
    "why_failed",
)

UNFIT = frozenset({400, 415, 422, 500, 501})
"""HTTP statuses by which servers refuse a form of answer that they do not know; the next mode may do."""


UNWANTED = "the answer is waited for no longer"
"""Why a model is not asked further, once its question is closed."""


class BudgetExceeded(BaseException):
    """The budget is spent, or the answer is waited for no longer; the text names it.

    No `Exception`, so that nothing on the way out of a provider's package logs it or takes it for a fault.
    """


class ModelFault(Exception):
    """The model, or its provider's package, raised.

    Args:
        kind: The exception's type.
        what: The exception, or its text.
        unfit: The model cannot be asked in this way, rather than that it failed.
        after_s: Seconds after which its server is to be asked again, by the server's own word; 0: it gave none.
    """

    def __init__(self, kind: str, what: object, *, unfit: bool, after_s: float = 0.0) -> None:
        super().__init__(kind)
        self.kind, self.what, self.unfit, self.after_s = kind, what, unfit, after_s

    @classmethod
    def by(cls, error: BaseException, address: str = "") -> ModelFault:
        """What an exception is to whatever asked; where the model has a server, `address` is its URL."""
        unfit = isinstance(error, NotImplementedError) or getattr(error, "status_code", None) in UNFIT
        if why := foreign_reply(error, address):
            return cls("ForeignServer", why, unfit=unfit)
        return cls(type(error).__name__, error, unfit=unfit, after_s=_after_s(error))


def _after_s(error: BaseException) -> float:
    """What the header `Retry-After` of a server's refusal asks for (RFC 9110, 10.2.3), in seconds from now; else 0."""
    headers = getattr(getattr(error, "response", None), "headers", None)
    text = headers.get("retry-after") if isinstance(headers, Mapping) else None
    if not isinstance(text, str):
        return 0.0
    try:
        seconds = float(text)
    except ValueError:
        try:
            seconds = parsedate_to_datetime(text).timestamp() - time.time()
        except (ValueError, OverflowError):
            return 0.0
    return seconds if 0 < seconds < math.inf else 0.0


class Absent(Exception):
    """There is no model to be asked; the text states why."""


class ModelExit(Exception):
    """The model's process ended while it was asked; the text states how."""


class Abilities(NamedTuple):
    """What a model can do."""

    schemas: bool
    """Its output can be held to a JSON Schema."""
    tools: bool
    """It can be bound to tools."""
    images: bool
    """It is known to take pictures."""
    name: str
    """What it is called."""

    @classmethod
    def of(cls, model: BaseChatModel) -> Abilities:
        """What a model in this process can do."""
        return cls(fills_schemas(model), calls_tools(model), takes_images(model), name_of(model))


class Conversation(Protocol):
    """One question put to a model, with what it looks up on the way; it remembers the model's replies."""

    def ask(self, messages: Sequence[BaseMessage]) -> ModelReply | None:
        """The model's answer to these messages; None where it gave none.

        Raises:
            ModelFault: The model raised.
            ModelExit: Its process ended.
            BudgetExceeded: The answer is waited for no longer, or it is longer than what is read.
        """


@runtime_checkable
class Chat(Protocol):
    """A chat model that can be asked."""

    @property
    def name(self) -> str:
        """What it is called, for the journal."""

    def open(self) -> None:
        """Get ready to be asked; never waits. A model that was not opened is opened by the first question."""

    def abilities(self, pending: PendingQuestion) -> Abilities:
        """What it can do; may wait for it until the question is closed.

        Raises:
            Absent: It cannot be opened.
            ModelExit: Its process ended.
            BudgetExceeded: The question was closed before it was known.
        """

    def converse(self, mode: OutputMode, form: AnswerForm, pending: PendingQuestion) -> Conversation:
        """Begin to ask it, in a mode in which it can be asked."""

    def close(self) -> None:
        """Free what it holds, within a second or so; it may be opened again."""


class ThreadChat:
    """A model given as a Python object: asked on the thread of whatever asks.

    Nothing is promised of a model that holds the interpreter's lock, crashes, or hangs beyond the program's end.
    """

    def __init__(self, model: BaseChatModel) -> None:
        self._model = model

    @property
    def name(self) -> str:
        return name_of(self._model)

    def open(self) -> None:
        """The model is there already: nothing has to be opened."""

    def abilities(self, pending: PendingQuestion) -> Abilities:
        return Abilities.of(self._model)

    def converse(self, mode: OutputMode, form: AnswerForm, pending: PendingQuestion) -> Conversation:
        try:
            return ThreadConversation(self._model, mode, form, lambda: pending.open)
        except Exception as error:
            raise ModelFault.by(error) from error

    def close(self) -> None:
        """Nothing is held."""


class ThreadConversation:
    """A conversation with a model in this process.

    Args:
        model: Who is asked.
        mode: How.
        form: What it may answer.
        is_open: Whether the answer is still waited for.
    """

    def __init__(self, model: BaseChatModel, mode: OutputMode, form: AnswerForm, is_open: Callable[[], bool]) -> None:
        self._chain, self._address = bound(model, mode, form), address_of(model)
        self._is_open = is_open
        self._messages: list[BaseMessage] = []

    def ask(self, messages: Sequence[BaseMessage]) -> ModelReply | None:
        self._messages += messages
        try:
            answer = self._chain.invoke(list(self._messages), config={"callbacks": [StreamWatch(self._is_open)]})
        except BudgetExceeded:
            raise
        except BaseException as error:  # even an exit that a model asks for is only a failed answer
            raise ModelFault.by(error, self._address) from error
        if not isinstance(answer, AIMessage):
            return None
        reply = reply_of(answer)
        if why := excess(reply):
            raise BudgetExceeded(why)
        self._messages.append(answer)
        return reply


class StreamWatch(BaseCallbackHandler):
    """Ends a stream that is waited for no longer, or that is too long."""

    def __init__(self, is_open: Callable[[], bool]) -> None:
        self.is_open, self.length = is_open, 0

    def on_llm_new_token(self, token: Any, **_: Any) -> None:
        self.length += len(token) if isinstance(token, str) else 1
        if not self.is_open():
            raise BudgetExceeded(UNWANTED)
        if self.length > LONGEST:
            raise BudgetExceeded(f"answered with more than {LONGEST} characters")


def check_open(pending: PendingQuestion) -> None:
    """Ask a model further only while someone waits for the answer.

    Raises:
        BudgetExceeded: No one does.
    """
    if not pending.open:
        raise BudgetExceeded(UNWANTED)


def why_failed(error: BaseException) -> str:
    """Why a model gave no answer, whatever ended it, even an exit that a package asks for."""
    if isinstance(error, Absent | BudgetExceeded | ModelExit):
        return str(error)
    fault = error if isinstance(error, ModelFault) else ModelFault.by(error)
    return f"the model raised {fault.kind}: {first_line(fault.what)}"


def name_of(model: BaseChatModel) -> str:
    """What a model is called; its class's name where it has none, or none that can be printed."""
    try:
        return str(getattr(model, "model_name", None) or getattr(model, "model", None) or type(model).__name__)
    except Exception:  # noqa: BLE001 - a question must be given up in time, whatever a model's package does
        return type(model).__name__
