# SPDX-License-Identifier: Apache-2.0
"""A confirmation: one order that was read back and waits for its yes.

Rule: the yes counts for exactly what was read back: by one who may, in time, while what it rests on is the same, and
as the first that this person utters after it. A yes from before it was read back, or that may be meant for the question
before, does not count.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Literal, NamedTuple

from rai_missions.conversation.dialogue.order_rules import binding, forbidden
from rai_missions.conversation.dialogue.request_queue import JudgedOrder, RequestQueue, order_data
from rai_missions.conversation.dialogue.speech_output import SpeechOutput
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.inputs import SpeechEnd, Utterance
from rai_missions.conversation.outputs import Mapper

__all__ = ("CROSSING_S", "OrderConfirmation")

CROSSING_S = 1.0
"""Seconds after the end of one question within which a person may still answer it, while the next is asked."""
READ_BACK: Mapping[Mapper, str] = {
    "grammar": "read_back",
    "model": "read_back_model",
    "nearest": "read_back_nearest",
}
"""What read a sentence → the text that reads the order back."""
VoidReason = Literal["time", "changed", "replaced", "corrected", "stop", "unspoken", "withdrawn", "last"]


class Confirmable(NamedTuple):
    """An order that was read back."""

    order: JudgedOrder
    rests_on: tuple[object, ...]
    """What differs where it is void; `order_rules.binding`."""
    until: float = math.inf
    read_at: float = math.inf
    """From when on it can be known: it was shown, or spoken to its end."""
    key: str = ""
    """Of the speech that reads it back."""
    distracted: frozenset[tuple[str, str]] = frozenset()
    """The speakers who have uttered something else since; the yes of one of them has it read back again."""
    is_crossing: bool = False
    """Another question ended right before this one, so a yes may be meant for that one: it has this read back again."""
    understood_by: tuple[str, str] = ("", "")
    """The speaker who ended the other question, and so knows of this one."""
    is_request: bool = False
    """It waited for the end of a mission, which did not succeed."""
    others: tuple[str, ...] = ()
    """What was offered with it, in words."""

    def is_unclear(self, yes: Utterance) -> bool:
        """Whether a yes came too early, may be meant for something else, or asks; it has the order read back again."""
        is_crossing = self.is_crossing and yes.speaker != self.understood_by
        return yes.at < self.read_at or yes.speaker in self.distracted or is_crossing or yes.asks


class OrderConfirmation:
    """What was read back, until it counts or is void.

    Args:
        talk: What the parts of the dialogue share.
        speaking: Where texts go out.
        requests: What waits; dropped with a request that is not confirmed.
    """

    def __init__(self, talk: Talk, speaking: SpeechOutput, requests: RequestQueue) -> None:
        self._talk, self._speaking, self._requests = talk, speaking, requests
        self.pending: Confirmable | None = None
        self._ended_at, self._ended_by = float("-inf"), ("", "")
        self._stopped: JudgedOrder | None = None
        """What a stop has made void, until the next order is read back or its person is informed."""

    @property
    def order(self) -> Sense | None:
        """The order that waits for a yes."""
        return None if self.pending is None else self.pending.order.sense

    @property
    def request(self) -> tuple[str, ...]:
        """In words, the request whose turn it is, while a person is asked whether it may begin."""
        return (self.pending.order.words,) if self.pending is not None and self.pending.is_request else ()

    def read_back(self, order: JudgedOrder, *, is_request: bool = False, others: tuple[str, ...] = ()) -> None:
        """Read an order back; it takes the place of another one.

        Args:
            order: What counts by a yes.
            is_request: It waited for the end of a mission.
            others: What is offered with it, in words.
        """
        if self.pending is not None:
            is_same = order.sense.identity == self.pending.order.sense.identity
            by: VoidReason = "corrected" if order.sense.is_correction or is_same else "replaced"
            self.void(by, by_speaker=order.utterance.speaker)
        self._stopped = None
        pending = Confirmable(
            order,
            self._rests_on(order, is_request=is_request),
            is_crossing=self._talk.now - self._ended_at < CROSSING_S,
            understood_by=self._ended_by,
            is_request=is_request,
            others=others,
        )
        self._ask(pending, order.utterance)

    def _rests_on(self, order: JudgedOrder, *, is_request: bool) -> tuple[object, ...]:
        """What a confirmation rests on; a request's on nothing: it is for the run after the one that ended."""
        return () if is_request else binding(order.sense, self._talk.view)

    def ask_again(self, to: Utterance) -> None:
        """Read it back again: the next yes of each speaker is clear."""
        if self.pending is not None:
            self._ask(self.pending._replace(distracted=frozenset(), is_crossing=False), to)

    def _ask(self, pending: Confirmable, to: Utterance) -> None:
        order = pending.order
        form = "request_asked" if pending.is_request else READ_BACK[order.mapper]
        speech = self._speaking.reply(form, to, order=order.words)
        if pending.others:
            self._speaking.reply("read_back_others", to, others=self._talk.language.listed(pending.others, "or"))
        until = self._talk.now + self._talk.settings.confirm_s
        read_at = math.inf if to.is_spoken else self._talk.now
        self.pending = pending._replace(until=until, read_at=read_at, key=speech.key)
        self._talk.note("read_back", number=to.number, order=order_data(order.sense), mapper=order.mapper)

    def distract(self, utterance: Utterance) -> None:
        """A sentence that is neither yes nor no: what its speaker may confirm is to be read back again."""
        pending = self.pending
        if pending is not None and not forbidden(pending.order.sense, utterance.role, self._talk.settings):
            self.pending = pending._replace(distracted=pending.distracted | {utterance.speaker})

    def end(self, by_speaker: tuple[str, str] = ("", "")) -> Confirmable | None:
        """No confirmation is asked for any more; the one that was.

        Args:
            by_speaker: Who has ended it; empty where no speaker has.
        """
        pending, self.pending = self.pending, None
        if pending is not None:
            self._ended_at, self._ended_by = self._talk.now, by_speaker
        return pending

    def void(self, by: VoidReason, by_speaker: tuple[str, str] = ("", "")) -> None:
        """What was read back does not count any more; the person is informed where that is not obvious."""
        pending = self.end(by_speaker)
        if pending is None:
            return
        order = pending.order
        self._talk.note("void", order=order_data(order.sense), by=by)
        if by in ("time", "changed", "replaced") or (by == "last" and not pending.is_request):
            self._speaking.reply(f"void_{by}", order.utterance.unnumbered, order=order.words)
        if by in ("time", "unspoken") and pending.is_request:
            self._requests.drop("requests_unanswered")
        if by == "stop" and not pending.is_request:
            self._stopped = order

    def speak_stopped(self) -> None:
        """What waited for a yes as the stop came is named once the mission resumes; the stop itself is short."""
        order, self._stopped = self._stopped, None
        if order is not None:
            self._speaking.reply("void_stop", order.utterance.unnumbered, order=order.words)

    def follow(self, *, may_begin: bool) -> None:
        """The run's status is new: what was read back is void where what it rests on differs.

        Args:
            may_begin: It is a start that has become possible, and so is read back again.
        """
        pending = self.pending
        if pending is None:
            return
        now = self._rests_on(pending.order, is_request=pending.is_request)
        if now == pending.rests_on:
            return
        if may_begin:
            self._ask(pending._replace(rests_on=now), pending.order.utterance.unnumbered)
        else:
            self.void("changed")

    def on_speech_end(self, end: SpeechEnd) -> None:
        """A yes counts from the end of the reading back on, and so does its time; what was not spoken is void."""
        pending = self.pending
        if pending is None or pending.key != end.key:
            return
        if end.result == "failed" and pending.order.utterance.is_spoken:
            self.void("unspoken")
        else:
            until = self._talk.now + self._talk.settings.confirm_s
            self.pending = pending._replace(until=until, read_at=end.at)

    def on_time(self) -> None:
        """A confirmation that was not given in time is void."""
        if self.pending is not None and self._talk.now >= self.pending.until:
            self.void("time")

    def wake_at(self) -> float | None:
        """When it expires."""
        return None if self.pending is None else self.pending.until
