# SPDX-License-Identifier: Apache-2.0
"""A dialogue: the state machine that sentences, a run's status and a model's text drive, and that speaks and orders.

Rule: it never waits. Each input returns at once with all outputs that follow from it, in the order to perform them.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any, Self

from rai_missions.conversation.dialogue.document_lookup import DocumentLookup
from rai_missions.conversation.dialogue.model_replies import ModelReplies
from rai_missions.conversation.dialogue.order_judge import OrderJudge
from rai_missions.conversation.dialogue.order_offers import OrderOffers
from rai_missions.conversation.dialogue.sentence_reader import SentenceReader
from rai_missions.conversation.dialogue.speech_output import SpeechOutput
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.grammar.grammar import Grammar
from rai_missions.conversation.grammar.likeness import Likeness, WordLikeness
from rai_missions.conversation.grammar.nearest_orders import NearestOrders
from rai_missions.conversation.grammar.suggestions import Suggestions
from rai_missions.conversation.inputs import FoundQuotes, ModelText, OrderEnd, SpeechEnd, Utterance
from rai_missions.conversation.outputs import Order, Output, TalkTurn
from rai_missions.conversation.settings import Settings
from rai_missions.conversation.view import StatusView

__all__ = ("Dialogue",)

SETTINGS, NO_RUN, WORDS = Settings(), StatusView(), WordLikeness()


class Dialogue:
    """One conversation of a robot with all who talk to it. Not for several threads at once.

    Args:
        settings: What the profile sets.
        view: The run as it is now.
        likeness: Compares a sentence that no rule reads with the phrases of orders.

    Raises:
        UsageError: There is no language of the settings' code.
    """

    def __init__(self, settings: Settings = SETTINGS, view: StatusView = NO_RUN, likeness: Likeness = WORDS) -> None:
        self._talk = Talk(settings, view)
        self._speaking = SpeechOutput(self._talk)
        self._orders = OrderJudge(self._talk, self._speaking)
        self._documents = DocumentLookup(self._talk, self._speaking)
        grammar = Grammar(self._talk.language, self._talk.starts, settings.questions)
        suggestions = Suggestions(grammar.sentence)
        nearest = NearestOrders(grammar.sentence, self._talk.starts, suggestions, likeness)
        offers = OrderOffers(self._talk, self._orders, nearest)
        self._models = ModelReplies(
            self._talk, speaking=self._speaking, orders=self._orders, documents=self._documents, offers=offers
        )
        self._sentences = SentenceReader(
            self._talk,
            grammar,
            suggestions,
            speaking=self._speaking,
            orders=self._orders,
            documents=self._documents,
            models=self._models,
            offers=offers,
        )

    @property
    def settings(self) -> Settings:
        return self._talk.settings

    @property
    def view(self) -> StatusView:
        """The run as it was last given."""
        return self._talk.view

    @property
    def wake_at(self) -> float | None:
        """The instant at which `on_time` has something to do, on the dialogue's clock; None: nothing is due."""
        parts = (self._speaking, self._orders, self._models, self._documents)
        return min((at for each in parts if (at := each.wake_at()) is not None), default=None)

    @property
    def asks_to_begin(self) -> bool:
        """Whether a mission is over and a start, of a request or ordered since, waits for a person's yes."""
        return self._orders.asks_to_begin

    @property
    def looks_up(self) -> bool:
        """Whether a question is being looked up in the documents."""
        return self._documents.looks_up

    @property
    def history(self) -> tuple[TalkTurn, ...]:
        """The last turns, oldest first; bounded by the settings."""
        return tuple(self._talk.turns)

    @property
    def unspoken(self) -> tuple[str, ...]:
        """The identities of the reports that were not spoken whole; a page shows them so."""
        return self._speaking.reports.unspoken()

    def on_utterance(self, utterance: Utterance, view: StatusView) -> tuple[Output, ...]:
        """A person's sentence.

        Args:
            utterance: The sentence, with the role of its door.
            view: The run at this moment: ages and states are as new as this.
        """
        utterance = utterance.without_secrets
        self._begin(utterance.at)
        self._follow(view)
        if self._talk.is_new(utterance) or self._sentences.is_stop(utterance):
            numbered = self._talk.add_person(utterance)
            handling = self._sentences.on_utterance(numbered)
            if handling == "unknown":
                self._models.ask(numbered)
            elif handling == "stopped":
                self._models.drop_all()
                self._documents.drop_all()
        return self._end()

    def on_status(self, view: StatusView, at: float) -> tuple[Output, ...]:
        """The run has changed: each change of `Status`, of the open question, and of the run itself."""
        self._begin(at)
        self._follow(view)
        return self._end()

    def on_lost_requests(self, requests: Sequence[str], view: StatusView, at: float) -> tuple[Output, ...]:
        """The program before this one was killed, and with it these requests, in words: they are reported."""
        self._begin(at)
        self._orders.lose(requests, view.run)
        self._follow(view)
        return self._end()

    def on_earlier_answers(self, answers: Sequence[Order], view: StatusView, at: float) -> tuple[Output, ...]:
        """The program before this one was killed while its run kept these answers; an `OrderEnd` of each must follow.

        Args:
            answers: Each under a number that no order of this dialogue has.
            view: The run as it is resumed, with their questions.
            at: Now.
        """
        self._begin(at)
        self._follow(view)
        self._orders.given.await_earlier(answers)
        return self._end()

    def on_last_run(self, at: float) -> tuple[Output, ...]:
        """No run follows the one that there is: the program ends with it."""
        self._begin(at)
        self._orders.end_starts()
        return self._end()

    def on_mission_speech(self, text: str, at: float) -> tuple[Output, ...]:
        """The mission's own effect `say`: its author's sentence, spoken as it is."""
        self._begin(at)
        self._speaking.speak(text, priority="chatter")
        return self._end()

    def on_model(self, reply: ModelText) -> tuple[Output, ...]:
        """A piece of a model's reply."""
        self._begin(reply.at)
        self._models.on_text(reply)
        return self._end()

    def on_found(self, found: FoundQuotes) -> tuple[Output, ...]:
        """What the robot's documents have on a question."""
        self._begin(found.at)
        self._documents.on_found(found)
        return self._end()

    def on_speech_end(self, end: SpeechEnd) -> tuple[Output, ...]:
        """A speech has ended."""
        self._begin(end.at)
        if self._speaking.on_end(end):
            self._orders.on_speech_end(end)
            self._models.on_speech_end(end)
        return self._end()

    def on_order_end(self, end: OrderEnd) -> tuple[Output, ...]:
        """An order was carried out, or refused by what should do so."""
        self._begin(end.at)
        self._orders.given.on_end(end)
        return self._end()

    def on_speaker(self, *, is_alive: bool, at: float) -> tuple[Output, ...]:
        """The speaker died, or speaks again: what it did not speak follows then, marked as repeated."""
        self._begin(at)
        self._speaking.on_speaker(is_alive=is_alive)
        return self._end()

    def on_time(self, at: float) -> tuple[Output, ...]:
        """Time has passed: confirmations expire, a model is not waited for any longer, an owed report follows."""
        self._begin(at)
        return self._end()

    def _begin(self, at: float) -> None:
        self._talk.pass_time(at)
        self._orders.on_time()
        self._models.on_time()
        self._documents.on_time()
        self._speaking.on_time()

    def _end(self) -> tuple[Output, ...]:
        self._orders.begin_requests()  # last of all: a stop in this input drops them
        return self._talk.taken()

    def _follow(self, view: StatusView) -> None:
        before = self._talk.follow(view)
        self._speaking.follow()
        self._speaking.speak_due(now=False)
        self._sentences.follow(before)
        self._orders.follow(before)

    def snapshot(self) -> dict[str, Any]:
        """What must outlive the process, as JSON: which reports were spoken, and which are owed."""
        return {"format": 1, "reports": self._speaking.reports.snapshot()}

    @classmethod
    def restore(cls, saved: Mapping[str, Any], settings: Settings = SETTINGS, view: StatusView = NO_RUN) -> Self:
        """The dialogue of a process that ended: nothing is confirmed or queued; owed reports follow, as repeated."""
        made = cls(settings, view)
        made._speaking.reports.restore(saved.get("reports", []))
        return made
