# SPDX-License-Identifier: Apache-2.0
"""Sentences that the rules understand: questions of state are answered, orders and confirmations are handed on.

Rule: nothing is ordered here; whatever a sentence may order goes to the `OrderJudge`, which judges it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import Literal

from rai_missions.conversation.answers.state_answers import Asker
from rai_missions.conversation.dialogue.confirmation import CROSSING_S
from rai_missions.conversation.dialogue.document_lookup import DocumentLookup
from rai_missions.conversation.dialogue.given_orders import LONGEST_REASON, SPEAKERS, remember
from rai_missions.conversation.dialogue.model_replies import ModelReplies
from rai_missions.conversation.dialogue.order_judge import EarlierOrder, OrderJudge
from rai_missions.conversation.dialogue.order_offers import OrderOffers
from rai_missions.conversation.dialogue.order_rules import forbidden, may, must_confirm
from rai_missions.conversation.dialogue.speech_output import SpeechOutput
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.grammar.corrections import Draft
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.names import option_place
from rai_missions.conversation.grammar.senses import STOP, Sense, is_fault, joined
from rai_missions.conversation.grammar.suggestions import Suggestions
from rai_missions.conversation.grammar.unread_sentence import is_question
from rai_missions.conversation.inputs import Utterance
from rai_missions.conversation.language.language import spoken
from rai_missions.conversation.language.values import is_known
from rai_missions.conversation.outputs import TalkTurn
from rai_missions.conversation.view import StatusView
from rai_missions.engine.decision import Question
from rai_missions.event import Role
from rai_missions.profile.conversation import ORDERS
from rai_missions.redaction import cut

__all__ = ("Handling", "SentenceReader")

Handling = Literal["handled", "stopped", "unknown"]
"""What became of a sentence: rules answered it, it stopped the run, or the rules do not know it."""
DECISIONS = ("yes", "no")
"""What a sentence may mean for what was read back."""
RECALL_S = 180.0
"""Seconds for which a sentence may be about what was named in another."""
LATE_S = 30.0
"""Seconds after the end of a question, or after a start was taken, within which a sentence may be meant for it."""


class SentenceReader:
    """Reads sentences by the grammar, and finds the one thing that each means.

    Args:
        talk: What the parts of the dialogue share.
        grammar: Reads the sentences.
        suggestions: Finds orders in other talk.
        speaking: Where texts go out.
        orders: Where orders, and what confirms them, are judged.
        documents: Where a question is looked up that has no answer now.
        models: Where a question is answered that is joined to an order, and that no rule reads.
        offers: Where an order is offered for a question that has no answer.
    """

    def __init__(
        self,
        talk: Talk,
        grammar: Grammar,
        suggestions: Suggestions,
        *,
        speaking: SpeechOutput,
        orders: OrderJudge,
        documents: DocumentLookup,
        models: ModelReplies,
        offers: OrderOffers,
    ) -> None:
        self._talk, self._speaking, self._orders, self._documents = talk, speaking, orders, documents
        self._models, self._offers = models, offers
        self._grammar, self._suggestions = grammar, suggestions
        self._certain_words = lru_cache(talk.settings.history)(self._words_of)
        """Of turns, which are read for each sentence that follows them."""
        self._unfinished = dict[tuple[str, str], EarlierOrder]()
        """Speaker → the order that its last sentence had refused or dropped, and which its next may complete."""
        self._closed, self._closed_at = tuple[Question, ...](), float("-inf")

    def follow(self, before: StatusView) -> None:
        """The run's status is new: questions may have closed."""
        if closed := tuple(each for each in before.questions if self._talk.view.question(each.number) is None):
            self._closed, self._closed_at = closed, self._talk.now

    def is_stop(self, utterance: Utterance) -> bool:
        """Whether one of its readings orders to stop."""
        return _stop_in(self._senses(utterance)) is not None

    def _senses(self, utterance: Utterance) -> list[tuple[Sense, ...]]:
        """What each of its readings may mean."""
        readings, draft = utterance.readings or (utterance.text,), self._draft(utterance)
        view, is_typed, earlier = self._talk.view, not utterance.is_spoken, self._earlier(utterance)
        return [self._grammar.senses(text, view, draft, is_typed=is_typed, earlier=earlier) for text in readings]

    def _earlier(self, utterance: Utterance) -> list[list[str]]:
        """The words of its speaker and of the robot's replies there, in the last minutes, the last at the end."""
        now = self._talk.now
        turns = (each for each in self._talk.turns if now - each.at < RECALL_S and each.number != utterance.number)
        own = (each for each in turns if (each.channel, each.author) in (utterance.speaker, (utterance.channel, "")))
        found = (self._certain_words(each.text) for each in own)
        return [words for words in found if words is not None]

    def _words_of(self, text: str) -> list[str] | None:
        """The words of a turn; None where they name a choice, of which none is meant."""
        words = self._talk.language.normaliser.words(text)
        return words if self._talk.starts.is_certain(words) else None

    def _draft(self, utterance: Utterance) -> Draft | None:
        """The order that this sentence may correct: its speaker's last, one that is read back, or one just taken."""
        unfinished = self._of(utterance, self._unfinished.get(utterance.speaker), self._talk.settings.confirm_s)
        if unfinished is not None:
            return Draft(unfinished, is_asked_for=True)
        if (read_back := self._orders.confirmation.order) is not None:
            return None if self._orders.confirmation.request else Draft(read_back, is_read_back=True)
        taken = self._orders.taken
        if taken is None or self._talk.now - taken.at >= LATE_S:
            return None
        return Draft(taken.sense, is_of_another=taken.speaker != utterance.speaker)

    def _of(self, utterance: Utterance, given: EarlierOrder | None, within_s: float) -> Sense | None:
        """An order, where the speaker of this sentence gave it, less than so many seconds ago."""
        if given is None or given.speaker != utterance.speaker or self._talk.now - given.at >= within_s:
            return None
        return given.sense

    def _keep(self, sense: Sense, speaker: tuple[str, str]) -> None:
        """The next sentence of this speaker may correct or complete this order."""
        remember(self._unfinished, speaker, EarlierOrder(speaker, sense, self._talk.now), SPEAKERS)

    def on_utterance(self, utterance: Utterance) -> Handling:
        """A person's sentence."""
        each = self._senses(utterance)
        self._unfinished.pop(utterance.speaker, None)
        if (stop := _stop_in(each)) is not None:
            return self._stop(stop, each, utterance)
        self._speaking.speak_due(now=True)
        if self._decides(utterance, each) or self._withdraws(utterance, each):
            return "handled"
        self._orders.confirmation.distract(utterance)
        senses = tuple(sense for sense in each[0] if sense.kind not in DECISIONS) or each[0]
        senses = senses or self._free_answer(utterance)
        if self._is_late(utterance, senses):
            self._speaking.answer(self._talk.answers.closed(self._talk.view), utterance)
            return "handled"
        senses = self._answerable(senses)
        if senses and all(self._may_be_answer(sense, utterance) for sense in senses):
            senses = self._answered_by_sense(utterance.text, utterance.role) or senses
        if all(sense.kind == "fault" for sense in senses):
            senses = self._suggested(utterance, senses) or senses
            if (stop := _stop_in([senses])) is not None:
                return self._stop(stop, each, utterance)  # it needs no confirmation
        if not senses:
            return "unknown"
        if senses[0].kind in DECISIONS:
            return self._answer_nothing(utterance)
        return self._on_senses(senses, each, utterance)

    def _stop(self, stop: Sense, each: Sequence[Sequence[Sense]], utterance: Utterance) -> Handling:
        """A sentence that orders to stop, at once; what it has besides is handled after that."""
        if not self._orders.stop(utterance):
            return "handled"
        self._name_left_out(stop, utterance)
        if stop.then:
            self._handle(joined(stop.then), utterance, self._agreeing(stop, each, utterance))
        return "stopped"

    def _agreeing(self, sense: Sense, each: Sequence[Sequence[Sense]], utterance: Utterance) -> int | None:
        """How many readings of a spoken sentence mean the same; None of a typed one."""
        agreeing = sum(any(sense.identity == other.identity for other in others) for others in each)
        return agreeing if utterance.is_spoken else None

    def _on_senses(self, senses: Sequence[Sense], each: Sequence[Sequence[Sense]], utterance: Utterance) -> Handling:
        """Handle the one thing that a sentence means.

        Args:
            senses: What the first of its readings may mean, or what was found in it.
            each: What each of its readings may mean.
            utterance: The sentence.
        """
        sense = self._chosen((*senses, *self._others(senses[0], *each)), utterance)
        if sense is not None and self._talk.settings.has_model and not self._is_answered(sense):
            return "unknown"
        if sense is not None:
            self._handle(sense, utterance, self._agreeing(sense, each, utterance))
        return "handled"

    def _decides(self, utterance: Utterance, each: Sequence[Sequence[Sense]]) -> bool:
        """Whether it is a yes or a no to what was read back, and so has been handled."""
        hesitating = [Sense("yes", is_partial=True)] if self._hesitates(utterance.text) else []
        meant = next((sense for sense in (*each[0], *hesitating) if sense.kind in DECISIONS), None)
        if meant is None or self._orders.confirmation.order is None:
            return False
        alike = [[sense for sense in others if sense.kind == meant.kind] for others in each]
        is_doubtful = meant.is_partial or any(sense.is_partial for senses in alike for sense in senses)
        self._decide(
            utterance, is_yes=meant.kind == "yes", is_agreed=len(each) > 1 and all(alike), is_doubtful=is_doubtful
        )
        return True

    def _hesitates(self, text: str) -> bool:
        """Whether a sentence is a doubt alone: `I think so`."""
        return self._talk.language.hesitating.fits(self._talk.language.normaliser.words(text))

    def _withdraws(self, utterance: Utterance, each: Sequence[Sequence[Sense]]) -> bool:
        """Whether a request is wanted no more: `forget the lobby`; `forget that` is the one it has just ordered."""
        if any(sense.kind == "order" and sense.name != "cancel" for sense in each[0]):
            return False
        requests, taken = self._orders.requests, self._of(utterance, self._orders.taken, LATE_S)
        is_own = taken is not None and bool(requests) and requests[-1].identity == taken.identity
        place = self._grammar.withdrawn(utterance.text, requests, self._talk.view, is_recent=is_own)
        if place is not None:
            self._orders.withdraw_one(place, utterance)
        return place is not None

    def _decide(self, utterance: Utterance, *, is_yes: bool, is_agreed: bool, is_doubtful: bool = False) -> None:
        """A yes or a no to what was read back; the next sentence may correct what a no has dropped."""
        dropped = self._orders.decide(utterance, is_yes=is_yes, is_agreed=is_agreed, is_doubtful=is_doubtful)
        if dropped is not None:
            self._keep(dropped, utterance.speaker)

    def _may_be_answer(self, sense: Sense, utterance: Utterance) -> bool:
        """Whether an order may be meant as an option: to resume what runs, and `wait a bit`, where this is offered."""
        if sense.name == "pause" and not utterance.is_spoken:
            return self._grammar.sentence.options.are_in(utterance.text, self._talk.view)
        return sense.name == "resume" and not self._orders.is_open(sense, utterance.role)

    def _is_late(self, utterance: Utterance, senses: Sequence[Sense]) -> bool:
        """Whether a sentence that means nothing else, but a key by its name, answers a question that just closed."""
        is_free = all(sense.kind == "question" and sense.name == "key" for sense in senses)
        return is_free and self._answers_closed(utterance, LATE_S)

    def _may_be_no_answer(self, utterance: Utterance) -> bool:
        """Whether an answer may be a question itself, or meant for a question that closed this moment."""
        return utterance.asks or self._answers_closed(utterance, CROSSING_S)

    def _answers_closed(self, utterance: Utterance, within_s: float) -> bool:
        """Whether it would have answered a question that closed less than so many seconds ago."""
        is_recent = self._talk.now - self._closed_at < within_s
        return is_recent and self._grammar.answers(utterance.text, self._closed)

    def _others(self, meant: Sense, senses: Sequence[Sense], *others: Sequence[Sense]) -> Iterator[Sense]:
        """The orders that other readings are instead, to be read back; none where what is meant is, in any case."""
        if meant.kind == "order" and not must_confirm(meant, self._talk.view, mapper="grammar", agreeing=None):
            found = {sense.identity: sense for each in others for sense in each if sense.kind == "order"}
            known = {sense.identity for sense in senses}
            yield from (sense._replace(is_partial=True) for key, sense in found.items() if key not in known)

    def _free_answer(self, utterance: Utterance) -> tuple[Sense, ...]:
        """What no rule reads, as the text that a question asks for; a model, which reads more, comes first."""
        if self._talk.settings.has_model or not may(utterance.role, "answer", self._talk.settings):
            return ()
        sense = self._grammar.free_answer(utterance.text, self._talk.view)
        return (sense,) if sense is not None else ()

    def _suggested(self, utterance: Utterance, faults: Sequence[Sense]) -> tuple[Sense, ...]:
        """What a clause of a typed sentence orders, to be read back, or asks; a model reads more, and comes first.

        Args:
            utterance: The sentence.
            faults: What the whole means, with values that do not fit; a start must have one for each.
        """
        if self._talk.settings.has_model or utterance.is_spoken:
            return ()
        text = utterance.text
        if self._orders.confirmation.order is not None:
            return () if faults else self._asked_by_sense(text)
        senses = self._answered_by_sense(text, utterance.role)
        if senses and not (faults and is_fault(senses)):
            return senses
        senses = self._grammar.without_reasons(text, self._talk.view)
        senses = senses or self._suggestions.suggested(text, self._talk.view, self._earlier(utterance))
        if not senses and not faults:
            return self._asked_by_sense(text)
        orders = [order for sense in senses for order in sense.orders]
        values = {name for order in orders for name in order.named}
        is_filled = all(each.lacks and values.issuperset(each.lacks) for each in faults)
        if not senses or not (is_filled or (orders and all(order.name != "start" for order in orders))):
            return ()
        is_allowed = not any(forbidden(sense, utterance.role, self._talk.settings) for sense in senses)
        return self._answerable(senses) if is_allowed else ()

    def _asked_by_sense(self, text: str) -> tuple[Sense, ...]:
        """The question of state that a sentence asks in words of its own."""
        asked = self._grammar.question_by_sense(text, self._talk.view)
        return (asked,) if asked is not None else ()

    def _answered_by_sense(self, text: str, role: Role) -> tuple[Sense, ...]:
        """The options that a typed sentence asks for in words of its own, where its role may answer."""
        if not self._talk.view.questions or not may(role, "answer", self._talk.settings):
            return ()
        return self._grammar.answers_by_sense(text, self._talk.view)

    def _answerable(self, senses: Sequence[Sense]) -> tuple[Sense, ...]:
        """The question, where a fact answers it; else the order that it is, too, to be read back: `where is my cup`."""
        orders = [sense._replace(is_partial=True) for sense in senses if sense.kind == "order"]
        asked = [sense for sense in senses if sense.kind == "question"]
        if not asked or not orders:
            return tuple(senses)
        is_known = any(self._talk.answers.knows(sense, self._talk.view) for sense in asked)
        return tuple(asked if is_known else orders)

    def _answer_nothing(self, utterance: Utterance) -> Handling:
        if self._talk.ends_with(utterance.channel, "model"):
            return "unknown"
        if self._talk.view.is_alive and not utterance.is_spoken and self._grammar.refuses(utterance.text):
            return self._stop(STOP, (), utterance)
        self._orders.speak_nothing(utterance)
        return "handled"

    def _chosen(self, senses: Sequence[Sense], utterance: Utterance) -> Sense | None:
        """The one sense that is meant; None where the person must decide, and is asked."""
        language = self._talk.language
        if len(senses) == 1:
            return senses[0]
        orders = (sense for sense in senses if sense.kind == "order")
        possible = [sense for sense in orders if self._orders.is_open(sense, utterance.role)]
        if len(possible) < 2:
            return possible[0] if possible else senses[0]
        answers = [sense for sense in possible if sense.name == "answer"]
        if len(answers) == 1 and all(sense.name == "pause" for sense in possible if sense not in answers):
            return answers[0]._replace(is_partial=True)  # `wait`, where this is offered
        pauses = [sense for sense in possible if sense.name == "pause"]
        if pauses and not utterance.is_spoken and all(sense.name in ("pause", "start") for sense in possible):
            return pauses[0]  # `hang on a second`, while a mission runs
        choices = language.listed([self._choice(sense) for sense in possible], "or")
        self._speaking.reply("ambiguous", utterance, choices=choices)
        return None

    def _is_answered(self, sense: Sense) -> bool:
        """Whether it is no question of the robot's own, or something answers it now; else others may know more."""
        view = self._talk.view
        if sense.kind != "question":
            return True
        return is_known(sense.key, view.keys) if sense.name == "value" else self._talk.answers.knows(sense, view)

    def _choice(self, sense: Sense) -> str:
        language, question = self._talk.language, self._talk.view.question(sense.question)
        if sense.name != "answer" or question is None:
            return language.text("choice_order", order=language.word("order_names", sense.name))
        return language.text(
            "choice_option", number=option_place(sense.option, question.options), option=spoken(sense.option)
        )

    def _handle(self, sense: Sense, utterance: Utterance, agreeing: int | None) -> None:
        """Answer what a sentence asks, and hand on what it orders."""
        for asked in sense.asked:
            self._answer(asked, utterance)
        if sense.orders:
            self._order(joined(sense.orders)._replace(rest=sense.rest), utterance, agreeing)
        elif not sense.asked:
            self._react(sense, utterance, agreeing)

    def _order(self, sense: Sense, utterance: Utterance, agreeing: int | None) -> None:
        if order := forbidden(sense, utterance.role, self._talk.settings):
            self._orders.refuse_permission(order, utterance)
            return
        if sense.rest:
            self._name_unread(sense.rest, utterance)
        if sense.name == "pause":
            self._name_left_out(sense, utterance)
        if sense.name == "answer" and self._may_be_no_answer(utterance):
            sense = sense._replace(is_partial=True)  # it is read back
        self._orders.take(sense, utterance, mapper="grammar", agreeing=agreeing)

    def _name_unread(self, rest: str, utterance: Utterance) -> None:
        """A part of a sentence that orders is left out: a value in it does not fit, or no rule reads it.

        A question is for the model, or for the documents.
        """
        found, part = self._grammar.senses(rest, self._talk.view), utterance._replace(text=rest)
        if is_fault(found):
            self._speaking.answer(found[0].fault, utterance)
        elif self._talk.settings.has_model and is_question(rest, self._talk.language):
            self._models.ask(part)
        else:
            named = cut(rest, LONGEST_REASON)
            self._documents.ask(part, lambda: self._speaking.reply("unread_rest", utterance, rest=named))

    def _name_left_out(self, sense: Sense, utterance: Utterance) -> None:
        """What a typed stop or pause has besides counts for nothing: the person is informed."""
        text = self._grammar.unrepeated(utterance.text)
        left = "" if utterance.is_spoken else self._suggestions.left_out(text, sense, self._talk.view)
        if left and not sense.rest:
            self._speaking.reply("left_out", utterance, rest=cut(left, LONGEST_REASON))

    def _react(self, sense: Sense, utterance: Utterance, agreeing: int | None) -> None:
        """Handle what is neither a question nor an order that can be judged."""
        if sense.kind == "quiet":
            self._speaking.silence(is_total=False)
        elif sense.kind == "withdraw":
            self._orders.withdraw(utterance)
        elif sense.kind == "again":
            self._again(utterance, agreeing)
        elif sense.kind == "other":
            self._other(sense, utterance)
        elif not may(utterance.role, sense.name, self._talk.settings):
            self._orders.refuse_permission(sense.name, utterance)
        else:
            self._talk.note("refused", number=utterance.number, order=sense.name, why=sense.fault, by="grammar")
            self._speaking.answer(sense.fault, utterance)
            self._keep(sense, utterance.speaker)

    def _answer(self, sense: Sense, utterance: Utterance) -> None:
        pending, settings = self._orders.confirmation.order, self._talk.settings
        if sense.name == "repeat" and pending is not None and may(utterance.role, pending.name, settings):
            self._orders.confirmation.ask_again(utterance)
            return
        if self._is_answered(sense):
            self._speak_answer(sense, utterance)
        else:
            self._documents.ask(utterance, lambda: self._answer_unknown(sense, utterance))

    def _answer_unknown(self, sense: Sense, utterance: Utterance) -> None:
        """What is known of it is spoken; the robot may look for what no fact names: `where is my lamp?`."""
        self._speak_answer(sense, utterance)
        self._offers.offer_by_names(utterance)

    def _speak_answer(self, sense: Sense, utterance: Utterance) -> None:
        text = self._talk.answers.answer(sense, self._talk.view, self._asker(utterance))
        self._speaking.answer(text, utterance)

    def _again(self, utterance: Utterance, agreeing: int | None) -> None:
        """The speaker's last start, read back; where there is none, or one is asked about, what was spoken."""
        last = self._orders.given.last_start_of(utterance.speaker)
        if last is None or self._orders.confirmation.order is not None:
            self._answer(Sense("question", "repeat"), utterance)
        else:
            self._orders.take(last, utterance, mapper="grammar", agreeing=agreeing)

    def _other(self, sense: Sense, utterance: Utterance) -> None:
        """Ask which order is meant, where it is another one than was read back, or asked for last."""
        pending = self._orders.confirmation.order
        if pending is not None:
            self._decide(utterance, is_yes=False, is_agreed=True)
        if sense.fault and self._orders.confirmation.order is None:
            self._speaking.answer(sense.fault, utterance)
            self._keep(sense, utterance.speaker)
        elif pending is None:
            self._orders.speak_nothing(utterance)

    def _asker(self, utterance: Utterance) -> Asker:
        language, settings = self._talk.language, self._talk.settings
        names = tuple(language.word("order_names", each) for each in ORDERS if may(utterance.role, each, settings))
        ordered = self._orders.given.ordered_by(utterance.speaker)
        last = next((each.text for each in reversed(self._talk.turns) if _is_spoken(each, utterance)), "")
        stopping_by, last_end = self._orders.given.stopping_by, self._speaking.reports.last_end
        words = tuple(language.normaliser.words(utterance.text))
        return Asker(ordered, self._orders.waiting, names, stopping_by, last, last_end, words)


def _stop_in(each: Sequence[Sequence[Sense]]) -> Sense | None:
    """The stop that one of the readings is, with what follows it; None where none is."""
    return next((sense for senses in each for sense in senses if sense.is_stop), None)


def _is_spoken(turn: TalkTurn, to: Utterance) -> bool:
    """Whether the rules have spoken it to the speaker of a sentence, or to all."""
    return turn.by == "robot" and turn.way in ("rules", "unknown") and turn.channel in ("", to.channel)
