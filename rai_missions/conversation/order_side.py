# SPDX-License-Identifier: Apache-2.0
"""Orders on their way to the run: judged, read back, confirmed, given out, or kept for the next run.

Rule: this is the only place that gives out an `Order`; whatever leads to one passes `take`, `stop` or `decide`.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Literal, NamedTuple, TypeVar

from rai_missions.conversation.confirmation import Confirmable
from rai_missions.conversation.grammar import STOP
from rai_missions.conversation.inputs import OrderEnd, SpeechEnd, Utterance
from rai_missions.conversation.language import spoken
from rai_missions.conversation.order_rules import (
    TWO_NEEDED,
    binding,
    is_request,
    may,
    must_confirm,
    where_to_order,
    why_not_now,
    why_not_permitted,
)
from rai_missions.conversation.order_words import order_words
from rai_missions.conversation.outputs import Mapper, Order
from rai_missions.conversation.request_queue import JudgedOrder, RequestQueue, order_data
from rai_missions.conversation.senses import Sense
from rai_missions.conversation.speech_side import SpeechSide
from rai_missions.conversation.talk import Talk
from rai_missions.conversation.values import capital
from rai_missions.conversation.view import StatusView
from rai_missions.redaction import cut

__all__ = ("EarlierOrder", "OrderSide")

K = TypeVar("K")
V = TypeVar("V")
REMEMBERED, SPEAKERS = 10, 100
"""Orders of one speaker that it can ask about, and orders under way; speakers that are remembered."""
STARTING_S = 30.0
"""Seconds that an ordered start may take until the run is seen; then the next request is possible."""
LONGEST_REASON = 200
"""Characters of a reason that is spoken."""
CROSSING_S = 1.0
"""Seconds after the end of one question within which a person may still answer it, while the next is asked."""
STOPPING = frozenset({"stop", "pause", "cancel"})
"""Orders after which the mission does not continue by itself."""


class EarlierOrder(NamedTuple):
    """An order, who gave it, and when."""

    speaker: tuple[str, str]
    sense: Sense
    at: float


class OrderSide:
    """Judges orders, and keeps what waits for a confirmation or for its turn.

    Args:
        talk: What the sides share.
        speaking: Where texts go out.
    """

    def __init__(self, talk: Talk, speaking: SpeechSide) -> None:
        self._talk, self._speaking = talk, speaking
        self._count = 0
        self.pending: Confirmable | None = None
        """What was read back, and waits for a yes."""
        self.taken: EarlierOrder | None = None
        """The start that was taken last."""
        self._ended_at, self._ended_by = float("-inf"), ("", "")
        self._requests = RequestQueue(talk, speaking)
        self._under_way: dict[int, JudgedOrder] = {}
        self._ordered: dict[tuple[str, str], tuple[str, ...]] = {}
        self._starts: dict[tuple[str, str], Sense] = {}
        """Speaker → the last start that it ordered."""
        self._ended_run: str | None = talk.view.run if talk.view.has_ended else None
        self._starting_until = float("-inf")
        self._is_last = False
        """No run follows the one that there is."""

    # -- what speakers may ask about -----------------------------------------------------------------------------------

    @property
    def waiting(self) -> tuple[str, ...]:
        """The requests that wait, in words."""
        return self._requests.words

    def ordered_by(self, speaker: tuple[str, str]) -> tuple[str, ...]:
        """The last orders of a speaker that were given out, in words, oldest first."""
        return self._ordered.get(speaker, ())

    def last_start_of(self, speaker: tuple[str, str]) -> Sense | None:
        """The last start that a speaker ordered."""
        return self._starts.get(speaker)

    def speak_nothing(self, utterance: Utterance) -> None:
        """That there is nothing to confirm, and which requests wait."""
        language, text = self._talk.language, self._talk.language.text("nothing_to_confirm")
        if self._requests and may(utterance.role, "start", self._talk.settings):
            waiting = language.text("queued", requests=language.listed(self._requests.words))
            text = f"{text} {waiting} {language.text('queued_more')}"
        self._speaking.answer(text, utterance)

    @property
    def stopping_by(self) -> str:
        """Who gave an order to stop, pause or cancel that the run has not taken yet; empty where there is none."""
        stopping = (each for each in self._under_way.values() if each.sense.name in STOPPING)
        return next((each.utterance.by for each in stopping), "")

    # -- orders --------------------------------------------------------------------------------------------------------

    def refuse_permission(self, order: str, utterance: Utterance) -> None:
        """The role of a sentence may not order this; the reply names where it can be ordered."""
        language, settings = self._talk.language, self._talk.settings
        why = why_not_permitted(order, utterance.role, utterance.channel, settings, language)
        self._talk.note("refused", number=utterance.number, order=order, role=utterance.role, by="role")
        self._speaking.answer(why, utterance)

    def stop(self, utterance: Utterance) -> bool:
        """A sentence that orders to stop: it needs no confirmation; whether its role may."""
        if not may(utterance.role, "stop", self._talk.settings):
            self.refuse_permission("stop", utterance)
            return False
        language, view = self._talk.language, self._talk.view
        words, is_idle = language.text("order_stop"), not view.is_alive
        self._put(JudgedOrder(STOP, utterance, "grammar", words, is_reported=is_idle))
        self._speaking.silence(is_total=True)
        asked = self._asked_request
        if self.pending is not None:
            self._void("stop")
        text = language.text("stop_no_run" if is_idle else "done_stop")
        if not is_idle and may(utterance.role, "resume", self._talk.settings):
            text = f"{text} {language.text('stop_more')}"
        self._speaking.answer(text, utterance)
        self._requests.drop("requests_stopped", asked)
        return True

    @property
    def _asked_request(self) -> tuple[str, ...]:
        """In words, the request whose turn it is, while a person is asked whether it may begin."""
        return (self.pending.words,) if self.pending is not None and self.pending.is_request else ()

    def withdraw(self, utterance: Utterance) -> None:
        """What waits is dropped; a role that may order a start may do so."""
        asked = self._asked_request
        if not may(utterance.role, "start", self._talk.settings):
            self.refuse_permission("start", utterance)
        elif not asked and not self._requests:
            self._speaking.reply("queued_none", utterance)
        else:
            if asked:
                self._void("withdrawn")
            self._requests.drop("requests_withdrawn", asked)

    def take(self, sense: Sense, utterance: Utterance, *, mapper: Mapper, agreeing: int | None = None) -> None:
        """Judge an order that a sentence was read as; it is given out, read back, queued or refused.

        Args:
            sense: The order.
            utterance: The sentence.
            mapper: What read it.
            agreeing: Of a spoken one that the grammar read, how many recognisers agree.
        """
        view, language, settings = self._talk.view, self._talk.language, self._talk.settings
        if not may(utterance.role, sense.name, settings):
            self.refuse_permission(sense.name, utterance)
            return
        words = order_words(sense, view, self._talk.spoken_starts, language)
        judged = JudgedOrder(sense, utterance, mapper, words)
        self._talk.note("mapped", number=utterance.number, order=order_data(sense), mapper=mapper)
        if self._is_impossible(judged):
            return
        if sense.name in TWO_NEEDED and agreeing is not None and agreeing < 2:
            self._talk.note("refused", number=utterance.number, order=sense.name, by="recognisers")
            where = where_to_order(settings, language)
            self._speaking.reply("two_needed_order", utterance, order=words, where=where)
        elif must_confirm(sense, view, mapper=mapper, agreeing=agreeing):
            self._read_back(judged)
        else:
            self._settle(judged)

    def _is_request(self, sense: Sense) -> bool:
        is_starting = sense.name == "start" and self._talk.now < self._starting_until
        return is_starting or is_request(sense, self._talk.view)

    def _is_impossible(self, judged: JudgedOrder) -> bool:
        """Whether the order is refused, because it is not possible now; the person is informed."""
        sense, settings = judged.sense, self._talk.settings
        if self._is_last and sense.name == "start":
            self._refuse(judged, "start_last", order=judged.words)
            return True
        if self._is_request(sense):
            form = "request_refused" if settings.requests == "refuse" else ""
            form = form or ("queue_full" if len(self._requests) >= settings.most_requests else "")
            if form:
                self._refuse(judged, form, count=len(self._requests), order=judged.words)
            return bool(form)
        why = why_not_now(sense, self._talk.view, self._talk.language)
        if why and sense.name == "resume" and self.stopping_by:
            why = self._talk.language.text("why_stopping")
        if why:
            self._refuse(judged, "not_now", why=why.rstrip("."))
        return bool(why)

    def _refuse(self, judged: JudgedOrder, form: str, **values: object) -> None:
        self._talk.note("refused", number=judged.utterance.number, order=judged.sense.name, by=form)
        self._speaking.reply(form, judged.utterance, **values)

    def _settle(self, judged: JudgedOrder) -> None:
        """The order counts: it is given out, or waits for the end of the mission."""
        if judged.sense.name == "start":
            self.taken = EarlierOrder(judged.utterance.speaker, judged.sense, self._talk.now)
        if self._is_request(judged.sense):
            self._requests.add(judged)
            return
        self._put(judged)
        sense = judged.sense
        values = {"order": judged.words, "option": spoken(sense.option)}
        self._speaking.reply(f"done_{sense.name}", judged.utterance, **values)

    def _put(self, judged: JudgedOrder) -> None:
        """Give the order out."""
        self._count += 1
        sense, utterance = judged.sense, judged.utterance
        if sense.name == "start":
            self._starting_until = self._talk.now + STARTING_S
            _remember(self._starts, utterance.speaker, sense, SPEAKERS)
        _remember(self._under_way, self._count, judged, REMEMBERED)
        orders = (*self.ordered_by(utterance.speaker), judged.words)[-REMEMBERED:]
        _remember(self._ordered, utterance.speaker, orders, SPEAKERS)
        self._talk.note(
            "ordered", order_number=self._count, number=utterance.number, order=order_data(sense), role=utterance.role,
            mapper=judged.mapper, confirmed=judged.confirmed,
        )  # fmt: skip
        self._talk.put(
            Order(
                self._count, sense.name, utterance.role, utterance.channel, utterance.author, sense.mission,  # type: ignore[arg-type]
                dict(sense.arguments), sense.question, sense.option, dict(sense.parameters), judged.mapper,
                cut(utterance.text, 2_000), judged.confirmed, self._talk.now,
            )
        )  # fmt: skip

    # -- confirmations -------------------------------------------------------------------------------------------------

    def _read_back(self, judged: JudgedOrder, *, is_request: bool = False) -> None:
        if self.pending is not None:
            is_same = judged.sense.identity == self.pending.sense.identity
            by: Literal["corrected", "replaced"] = "corrected" if judged.sense.is_correction or is_same else "replaced"
            self._void(by, by_speaker=judged.utterance.speaker)
        rests_on = self._binding(judged.sense, is_request=is_request)
        pending = Confirmable(
            judged.sense, judged.utterance, judged.mapper, judged.words, rests_on, self._talk.now,
            is_crossing=self._talk.now - self._ended_at < CROSSING_S, understood_by=self._ended_by,
            is_request=is_request,
        )  # fmt: skip
        self.ask_to_confirm(pending, judged.utterance)

    def _binding(self, sense: Sense, *, is_request: bool) -> tuple[object, ...]:
        """What a confirmation rests on; a request's on nothing: it is for the run after the one that ended."""
        return () if is_request else binding(sense, self._talk.view)

    def ask_to_confirm(self, pending: Confirmable, to: Utterance) -> None:
        """Read an order back, for the first time or again."""
        form = "read_back_model" if pending.mapper == "model" else "read_back"
        form = "request_asked" if pending.is_request else form
        speech = self._speaking.reply(form, to, order=pending.words)
        until = self._talk.now + self._talk.settings.confirm_s
        read_at = math.inf if to.is_spoken else self._talk.now
        self.pending = pending._replace(until=until, read_at=read_at, key=speech.key)
        self._talk.note("read_back", number=to.number, order=order_data(pending.sense), mapper=pending.mapper)

    def distract(self, utterance: Utterance) -> None:
        """A sentence that is neither yes nor no: what its speaker may confirm is to be read back again."""
        pending = self.pending
        if pending is None or not may(utterance.role, pending.sense.name, self._talk.settings):
            return
        self.pending = pending._replace(distracted=pending.distracted | {utterance.speaker})

    def _end_pending(self, by_speaker: tuple[str, str] = ("", "")) -> Confirmable | None:
        """No confirmation is asked for any more; the one that was.

        Args:
            by_speaker: Who has ended it; empty where no speaker has.
        """
        pending, self.pending = self.pending, None
        if pending is not None:
            self._ended_at, self._ended_by = self._talk.now, by_speaker
        return pending

    def _void(
        self,
        by: Literal["time", "changed", "replaced", "corrected", "stop", "unspoken", "withdrawn", "last"],
        by_speaker: tuple[str, str] = ("", ""),
    ) -> None:
        """What was read back does not count any more; the person is informed where that is not obvious."""
        pending = self._end_pending(by_speaker)
        if pending is None:
            return
        self._talk.note("void", order=order_data(pending.sense), by=by)
        if by in ("time", "changed", "replaced") or (by == "last" and not pending.is_request):
            self._speaking.reply(f"void_{by}", pending.utterance.unnumbered, order=pending.words)
        if by in ("time", "unspoken") and pending.is_request:
            self._requests.drop("requests_unanswered")

    def decide(self, utterance: Utterance, *, is_yes: bool, is_agreed: bool) -> Sense | None:
        """A yes or a no to what was read back; of a spoken one, whether all readings are, of two or more.

        Returns:
            The order that a no has dropped.
        """
        pending = self.pending
        if pending is None:
            return None
        if not may(utterance.role, pending.sense.name, self._talk.settings):
            role = self._talk.language.word("roles", utterance.role)
            self._talk.note("refused", number=utterance.number, order="confirm", role=utterance.role, by="role")
            self._speaking.reply("not_yours", utterance, role=capital(role))
        elif not is_yes:
            self._end_pending(utterance.speaker)
            self._talk.note("void", order=order_data(pending.sense), by="no", number=utterance.number)
            self._speaking.reply("dropped", utterance)
            return pending.sense
        elif utterance.is_spoken and not is_agreed:
            self._talk.note("refused", number=utterance.number, order="confirm", by="recognisers")
            self._speaking.reply("two_needed", utterance, order=pending.words)
        elif pending.is_unclear(utterance) or self._talk.ends_with_model(utterance.channel):
            self.ask_to_confirm(pending.asked_again(), utterance)
        else:
            self._confirm(pending, utterance)
        return None

    def _confirm(self, pending: Confirmable, utterance: Utterance) -> None:
        self._end_pending(utterance.speaker)
        sentence, confirmed = pending.utterance._replace(number=utterance.number), cut(utterance.text, 2_000)
        self._talk.note("confirmed", number=utterance.number, order=order_data(pending.sense), sentence=confirmed)
        judged = JudgedOrder(pending.sense, sentence, pending.mapper, pending.words, confirmed)
        if not self._is_impossible(judged):
            self._settle(judged)

    # -- what happens to the run ---------------------------------------------------------------------------------------

    def end_starts(self) -> None:
        """No run follows the one that there is: what would begin one is dropped, and is refused from now on."""
        self._is_last = True
        asked = self._asked_request
        if self.pending is not None and self.pending.sense.name == "start":
            self._void("last")
        self._requests.drop("requests_last", asked)

    def follow(self, before: StatusView) -> None:
        """The run's status is new: what was read back may be void, and a request's turn may have come."""
        view = self._talk.view
        pending = self.pending
        if (
            pending is not None
            and (now := self._binding(pending.sense, is_request=pending.is_request)) != pending.binding
        ):
            if self._has_become_possible(pending.sense):
                self.ask_to_confirm(pending._replace(binding=now), pending.utterance.unnumbered)
            else:
                self._void("changed")
        if view.is_alive and view.run != before.run:
            self._starting_until = float("-inf")
            self._requests.note_any()  # in the journal of the run that is new
        if view.has_ended and view.run != self._ended_run:
            self._ended_run = view.run
            self._starting_until = float("-inf")

    def _has_become_possible(self, sense: Sense) -> bool:
        """Whether it is a start that may begin now: the mission that ran when it was read back is over."""
        view = self._talk.view
        is_next = sense.name == "start" and not self._requests and not view.open_goals and not _is_locked(view)
        return is_next and not why_not_now(sense, view, self._talk.language)

    def begin_requests(self) -> None:
        """The next request has its turn where no mission runs or is about to, and no one is asked for another."""
        while self._requests and self.pending is None and self._talk.now >= self._starting_until:
            if self._talk.view.is_alive:
                return
            self._next_request()

    def _next_request(self) -> None:
        """The mission has ended: the oldest request begins where it succeeded; else a person is asked."""
        view = self._talk.view
        if view.open_goals:
            self._requests.drop("requests_dropped")  # the robot may still move
        elif _is_locked(view):
            self._requests.drop("requests_stopped")
        request = self._requests.take()
        if request is None:
            return
        permitted = may(request.utterance.role, "start", self._talk.settings)
        if not permitted or why_not_now(request.sense, view, self._talk.language):
            self._talk.note("dropped", order=order_data(request.sense))
            self._speaking.reply("request_impossible", request.utterance.unnumbered, order=request.words)
            return
        if view.mode != "succeeded":
            self._read_back(request, is_request=True)
            return
        self._speaking.speak(self._talk.language.text("request_begins", order=request.words), priority="question")
        self._put(request)

    def on_order_end(self, end: OrderEnd) -> None:
        """What became of an order; a refusal is reported."""
        judged = self._under_way.pop(end.number, None)
        if judged is None:
            return
        why = cut(end.refused, LONGEST_REASON)
        self._talk.note("performed", order_number=end.number, order=judged.sense.name, refused=why)
        if why and judged.sense.name == "start":
            self._starting_until = float("-inf")
        if why and not judged.is_reported:
            self._speaking.reply("refused", judged.utterance.unnumbered, order=judged.words, why=why.rstrip("."))

    def lose(self, requests: Sequence[str], run: str) -> None:
        """These waited in a program of this run that was killed, in words: that they are lost is reported."""
        self._requests.lose(requests, run)

    def on_speech_end(self, end: SpeechEnd) -> None:
        """A yes counts from the end of the reading back on, and so does its time; what was not spoken is void."""
        self._requests.on_speech_end()
        pending = self.pending
        if pending is None or pending.key != end.key:
            return
        if end.result == "failed" and pending.utterance.is_spoken:
            self._void("unspoken")
        else:
            until = self._talk.now + self._talk.settings.confirm_s
            self.pending = pending._replace(until=until, read_at=end.at)

    def on_time(self) -> None:
        """A confirmation that was not given in time is void."""
        if self.pending is not None and self._talk.now >= self.pending.until:
            self._void("time")

    @property
    def asks_to_begin(self) -> bool:
        """Whether a mission is over and a start, of a request or ordered since, waits for a person's yes."""
        return self.pending is not None and self.pending.sense.name == "start" and not self._talk.view.is_alive

    def wake_at(self) -> float | None:
        """When a confirmation expires."""
        return None if self.pending is None else self.pending.until


def _is_locked(view: StatusView) -> bool:
    """Whether the run is over by an e-stop: no other begins until an operator has taken control."""
    return view.has_ended and view.control == "nobody"


def _remember(known: dict[K, V], key: K, value: V, most: int) -> None:
    """Note what is newest, and forget what is older than so many others."""
    known.pop(key, None)
    known[key] = value
    for old in list(known)[:-most]:
        del known[old]
