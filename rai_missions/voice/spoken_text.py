# SPDX-License-Identifier: Apache-2.0
"""What is to be spoken, in its order; pure.

Rule: every text that was added ends exactly once: whole, cut or failed.
"""

from __future__ import annotations

import re
import textwrap
from collections.abc import Callable
from typing import Literal, NamedTuple, get_args

__all__ = ("MOST_LETTERS", "PRIORITIES", "SpeechPriority", "SpeechQueue", "SpokenEnd", "SpokenText", "sentences")

MOST_LETTERS = 200
"""Letters of what is spoken in one piece: with a longer one a voice begins later."""
SpeechPriority = Literal["end", "question", "answer", "chatter"]
"""What is spoken first: the mission's end, then its questions and other reports, answers, the rest."""
PRIORITIES: tuple[SpeechPriority, ...] = get_args(SpeechPriority)
SpokenEnd = Literal["whole", "cut", "failed"]
"""How it ended: every word was played; it was interrupted; no voice or no speaker played it."""


class SpokenText(NamedTuple):
    """A text to be spoken."""

    key: str
    """By which its end is reported."""
    text: str
    priority: SpeechPriority = "answer"
    uncut: bool = False
    """A person who begins to speak does not interrupt it."""


class SpeechQueue:
    """Texts that wait; the most urgent first, equal ones in the order in which they came."""

    def __init__(self) -> None:
        self._waiting: list[SpokenText] = []

    def __len__(self) -> int:
        return len(self._waiting)

    def add(self, text: SpokenText) -> None:
        """Have a text spoken after all that are as urgent."""
        rank = PRIORITIES.index(text.priority)
        place = next(
            (place for place, each in enumerate(self._waiting) if PRIORITIES.index(each.priority) > rank),
            len(self._waiting),
        )
        self._waiting.insert(place, text)

    def take(self) -> SpokenText | None:
        """The next text; None if none waits."""
        return self._waiting.pop(0) if self._waiting else None

    def drop(self, which: Callable[[SpokenText], bool] = lambda text: True) -> list[SpokenText]:
        """Take out the texts for which that holds; in their order."""
        dropped = [each for each in self._waiting if which(each)]
        self._waiting = [each for each in self._waiting if not which(each)]
        return dropped


def sentences(text: str) -> list[str]:
    """The sentences of a text, to be spoken one by one; a longer one in parts, between its words where it has any."""
    whole = [each for each in re.split(r"(?<=[.!?])\s+", text.strip()) if re.search(r"\w", each)]
    parts = (textwrap.wrap(each, MOST_LETTERS) if len(each) > MOST_LETTERS else [each] for each in whole)
    return [part for each in parts for part in each if re.search(r"\w", part)]
