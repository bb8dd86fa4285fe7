# SPDX-License-Identifier: Apache-2.0
"""A chat model of a campaign: what it wrote is kept, and what kept it from being asked is noted where it happens.

Rule: the time in which a model is opened is no part of any answer's time.
"""

from __future__ import annotations

import json
import threading
from collections.abc import Callable, Sequence
from typing import Any, TypeVar

from rai_missions.answerers.model.chat import (
    Abilities,
    Absent,
    BudgetExceeded,
    Chat,
    Conversation,
    ModelExit,
    ModelFault,
)
from rai_missions.answerers.model.output_modes import AnswerForm, OutputMode
from rai_missions.answerers.model.parse_reply import ModelReply
from rai_missions.answerers.model.pending import PendingQuestion
from rai_missions.engine.decision import Question

__all__ = ("WatchedChat",)

T = TypeVar("T")

OPENS_S = 180.0
"""How long a model may take to be opened."""


class WatchedChat:
    """A chat model that notes what it wrote and what kept it from being asked.

    Args:
        chat: The model.
        opens_s: How long it may take to be opened, wall time.
    """

    def __init__(self, chat: Chat, opens_s: float = OPENS_S) -> None:
        self._chat, self._opens_s = chat, opens_s
        self._absent = ""
        self.raised = ""
        """The type of what was raised last; empty after a reply."""
        self.after_s = 0.0
        """Seconds after which the provider wants to be asked again, where it reported that; else 0."""
        self.texts: list[str] = []

    def forget(self) -> None:
        """Begin the notes again, for another question."""
        self.raised, self.after_s, self.texts = "", 0.0, []

    @property
    def name(self) -> str:
        return self._chat.name

    def open(self) -> None:
        self._chat.open()

    def close(self) -> None:
        self._chat.close()

    def wait_until_open(self, question: Question) -> str:
        """Wait until the model can be asked; its process may be new, or replaced since the last question.

        Args:
            question: What it is to be asked.

        Returns:
            Why it cannot be asked; empty where it can.
        """
        if self._absent:
            self.raised = Absent.__name__
            return self._absent
        pending = PendingQuestion(question._replace(until=question.at), lambda _: None)
        timer = threading.Timer(self._opens_s, pending.close)
        timer.daemon = True
        timer.start()
        try:
            self.noting(lambda: self._chat.abilities(pending))
        except (Absent, ModelExit) as gone:
            return str(gone)
        except BudgetExceeded:  # of this worker, it will not be asked again
            self.raised, self._absent = Absent.__name__, f"the model was not opened within {self._opens_s:g} s"
            return self._absent
        finally:
            timer.cancel()
        return ""

    def abilities(self, pending: PendingQuestion) -> Abilities:
        return self.noting(lambda: self._chat.abilities(pending))

    def converse(self, mode: OutputMode, form: AnswerForm, pending: PendingQuestion) -> Conversation:
        return WatchedConversation(self, self.noting(lambda: self._chat.converse(mode, form, pending)))

    def noting(self, do: Callable[[], T]) -> T:
        """Do something, and note the type of what it raises, where the model was not asked because of it."""
        try:
            return do()
        except ModelFault as raised:
            self.raised, self.after_s = raised.kind, raised.after_s
            raise
        except (Absent, ModelExit) as gone:
            self.raised = type(gone).__name__
            raise


class WatchedConversation:
    """One question put to a `WatchedChat`."""

    def __init__(self, chat: WatchedChat, conversation: Conversation) -> None:
        self._chat, self._conversation = chat, conversation

    def ask(self, messages: Sequence[Any]) -> ModelReply | None:
        reply = self._chat.noting(lambda: self._conversation.ask(messages))
        self._chat.raised = ""
        if reply is not None:
            self._chat.texts.append(reply.text or json.dumps(list(reply.calls), default=str))
        return reply
