# SPDX-License-Identifier: Apache-2.0
"""Orders that were given out, each until it is known what became of it.

Rule: this is the only place that gives out an `Order`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import TypeVar

from rai_missions.conversation.dialogue.request_queue import JudgedOrder, order_data
from rai_missions.conversation.dialogue.speech_output import SpeechOutput
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.inputs import OrderEnd, OrderResult, Utterance
from rai_missions.conversation.language.language import spoken
from rai_missions.conversation.language.run_words import state_of_run
from rai_missions.conversation.outputs import Order
from rai_missions.planning.text.normalise import LONGEST
from rai_missions.redaction import cut

__all__ = ("LONGEST_REASON", "SPEAKERS", "STOPPING", "GivenOrders", "remember")

K = TypeVar("K")
V = TypeVar("V")
REMEMBERED, SPEAKERS = 10, 100
"""Orders of one speaker that it can ask about, and orders under way; speakers that are remembered."""
STARTING_S = 30.0
"""Seconds that an ordered start may take until the run is seen; then the next request is possible."""
LONGEST_REASON = 200
"""Characters of a reason that is spoken."""
STOPPING = frozenset({"stop", "pause", "cancel"})
"""Orders after which the mission does not continue by itself."""


class GivenOrders:
    """What was given out, by whom, and what became of it.

    Args:
        talk: What the parts of the dialogue share.
        speaking: Where texts go out.
    """

    def __init__(self, talk: Talk, speaking: SpeechOutput) -> None:
        self._talk, self._speaking = talk, speaking
        self._count = 0
        self._under_way: dict[int, JudgedOrder] = {}
        self._ordered: dict[tuple[str, str], tuple[str, ...]] = {}
        self._starts: dict[tuple[str, str], Sense] = {}
        """Speaker → the last start that it ordered."""
        self.taking_until = self._starting_until = float("-inf")
        """`taking_until`: so long the run may take to follow the last of them."""

    @property
    def is_starting(self) -> bool:
        """Whether a start was given out, and its run is not seen yet."""
        return self._talk.now < self._starting_until

    def end_starting(self) -> None:
        """The run that was to start is seen, or comes no more."""
        self._starting_until = float("-inf")

    def ordered_by(self, speaker: tuple[str, str]) -> tuple[str, ...]:
        """The last orders of a speaker that were given out, in words, oldest first."""
        return self._ordered.get(speaker, ())

    def last_start_of(self, speaker: tuple[str, str]) -> Sense | None:
        """The last start that a speaker ordered."""
        return self._starts.get(speaker)

    @property
    def stopping_by(self) -> str:
        """Who gave an order to stop, pause or cancel that the run has not taken yet; empty where there is none."""
        stopping = (each for each in self._under_way.values() if each.sense.name in STOPPING)
        return next((each.utterance.by for each in stopping), "")

    def put(self, judged: JudgedOrder) -> None:
        """Give the order out."""
        self._count += 1
        self.taking_until = self._talk.now + STARTING_S
        sense, utterance = judged.sense, judged.utterance
        if sense.name == "start":
            self._starting_until = self._talk.now + STARTING_S
            remember(self._starts, utterance.speaker, sense, SPEAKERS)
        remember(self._under_way, self._count, judged, REMEMBERED)
        orders = (*self.ordered_by(utterance.speaker), judged.words)[-REMEMBERED:]
        remember(self._ordered, utterance.speaker, orders, SPEAKERS)
        self._talk.note(
            "ordered",
            order_number=self._count,
            number=utterance.number,
            order=order_data(sense),
            role=utterance.role,
            mapper=judged.mapper,
            confirmed=judged.confirmed,
        )
        self._talk.put(
            Order(
                number=self._count,
                name=sense.name,  # type: ignore[arg-type]
                role=utterance.role,
                channel=utterance.channel,
                author=utterance.author,
                mission=sense.mission,
                arguments=dict(sense.arguments),
                question=sense.question,
                option=sense.option,
                parameters=dict(sense.parameters),
                mapper=judged.mapper,
                sentence=cut(utterance.text, LONGEST),
                confirmed=judged.confirmed,
                at=self._talk.now,
            )
        )

    def on_end(self, end: OrderEnd) -> None:
        """What became of an order; a refusal is reported."""
        judged = self._under_way.pop(end.number, None)
        if judged is None:
            return
        why = cut(end.result.refused, LONGEST_REASON)
        self._talk.note("performed", order_number=end.number, order=judged.sense.name, refused=why)
        if why:
            self.taking_until = float("-inf")
        if why and judged.sense.name == "start":
            self._starting_until = float("-inf")
        if why and not judged.is_reported:
            words = self._reason(end.result, judged.sense, why)
            self._speaking.reply("refused", judged.utterance.unnumbered, order=judged.words, why=words.rstrip("."))

    def _reason(self, result: OrderResult, sense: Sense, why: str) -> str:
        """A refusal in the language of the conversation."""
        language, name = self._talk.language, spoken(result.name or sense.option)
        state = state_of_run(self._talk.view, language)
        return language.text(f"refused_{result.kind or 'other'}", why=why, state=state, name=name)

    def await_earlier(self, answers: Sequence[Order]) -> None:
        """Report, to every channel, if one of these answers is refused, which a program before this one gave out."""
        talk = self._talk
        for order in answers:
            sense = Sense("order", "answer", question=order.question, option=order.option, parameters=order.parameters)
            utterance = Utterance("", order.role, order.channel, order.author, talk.now)
            words = talk.order_words(sense)
            self._under_way[order.number] = JudgedOrder(sense, utterance, order.mapper, words)


def remember(known: dict[K, V], key: K, value: V, most: int) -> None:
    """Note what is newest, and forget what is older than so many others."""
    known.pop(key, None)
    known[key] = value
    for old in list(known)[:-most]:
        del known[old]
