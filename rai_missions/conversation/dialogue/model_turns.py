# SPDX-License-Identifier: Apache-2.0
"""The model's turns: which sentence it answers, which wait, and what becomes of those that come meanwhile.

Rule: nothing else waits for a model: rules answer at once, and a model that hangs costs its own reply.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from rai_missions.conversation.inputs import Utterance
from rai_missions.conversation.sentences import SentenceStream
from rai_missions.conversation.settings import Settings

__all__ = ("ModelTurn", "ModelTurns")

MOST_SENTENCES = 12
"""Sentences of one reply; what follows is dropped."""
MOST_RECEIVED = 4_000
"""Characters, and pieces, of one reply that are read: a stream of blank lines has no sentences."""


class ModelTurn(NamedTuple):
    """A reply that is expected."""

    number: int
    """Of the `AskModel`."""
    utterance: Utterance
    """The sentence that it answers."""
    until: float
    stream: SentenceStream = SentenceStream()
    received: int = 0
    """Characters that came, each piece as one at least."""
    spoken: int = 0
    """Sentences that went out or were replaced."""
    is_replaced: bool = False
    """The status was put in the place of a claim already."""
    before: str = ""
    """What went out last of this reply or the one before, with what it continued: a claim may be spread over them."""
    has_order: bool = False

    @property
    def is_full(self) -> bool:
        return self.spoken >= MOST_SENTENCES or self.received >= MOST_RECEIVED


class ModelTurns:
    """The reply that is expected, and the sentences that wait.

    Args:
        settings: The policy for sentences that come while the model answers.
    """

    def __init__(self, settings: Settings) -> None:
        self._settings = settings
        self._number = 0
        self._before = ""
        self.turn: ModelTurn | None = None
        self.waiting: deque[Utterance] = deque()

    def begin(self, utterance: Utterance, at: float) -> ModelTurn:
        """A request begins."""
        self._number += 1
        self.turn = ModelTurn(self._number, utterance, at + self._settings.model_s, before=self._before)
        return self.turn

    def keep(self, turn: ModelTurn | None) -> None:
        """How far the reply is; None: none is expected any more."""
        latest = turn or self.turn
        self._before = latest.before if latest is not None else self._before
        self.turn = turn

    def late(self, utterance: Utterance) -> tuple[bool, list[Utterance]]:
        """A sentence that comes while the model answers.

        Returns:
            Whether the present reply is to be dropped for it, and the sentences that are dropped.
        """
        if self._settings.late == "interrupt":
            dropped = [*([self.turn.utterance] if self.turn else []), *self.waiting]
            self.waiting = deque([utterance])
            return True, dropped
        if self._settings.late == "last":
            dropped, self.waiting = list(self.waiting), deque([utterance])
            return False, dropped
        if len(self.waiting) >= self._settings.most_late:
            return False, [utterance]
        self.waiting.append(utterance)
        return False, []

    def take(self, number: int) -> ModelTurn | None:
        """The reply of this number, if it is the one that is expected."""
        return self.turn if self.turn is not None and self.turn.number == number else None
