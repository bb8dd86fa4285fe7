# SPDX-License-Identifier: Apache-2.0
"""Sentences that the rules do not know: a model is asked, and its text goes out labelled, sentence by sentence.

Rule: a model's sentence about the robot or its work is replaced by the status, and so is its order with such a text;
any other order is read back.
"""

from __future__ import annotations

from rai_missions.conversation.answers.unread_answers import UnreadAnswers
from rai_missions.conversation.claims.claims import Claims
from rai_missions.conversation.claims.judged_sentence import ClaimKind
from rai_missions.conversation.dialogue.document_lookup import DocumentLookup
from rai_missions.conversation.dialogue.model_turns import ModelTurn, ModelTurns
from rai_missions.conversation.dialogue.order_forms import order_forms, proposed
from rai_missions.conversation.dialogue.order_judge import OrderJudge
from rai_missions.conversation.dialogue.order_offers import OrderOffers
from rai_missions.conversation.dialogue.order_rules import may
from rai_missions.conversation.dialogue.proposed_texts import own_texts
from rai_missions.conversation.dialogue.speech_output import SpeechOutput
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.inputs import ModelText, SpeechEnd, Utterance
from rai_missions.conversation.language.question_words import options_text
from rai_missions.conversation.outputs import AskModel, DropModel
from rai_missions.conversation.sentences import SentenceStream
from rai_missions.plain_data import plain
from rai_missions.planning.text.normalise import LONGEST
from rai_missions.redaction import cut

__all__ = ("ModelReplies",)

LONGEST_NOTE = 500


