# SPDX-License-Identifier: Apache-2.0
"""Requests: starts that were ordered while a mission ran, and wait for its end; and orders that follow another one.

Rule: a request begins by itself only after success, or after the cancel that it was ordered with. After any other end
its begin needs a person's yes.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Sequence
from typing import NamedTuple

from rai_missions.conversation.dialogue.speech_output import SpeechOutput
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.inputs import Utterance
from rai_missions.conversation.outputs import Mapper

__all__ = ("JudgedOrder", "RequestQueue", "order_data")


class JudgedOrder(NamedTuple):
    """An order that may count, and where it comes from."""

    sense: Sense
    utterance: Utterance
    """The sentence that was read as it; of one that was confirmed, with the number of the sentence that did so."""
    mapper: Mapper
    words: str
    """The order in words."""
    confirmed: str = ""
    is_reported: bool = False
    """Whether it was spoken already that nothing comes of the request."""
    follows: str = ""
    """The order right before it in its sentence."""

    @property
    def is_start(self) -> bool:
        return self.sense.name == "start"

    def begins_after(self, mode: str) -> bool:
        """Whether it begins by itself where the mission before it has ended so."""
        return mode == "succeeded" or (mode == "canceled" and self.follows == "cancel")


class RequestQueue:
    """The requests that wait, the oldest first.

    Args:
        talk: What the parts of the dialogue share.
        speaking: Where texts go out.
    """

    def __init__(self, talk: Talk, speaking: SpeechOutput) -> None:
        self._talk, self._speaking = talk, speaking
        self._waiting: deque[JudgedOrder] = deque()
        self._lost: tuple[str, ...] = ()
        self._lost_report = ""

    def __len__(self) -> int:
        return len(self._waiting)

    @property
    def starts(self) -> int:
        """How many of them are starts."""
        return sum(each.is_start for each in self._waiting)

    @property
    def first(self) -> JudgedOrder | None:
        """The oldest; None where there is none."""
        return self._waiting[0] if self._waiting else None

    @property
    def words(self) -> tuple[str, ...]:
        """Each request in words."""
        return tuple(each.words for each in self._waiting)

    def add(self, judged: JudgedOrder) -> None:
        """Queue a request; the person is informed of its place, or that it follows the one before it."""
        self._waiting.append(judged)
        place = len(self._waiting)
        self._talk.note("queued", number=judged.utterance.number, order=order_data(judged.sense), place=place)
        self.note()
        form = "queued_then" if judged.follows else "queued_request"
        self._speaking.reply(form, judged.utterance, number=place, order=judged.words)

    def note(self) -> None:
        """Note what waits: a program that resumes the run after a kill reports what was lost."""
        self._talk.note("waiting", requests=[*self._lost, *self.words])

    def note_any(self) -> None:
        """Note what waits, or was lost and has yet to be reported, where there is anything."""
        if self._waiting or self._lost:
            self.note()

    def lose(self, requests: Sequence[str], run: str) -> None:
        """Have it reported that these are lost, which waited in a program that was killed.

        Until that is spoken they are noted with what waits: a program that resumes the run again reports them again.

        Args:
            requests: Each in words.
            run: Whose program it was.
        """
        self._lost, self._lost_report = tuple(requests), f"{run}:lost"
        language = self._talk.language
        text = language.text("requests_lost", requests=language.listed(list(requests)))
        self._speaking.reports.add(self._lost_report, text, self._talk.now)

    def on_speech_end(self) -> None:
        """A speech has ended; if it reported what was lost, that is known now."""
        if self._lost and self._speaking.reports.is_spoken(self._lost_report):
            self._lost = ()
            self.note()

    def take(self) -> JudgedOrder | None:
        """The oldest request, which waits no more; None where there is none."""
        if not self._waiting:
            return None
        request = self._waiting.popleft()
        self.note()
        return request

    @property
    def senses(self) -> tuple[Sense, ...]:
        """What each of them orders."""
        return tuple(each.sense for each in self._waiting)

    def drop_one(self, at: int) -> None:
        """One of them is dropped; every channel is informed.

        Args:
            at: Its place, from 0.
        """
        request = self._waiting[at]
        del self._waiting[at]
        self._report_dropped([request], "requests_withdrawn")

    def drop(self, form: str, asked: Sequence[str] = ()) -> None:
        """All are dropped; every channel is informed.

        Args:
            form: The template that gives the reason.
            asked: In words, a request that was taken from here and is dropped with them.
        """
        if not self._waiting and not asked:
            return
        requests = [*self._waiting]
        self._waiting.clear()
        self._report_dropped(requests, form, asked)

    def _report_dropped(self, requests: Sequence[JudgedOrder], form: str, asked: Sequence[str] = ()) -> None:
        for each in requests:
            self._talk.note("dropped", order=order_data(each.sense))
        self.note()
        language = self._talk.language
        listed = language.listed([*asked, *(each.words for each in requests)])
        self._speaking.speak(language.text(form, requests=listed), priority="question")


def order_data(sense: Sense) -> dict[str, object]:
    """An order as the journal has it."""
    data = {
        "order": sense.name,
        "mission": sense.mission,
        "arguments": dict(sense.arguments),
        "option": sense.option,
        "parameters": dict(sense.parameters),
        "then": [order_data(each) for each in sense.orders[1:]],
    }
    return {name: value for name, value in data.items() if value}
