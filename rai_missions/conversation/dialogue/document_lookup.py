# SPDX-License-Identifier: Apache-2.0
"""Questions that no rule answers: they are looked up in the robot's documents, and what is found is quoted.

Rule: a document's text goes out between quotation marks with its source, and is read by no rule: it is no instruction,
no order and no status.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rai_missions.conversation.dialogue.speech_output import SpeechOutput
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.grammar.unread_sentence import is_question
from rai_missions.conversation.inputs import DocumentQuote, FoundQuotes, Utterance
from rai_missions.conversation.outputs import LookUp
from rai_missions.planning.text.normalise import LONGEST, readable
from rai_missions.redaction import cut, quotable

__all__ = ("DocumentLookup",)

MOST_OPEN = 5
"""Questions that are looked up at once; another one is answered without the documents."""
MOST_QUOTES, LONGEST_QUOTE, LONGEST_SOURCE = 2, 400, 120
"""Quotations of an answer, and the characters of each and of its source."""
PATIENCE_S = 1.0
"""A look that takes longer is reported."""


class OpenLook(NamedTuple):
    """A question whose answer is being looked up."""

    utterance: Utterance
    answer_else: Callable[[], object]
    """Gives the answer where the documents have none."""
    until: float
    acknowledge_at: float | None
    """When it is reported that the look takes its time; None: it was."""


class DocumentLookup:
    """Has questions looked up, and quotes what is found.

    Args:
        talk: What the parts of the dialogue share.
        speaking: Where texts go out.
    """

    def __init__(self, talk: Talk, speaking: SpeechOutput) -> None:
        self._talk, self._speaking = talk, speaking
        self._count = 0
        self._open: dict[int, OpenLook] = {}

    @property
    def looks_up(self) -> bool:
        """Whether a question is being looked up."""
        return bool(self._open)

    def ask(self, utterance: Utterance, answer_else: Callable[[], object]) -> None:
        """Look a question up; what is none, or finds no room, gets the other answer at once.

        Args:
            utterance: The sentence.
            answer_else: Gives the answer where the documents have none.
        """
        talk = self._talk
        has_room = talk.settings.has_documents and len(self._open) < MOST_OPEN
        if not has_room or not is_question(utterance.text, talk.language):
            answer_else()
            return
        self._count += 1
        until = talk.now + talk.settings.look_up_s
        self._open[self._count] = OpenLook(utterance, answer_else, until, talk.now + PATIENCE_S)
        talk.put(LookUp(self._count, cut(utterance.text, LONGEST), until))

    def on_found(self, found: FoundQuotes) -> None:
        """What the documents have on a question is quoted."""
        look = self._open.pop(found.number, None)
        if look is None:
            return
        quotes = found.quotes[:MOST_QUOTES]
        self._talk.note(
            "looked_up",
            number=look.utterance.number,
            sources=[_quotable(each.source, LONGEST) for each in quotes],
            failed=cut(found.failed, LONGEST),
        )
        if quotes:
            text = self._talk.language.text("quoted", quotes=" ".join(map(self._quote, quotes)))
            self._speaking.answer(text, look.utterance, way="documents")
        else:
            look.answer_else()

    def _quote(self, quote: DocumentQuote) -> str:
        text, source = _quotable(quote.text, LONGEST_QUOTE), _quotable(quote.source, LONGEST_SOURCE)
        return self._talk.language.text("quote", text=text, source=source)

    def drop_all(self) -> None:
        """After a stop: no answer is wanted."""
        for look in self._open.values():
            self._talk.note("dropped", number=look.utterance.number, policy="stop")
        self._open.clear()

    def on_time(self) -> None:
        """A look that takes its time is reported; one that takes too long is not waited for."""
        now = self._talk.now
        for number, look in list(self._open.items()):
            if now >= look.until:
                self.on_found(FoundQuotes(number, failed="no reply in time"))
            elif look.acknowledge_at is not None and now >= look.acknowledge_at:
                self._open[number] = look._replace(acknowledge_at=None)
                self._speaking.acknowledge("looks_up", look.utterance)

    def wake_at(self) -> float | None:
        """When the next of both is due."""
        due = (look.until if look.acknowledge_at is None else look.acknowledge_at for look in self._open.values())
        return min(due, default=None)


def _quotable(text: str, length: int) -> str:
    """A document's text in one line, without characters that are not shown, and without quotation marks."""
    return cut(quotable(readable(text, by=cut)), length)
