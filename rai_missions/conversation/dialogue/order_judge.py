# SPDX-License-Identifier: Apache-2.0
"""Orders on their way to the run: judged, read back, confirmed, given out, or kept for the next run.

Rule: whatever leads to an order that is given out passes `take`, `stop` or `decide`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

from rai_missions.conversation.dialogue.confirmation import OrderConfirmation
from rai_missions.conversation.dialogue.given_orders import STOPPING, GivenOrders
from rai_missions.conversation.dialogue.order_rules import (
    OLD_S,
    TWO_NEEDED,
    forbidden,
    is_request,
    may,
    must_confirm,
    where_to_order,
    why_not_now,
    why_not_permitted,
)
from rai_missions.conversation.dialogue.request_queue import JudgedOrder, RequestQueue, order_data
from rai_missions.conversation.dialogue.speech_output import SpeechOutput
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.grammar.senses import STOP, Sense, joined
from rai_missions.conversation.inputs import SpeechEnd, Utterance
from rai_missions.conversation.language.language import spoken
from rai_missions.conversation.language.values import capital, duration
from rai_missions.conversation.outputs import Mapper
from rai_missions.conversation.view import StatusView
from rai_missions.event import Role
from rai_missions.planning.text.normalise import LONGEST
from rai_missions.redaction import cut

__all__ = ("EarlierOrder", "OrderJudge")


class EarlierOrder(NamedTuple):
    """An order, who gave it, and when."""

    speaker: tuple[str, str]
    sense: Sense
    at: float


class OrderJudge:
    """Judges orders, and keeps what waits for a confirmation or for its turn.

    Args:
        talk: What the parts of the dialogue share.
        speaking: Where texts go out.
    """

    def __init__(self, talk: Talk, speaking: SpeechOutput) -> None:
        self._talk, self._speaking = talk, speaking
        self.given = GivenOrders(talk, speaking)
        """What was given out."""
        self.taken: EarlierOrder | None = None
        """The start that was taken last."""
        self._requests = RequestQueue(talk, speaking)
        self.confirmation = OrderConfirmation(talk, speaking, self._requests)
        self._ended_run: str | None = talk.view.run if talk.view.has_ended else None
        self._is_last = False
        """No run follows the one that there is."""

    # -- what speakers may ask about -----------------------------------------------------------------------------------

    @property
    def waiting(self) -> tuple[str, ...]:
        """The requests that wait, in words."""
        return self._requests.words

    def speak_nothing(self, utterance: Utterance) -> None:
        """Reply that there is nothing to confirm, and which requests wait."""
        language, text = self._talk.language, self._talk.language.text("nothing_to_confirm")
        if self._requests and may(utterance.role, "start", self._talk.settings):
            waiting = language.text("queued", requests=language.listed(self._requests.words))
            text = f"{text} {waiting} {language.text('queued_more')}"
        self._speaking.answer(text, utterance)

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
        self.given.put(JudgedOrder(STOP, utterance, "grammar", words, is_reported=is_idle))
        self._speaking.silence(is_total=True)
        asked = self.confirmation.request
        self.confirmation.void("stop", by_speaker=utterance.speaker)
        text = language.text("stop_no_run" if is_idle else "done_stop")
        if not is_idle and may(utterance.role, "resume", self._talk.settings):
            text = f"{text} {language.text('stop_more')}"
        self._speaking.answer(text, utterance)
        self._requests.drop("requests_stopped", asked)
        return True

    @property
    def requests(self) -> tuple[Sense, ...]:
        """What the requests that wait order, the oldest first."""
        return self._requests.senses

    def withdraw_one(self, at: int, utterance: Utterance) -> None:
        """One of the requests that wait is dropped, by its place; a role that may order a start may do so."""
        if may(utterance.role, "start", self._talk.settings):
            self._requests.drop_one(at)
        else:
            self.refuse_permission("start", utterance)

    def withdraw(self, utterance: Utterance) -> None:
        """What waits is dropped; a role that may order a start may do so."""
        asked = self.confirmation.request
        if not may(utterance.role, "start", self._talk.settings):
            self.refuse_permission("start", utterance)
        elif not asked and not self._requests:
            self._speaking.reply("queued_none", utterance)
        else:
            if asked:
                self.confirmation.void("withdrawn")
            self._requests.drop("requests_withdrawn", asked)

    def take(
        self,
        sense: Sense,
        utterance: Utterance,
        *,
        mapper: Mapper,
        agreeing: int | None = None,
        others: Sequence[Sense] = (),
    ) -> None:
        """Judge an order that a sentence was read as; it is given out, read back, queued or refused.

        Args:
            sense: The order, with those that follow it.
            utterance: The sentence.
            mapper: What read it.
            agreeing: Of a spoken one that the grammar read, how many recognisers agree.
            others: The orders that are offered with it.
        """
        view, language, settings = self._talk.view, self._talk.language, self._talk.settings
        if order := forbidden(sense, utterance.role, settings):
            self.refuse_permission(order, utterance)
            return
        words = self._talk.order_words(sense)
        judged = JudgedOrder(sense, utterance, mapper, words)
        self._talk.note("mapped", number=utterance.number, order=order_data(sense), mapper=mapper)
        if utterance.age_s > OLD_S:
            age, most = duration(utterance.age_s, language), duration(OLD_S, language)
            self._refuse(judged, "too_old", order=words, age=age, most=most)
        elif self._is_impossible(judged):
            return
        elif any(each.name in TWO_NEEDED for each in sense.orders) and agreeing is not None and agreeing < 2:
            self._talk.note("refused", number=utterance.number, order=sense.name, by="recognisers")
            where = where_to_order(settings, language)
            self._speaking.reply("two_needed_order", utterance, order=words, where=where)
        elif must_confirm(sense, view, mapper=mapper, agreeing=agreeing):
            self.confirmation.read_back(judged, others=tuple(map(self._talk.order_words, others)))
        else:
            self._settle(judged)

    def _is_request(self, sense: Sense) -> bool:
        is_starting = sense.name == "start" and self.given.is_starting
        return is_starting or is_request(sense, self._talk.view)

    def is_open(self, sense: Sense, role: Role) -> bool:
        """Whether a role may give an order, which is possible now or after this run."""
        return not forbidden(sense, role, self._talk.settings) and not self._refusal(sense)

    def _is_impossible(self, judged: JudgedOrder) -> bool:
        """Whether the order is refused, because it is not possible now; the person is informed."""
        if refusal := self._refusal(judged.sense, judged.follows):
            form, why = refusal
            self._refuse(judged, form, count=self._requests.starts, order=judged.words, why=why)
        return bool(refusal)

    def _refusal(self, sense: Sense, follows: str = "") -> tuple[str, str] | None:
        """The text that refuses an order which is not possible now, with its reason; None where it is possible.

        Args:
            sense: The order.
            follows: The order right before it in its sentence.
        """
        settings, is_start = self._talk.settings, sense.name == "start"
        if self._is_last and is_start:
            return "start_last", ""
        if follows or self._is_request(sense):
            if is_start and settings.requests == "refuse" and follows != "cancel":
                return "request_refused", ""
            is_full = is_start and self._requests.starts >= settings.most_requests
            return ("queue_full", "") if is_full else None
        why = why_not_now(sense, self._talk.view, self._talk.language)
        if why and sense.name == "resume" and self.given.stopping_by:
            why = self._talk.language.text("why_stopping")
        return ("not_now", why.rstrip(".")) if why else None

    def _refuse(self, judged: JudgedOrder, form: str, **values: object) -> None:
        self._talk.note("refused", number=judged.utterance.number, order=judged.sense.name, by=form)
        self._speaking.reply(form, judged.utterance, **values)
        if judged.sense.then:
            then = self._talk.order_words(joined(judged.sense.orders[1:]))
            self._speaking.reply("left_out", judged.utterance, rest=then)

    def _settle(self, judged: JudgedOrder) -> None:
        """The order counts, and those that follow it, each of which waits for its turn."""
        follows = ""
        for sense in judged.sense.orders:
            words = self._talk.order_words(sense)
            one = judged._replace(sense=sense._replace(then=()), words=words, follows=follows)
            if not follows or not self._is_impossible(one):
                self._settle_one(one)
            follows = sense.name

    def _settle_one(self, judged: JudgedOrder) -> None:
        """An order is given out, or waits for the end of the mission or for its turn."""
        if judged.sense.name == "start":
            self.taken = EarlierOrder(judged.utterance.speaker, judged.sense, self._talk.now)
        if judged.follows or self._is_request(judged.sense):
            self._requests.add(judged)
        else:
            self._put_and_reply(judged)

    def _put_and_reply(self, judged: JudgedOrder) -> None:
        self.given.put(judged)
        values = {"order": judged.words, "option": spoken(judged.sense.option)}
        self._speaking.reply(f"done_{judged.sense.name}", judged.utterance, **values)
        if judged.sense.name == "resume":
            self.confirmation.speak_stopped()

    # -- confirmations -------------------------------------------------------------------------------------------------

    def decide(self, utterance: Utterance, *, is_yes: bool, is_agreed: bool, is_doubtful: bool) -> Sense | None:
        """A yes or a no to what was read back; of a spoken one, whether all readings are, of two or more.

        A doubtful yes, `maybe yes`, has the order read back again.

        Returns:
            The order that a no has dropped.
        """
        pending = self.confirmation.pending
        if pending is None:
            return None
        order = pending.order
        if forbidden(order.sense, utterance.role, self._talk.settings):
            role = self._talk.language.word("roles", utterance.role)
            self._talk.note("refused", number=utterance.number, order="confirm", role=utterance.role, by="role")
            self._speaking.reply("not_yours", utterance, role=capital(role))
        elif not is_yes:
            self.confirmation.end(utterance.speaker)
            self._talk.note("void", order=order_data(order.sense), by="no", number=utterance.number)
            self._speaking.reply("dropped", utterance)
            return order.sense
        elif utterance.is_spoken and not is_agreed:
            self._talk.note("refused", number=utterance.number, order="confirm", by="recognisers")
            self._speaking.reply("two_needed", utterance, order=order.words)
        elif (
            is_doubtful
            or pending.is_unclear(utterance)
            or self._talk.ends_with(utterance.channel, "model", "documents")
        ):
            self.confirmation.ask_again(utterance)
        else:
            self._confirm(order, utterance)
        return None

    def _confirm(self, order: JudgedOrder, utterance: Utterance) -> None:
        self.confirmation.end(utterance.speaker)
        sentence, confirmed = order.utterance._replace(number=utterance.number), cut(utterance.text, LONGEST)
        self._talk.note("confirmed", number=utterance.number, order=order_data(order.sense), sentence=confirmed)
        judged = order._replace(utterance=sentence, confirmed=confirmed)
        if not self._is_impossible(judged):
            self._settle(judged)

    # -- what happens to the run ---------------------------------------------------------------------------------------

    def end_starts(self) -> None:
        """No run follows the one that there is: what would begin one is dropped, and is refused from now on."""
        self._is_last = True
        asked, pending = self.confirmation.request, self.confirmation.order
        if pending is not None and pending.name == "start":
            self.confirmation.void("last")
        self._requests.drop("requests_last", asked)

    def follow(self, before: StatusView) -> None:
        """The run's status is new: what was read back may be void, and a request's turn may have come."""
        view = self._talk.view
        pending = self.confirmation.order
        self.confirmation.follow(may_begin=pending is not None and self._has_become_possible(pending))
        if view.is_alive and before.is_before_start and not view.is_before_start:
            self.given.end_starting()
        if view.is_alive and view.run != before.run:
            self.given.end_starting()
            self._requests.note_any()  # in the journal of the run that is new
        if view.has_ended and view.run != self._ended_run:
            self._ended_run = view.run
            self.given.end_starting()

    def _has_become_possible(self, sense: Sense) -> bool:
        """Whether it is a start that may begin now: the mission that ran when it was read back is over."""
        view = self._talk.view
        is_next = sense.name == "start" and not self._requests and not view.open_goals and not _is_locked(view)
        return is_next and not why_not_now(sense, view, self._talk.language)

    def begin_requests(self) -> None:
        """The next request has its turn where no mission runs or is about to, and no one is asked for another.

        An order that is no start has it as soon as it is possible.
        """
        while (first := self._requests.first) is not None and self._is_free:
            if not first.is_start and not self._is_due(first):
                return
            if first.is_start and self._talk.view.is_alive:
                return
            if first.is_start:
                self._next_request()
            else:
                self._next_order()

    @property
    def _is_free(self) -> bool:
        """Whether no mission is about to begin, and no one is asked for an order."""
        return self.confirmation.order is None and not self.given.is_starting

    def _is_due(self, order: JudgedOrder) -> bool:
        """Whether an order that is no start is possible, or has waited for that as long as it may."""
        view, is_possible = self._talk.view, not why_not_now(order.sense, self._talk.view, self._talk.language)
        return is_possible or not view.is_alive or self._talk.now >= self.given.taking_until

    def _next_order(self) -> None:
        """An order that follows another one is given out; to resume after a pause needs a yes of its own."""
        if (order := self._taken()) is None:
            return
        if order.sense.name == "resume" and order.follows in STOPPING:
            self.confirmation.read_back(order, is_request=True)
        else:
            self._put_and_reply(order)

    def _taken(self) -> JudgedOrder | None:
        """The oldest request; one that is not permitted, or not possible now, is dropped, and its speaker informed."""
        request = self._requests.take()
        if request is None:
            return None
        permitted = may(request.utterance.role, request.sense.name, self._talk.settings)
        if permitted and not why_not_now(request.sense, self._talk.view, self._talk.language):
            return request
        self._talk.note("dropped", order=order_data(request.sense))
        self._speaking.reply("request_impossible", request.utterance.unnumbered, order=request.words)
        return None

    def _next_request(self) -> None:
        """The mission has ended: the oldest request begins where it succeeded; else a person is asked."""
        view = self._talk.view
        if view.open_goals:
            self._requests.drop("requests_dropped")  # the robot may still move
        elif _is_locked(view):
            self._requests.drop("requests_stopped")
        if (request := self._taken()) is None:
            return
        if not request.begins_after(view.mode):
            self.confirmation.read_back(request, is_request=True)
            return
        self._speaking.speak(self._talk.language.text("request_begins", order=request.words), priority="question")
        self.given.put(request)

    def lose(self, requests: Sequence[str], run: str) -> None:
        """Report requests, in words, that waited in a program of this run that was killed: they are lost."""
        self._requests.lose(requests, run)

    def on_speech_end(self, end: SpeechEnd) -> None:
        """A speech has ended: it may have read an order back, or reported what was lost."""
        self._requests.on_speech_end()
        self.confirmation.on_speech_end(end)

    def on_time(self) -> None:
        """A confirmation that was not given in time is void."""
        self.confirmation.on_time()

    @property
    def asks_to_begin(self) -> bool:
        """Whether a mission is over and a start, of a request or ordered since, waits for a person's yes."""
        pending = self.confirmation.order
        return pending is not None and pending.name == "start" and not self._talk.view.is_alive

    def wake_at(self) -> float | None:
        """When a confirmation expires, or an order that waits for its turn."""
        first, until = self._requests.first, self.given.taking_until
        is_waiting = first is not None and not first.is_start and until > self._talk.now
        times = (self.confirmation.wake_at(), until if is_waiting else None)
        return min((at for at in times if at is not None), default=None)


def _is_locked(view: StatusView) -> bool:
    """Whether the run is over by an e-stop: no other begins until an operator has taken control."""
    return view.has_ended and view.control == "nobody"