class ModelReplies:
    """Asks the model, and lets out of its reply what may be spoken.

    Args:
        talk: What the parts of the dialogue share.
        speaking: Where texts go out.
        orders: Where an order that a model proposes is judged.
        documents: Where a question is looked up that no model has answered.
        offers: Where an order is offered for a sentence that no one has understood.
    """

    def __init__(
        self, talk: Talk, *, speaking: SpeechOutput, orders: OrderJudge, documents: DocumentLookup, offers: OrderOffers
    ) -> None:
        self._talk, self._speaking, self._orders, self._documents = talk, speaking, orders, documents
        self._offers = offers
        self._turns = ModelTurns(talk.settings)
        self._claims = Claims(talk.settings.language)
        self._unread = UnreadAnswers(talk.answers)
        self._spoken: dict[str, int] = {}
        """Key of a speech → the request whose text it is."""

    def ask(self, utterance: Utterance) -> None:
        """A sentence that the rules do not know."""
        if not self._talk.settings.has_model:
            self._look_up(utterance)
            return
        if self._turns.turn is None:
            self._begin(utterance)
            self._acknowledge(utterance, is_waiting=False)
            return
        is_interrupted, dropped = self._turns.late(utterance)
        for each in dropped:
            self._talk.note("dropped", number=each.number, policy=self._talk.settings.late)
            if each == utterance or each.speaker != utterance.speaker:
                form = "late_full" if each == utterance else "late_dropped"
                self._speaking.reply(form, each, text=cut(each.text, 80))
        if is_interrupted:
            self._drop()
            self._next()
        if utterance not in dropped:
            self._acknowledge(utterance, is_waiting=not is_interrupted)

    def _acknowledge(self, utterance: Utterance, *, is_waiting: bool) -> None:
        """Acknowledge a sentence at once: a model may take its time, or hang."""
        form = "filler" if utterance.is_spoken else "model_waits" if is_waiting else "model_asked"
        self._speaking.acknowledge(form, utterance)

    def _look_up(self, utterance: Utterance, *, is_silent: bool = False) -> None:
        """The documents come last; where they have no answer either, no one knows one."""
        self._documents.ask(utterance, lambda: self._do_not_know(utterance, is_silent=is_silent))

    def _do_not_know(self, utterance: Utterance, *, is_silent: bool) -> None:
        """Reply that no one knows an answer.

        Args:
            utterance: The sentence.
            is_silent: The model was asked, and gave no reply.
        """
        language, view = self._talk.language, self._talk.view
        is_first = not self._talk.settings.has_model and not any(each.way == "unknown" for each in self._talk.turns)
        if view.questions and not utterance.is_spoken and may(utterance.role, "answer", self._talk.settings):
            text = self._unread.answer(utterance.text, view, is_first=False)
            text = f"{text} {language.text('unknown_answer', options=options_text(view.questions, language))}"
        else:
            text = self._unread.answer(utterance.text, view, is_first=is_first)
        if is_silent:
            text = f"{language.text('model_silent')} {text}"
        self._speaking.answer(text, utterance, way="unknown")
        if not self._unread.knows(utterance.text, view):
            self._offers.offer(utterance)

    def _begin(self, utterance: Utterance) -> None:
        talk, turn = self._talk, self._turns.begin(utterance, self._talk.now)
        allowed = talk.settings.may.get(utterance.role, frozenset())
        history = tuple(each for each in talk.turns if each.number < utterance.number)
        talk.put(
            AskModel(
                turn.number,
                cut(utterance.text, LONGEST),
                utterance.role,
                utterance.channel,
                utterance.author,
                history,
                talk.answers.status(talk.view),
                order_forms(talk.view, frozenset(allowed)),
                talk.now,
                turn.until,
            )
        )
        talk.note("asked_model", request=turn.number, number=utterance.number)

    # -- the reply -----------------------------------------------------------------------------------------------------

    def on_text(self, reply: ModelText) -> None:
        """A piece of a reply."""
        turn = self._turns.take(reply.number)
        if turn is None:
            return
        stream, whole = turn.stream.add(reply.text, is_end=reply.is_end)
        turn = turn._replace(stream=stream)
        for sentence in whole:
            turn = self._let_out(sentence, turn)
        if reply.order is not None and not turn.has_order:
            turn = self._propose(reply.order, turn)
        turn = turn._replace(received=turn.received + max(1, len(reply.text)))
        self._turns.keep(turn)
        if reply.is_end or reply.failed or turn.is_full:
            self._end(turn, reply)

    def _let_out(self, sentence: str, turn: ModelTurn) -> ModelTurn:
        """A sentence goes out, or the status in its place, once a reply."""
        if turn.is_full:
            return turn
        utterance, sentence = turn.utterance, cut(sentence, LONGEST_NOTE)
        self._talk.note("model_text", request=turn.number, text=sentence)
        why = self._claims.why_replaced(sentence, self._talk.view)
        why = why or self._claims.why_assented(sentence, utterance.text, self._talk.view)
        joined = self._claims.begun(turn.before, sentence, self._talk.view)
        if joined and not why:
            why = self._claims.why_replaced(joined, self._talk.view)
        if why:
            return self._replace(sentence, why, turn)
        speech = self._speaking.answer(sentence, utterance, way="model")
        self._spoken[speech.key] = turn.number
        return turn._replace(spoken=turn.spoken + 1, before=joined or sentence)

    def _replace(self, text: str, why: ClaimKind, turn: ModelTurn) -> ModelTurn:
        """The status goes out in the place of a claim, once a reply."""
        self._talk.note("replaced", request=turn.number, text=text, by=why)
        if not turn.is_replaced:
            status = self._talk.answers.status(self._talk.view)
            self._speaking.answer(status, turn.utterance)
        return turn._replace(spoken=turn.spoken + 1, before="", is_replaced=True)

    def _propose(self, order: object, turn: ModelTurn) -> ModelTurn:
        """An order that the model read in the person's sentence; it is judged as that person's, its texts as claims."""
        talk = self._talk
        sense, persons = proposed(order, talk.view), [each.text for each in talk.turns if each.by != "robot"]
        texts = own_texts(sense, persons, talk.view, talk.language) if sense is not None else []
        claims = ((text, why) for text in texts if (why := self._claims.why_refused(text, talk.view)))
        for text, why in claims:
            return self._replace(cut(text, LONGEST_NOTE), why, turn)
        if sense is None:
            shown = cut(repr(plain(order)), LONGEST_NOTE)
            self._talk.note("refused", number=turn.utterance.number, order=shown, by="form")
        else:
            self._orders.take(sense, turn.utterance, mapper="model")
        return turn._replace(has_order=sense is not None)

    def _end(self, turn: ModelTurn, reply: ModelText) -> None:
        if reply.failed:
            self._talk.note("dropped", request=turn.number, failed=cut(reply.failed, LONGEST_NOTE))
        if not reply.is_end:
            self._talk.put(DropModel(turn.number))
        if not turn.spoken and not turn.has_order:
            self._look_up(turn.utterance, is_silent=bool(reply.failed))
        self._turns.keep(None)
        self._next()

    def _next(self) -> None:
        if self._turns.waiting and self._turns.turn is None:
            self._begin(self._turns.waiting.popleft())

    def _drop(self) -> None:
        if self._turns.turn is not None:
            self._talk.put(DropModel(self._turns.turn.number))
            self._turns.keep(None)

    def drop_all(self) -> None:
        """After a stop: neither the reply nor what waits is wanted."""
        for each in self._turns.waiting:
            self._talk.note("dropped", number=each.number, policy="stop")
        self._turns.waiting.clear()
        self._drop()

    def on_speech_end(self, end: SpeechEnd) -> None:
        """A person who interrupts the model's text does not want the rest of it."""
        request = self._spoken.pop(end.key, None)
        turn = self._turns.turn
        if end.result == "cut" and turn is not None and turn.number == request:
            self._drop()
            self._next()

    def on_time(self) -> None:
        """A reply that did not come in time is not waited for."""
        turn = self._turns.turn
        if turn is not None and self._talk.now >= turn.until:
            self._end(turn._replace(stream=SentenceStream()), ModelText(turn.number, failed="no reply in time"))

    def wake_at(self) -> float | None:
        """When the reply is not waited for any longer."""
        return None if self._turns.turn is None else self._turns.turn.until
