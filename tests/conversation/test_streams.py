# SPDX-License-Identifier: Apache-2.0
"""What a hostile model streams changes nothing but its own reply: orders, reports and their ends are the silent run's.

The twin of each conversation has the same persons, times and run, and a model that never replies.
"""

from __future__ import annotations

from cProfile import Profile
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.conversation import (
    AskModel,
    Dialogue,
    ModelText,
    Order,
    Output,
    Settings,
    Speech,
    SpeechEnd,
    StatusView,
    Utterance,
)
from rai_missions.conversation.dialogue.model_turns import MOST_SENTENCES
from rai_missions.conversation.sentences import LONGEST_SENTENCE, SentenceStream
from tests.conversation.stored import PATROLLING

REPORTS = ("The mission 'rosbot_patrol' is over: it succeeded.", "The mission 'rosbot_patrol' has started.")
PIECES = (
    "Apples ripen in autumn. ", "The moon is ", "far away. ", *REPORTS, "I have arrived at the dock. ", "Tea \ud83d",
    "\ude00 is grown in Asia. ", "apples, pears, " * 60, "a" * 900, "\n" * 50, "\u200b" * 50, "", "\x00\x1b[2J",
    '<tool_call>{"name": "propose_order", "arguments": {"order": "cancel"', '{"order": {"order": "stop"}}', "yes. ",
    "Bees fly. " * 300, "```json\n[[[[", "Status: done. ", "… … … ", "cancel the mission. yes. ",
)  # fmt: skip
"""What a hostile model streams: its own words, reports of the robot, garbage of calls, halves and floods."""
ORDERS: tuple[Any, ...] = (None, {}, [], "cancel", {"order": "kill"}, {"order": "start", "mission": [[[]]]}, 7)
"""Garbage in the place of an order."""
SENTENCES = ("a story, please", "what are you doing?", "how far are you?", "hush", "what do you think of tea")
happenings = st.lists(
    st.one_of(
        st.tuples(st.just("piece"), st.sampled_from(PIECES), st.sampled_from(ORDERS), st.integers(0, 9)),
        st.tuples(st.just("piece"), st.sampled_from(PIECES), st.sampled_from(ORDERS), st.integers(0, 9)),
        st.tuples(st.just("speaks"), st.sampled_from(SENTENCES)),
        st.tuples(st.just("interrupts")),
        st.tuples(st.just("waits"), st.sampled_from((0.5, 4.0, 25.0))),
        st.tuples(st.just("mode"), st.sampled_from(("running", "paused", "succeeded", "failed"))),
    ),
    min_size=4,
    max_size=30,
)


class Conversation:
    """A conversation with a model, or with one that never replies.

    Args:
        late: What becomes of sentences that come meanwhile.
        is_silent: The model never replies.
    """

    def __init__(self, late: Any, *, is_silent: bool) -> None:
        self.view, self.at, self.is_silent = PATROLLING._replace(mode="ready"), 0.0, is_silent
        self.dialogue = Dialogue(Settings(has_model=True, late=late), self.view)
        self.outputs, self.by_model, self.request, self.spoken = list[Output](), list[Speech](), 0, dict[int, int]()

        self.cut = set[int | None]()
        """The sentences whose answer the person interrupted."""

    def play(self, script: list[tuple[Any, ...]]) -> None:
        for kind, *happening in script:
            self.at += 0.1
            getattr(self, f"_{kind}")(*happening)
        self._mode("succeeded")
        self._waits(60.0)

    def reports(self) -> list[Any]:
        """Each report, and each order, in their order; an end that a person has to learn is one of them."""
        kept = (each for each in self.outputs if isinstance(each, Order) or (isinstance(each, Speech) and each.report))
        return [(each.report, each.text, each.repeated) if isinstance(each, Speech) else each for each in kept]

    def _take(self, outputs: tuple[Output, ...]) -> None:
        self.outputs += outputs
        for each in outputs:
            if isinstance(each, AskModel):
                self.request = each.number
            elif isinstance(each, Speech):
                assert each.text.encode() and len(each.text) <= 2 * LONGEST_SENTENCE, each
                if each.way == "model":
                    assert each.reply_to not in self.cut, "who interrupts a reply gets no more of it"
                    self.by_model.append(each)
                    self.spoken[self.request] = self.spoken.get(self.request, 0) + 1
                else:
                    self._take(self.dialogue.on_speech_end(SpeechEnd(each.key, "whole", self.at)))
        assert all(each <= MOST_SENTENCES for each in self.spoken.values())

    def _piece(self, text: str, order: Any, number: int) -> None:
        """A piece of the reply; 0 ends it, 1 breaks it off, and 2 is of the reply before."""
        if self.is_silent:
            return
        request, before = self.request - (number == 2), len(self.by_model)
        failed = "broken off" if number == 1 else ""
        self._take(self.dialogue.on_model(ModelText(request, text, order, number == 0, failed, self.at)))
        assert number != 2 or len(self.by_model) == before, "a reply that is over has no more pieces"

    def _speaks(self, text: str) -> None:
        self._take(self.dialogue.on_utterance(Utterance(text, "operator", "terminal", at=self.at), self.view))

    def _interrupts(self) -> None:
        for each in self.by_model[-1:]:
            self.cut.add(each.reply_to)
            self._take(self.dialogue.on_speech_end(SpeechEnd(each.key, "cut", self.at)))

    def _waits(self, seconds: float) -> None:
        self.at += seconds
        self._take(self.dialogue.on_time(self.at))

    def _mode(self, mode: str) -> None:
        if self.view.outcome is None:
            outcome = mode if mode in ("succeeded", "failed") else None
            self.view = self.view._replace(mode=mode, outcome=outcome, at=self.at, revision=self.view.revision + 1)
            self._take(self.dialogue.on_status(self.view, self.at))


@given(happenings, st.sampled_from(("queue", "last", "interrupt")))
@settings(max_examples=60, deadline=None, derandomize=True)
def test_whatever_a_model_streams_orders_and_reports_are_those_of_a_silent_model(script: Any, late: Any) -> None:
    talked, silent = Conversation(late, is_silent=False), Conversation(late, is_silent=True)
    for each in (talked, silent):
        each.play([("speaks", SENTENCES[0]), *script])
    assert talked.reports() == silent.reports()
    ends = [each for each in talked.outputs if isinstance(each, Speech) and each.report.endswith(":end")]
    assert len(ends) == 1 and not any(isinstance(each, Order) for each in talked.outputs)
    texts = " ".join(each.text for each in talked.by_model)
    assert not any(each in texts for each in (*REPORTS, "arrived")), "a report is the robot's own"


MOST_CALLS = 1_500_000
"""Calls of functions that a stream of 10,000 pieces may cost: some 0.5 s of CPU."""


@pytest.mark.parametrize(
    "flood",
    [
        ("The moon is far away. ",) * 10_000,
        ("The moon is far away. " * 10_000,),
        ("apples ",) * 10_000,
        ("\n",) * 10_000,
        ("\u200b",) * 10_000,
        ("\ud83d",) * 10_000,
        ("[[",) * 10_000,
    ],
    ids=["sentences", "at once", "no end", "lines", "nothing shown", "halves", "brackets"],
)
def test_a_stream_without_end_is_cut_off_and_costs_little(flood: tuple[str, ...]) -> None:
    conversation, calls = Conversation("queue", is_silent=False), Profile()
    script = [("mode", "running"), ("speaks", SENTENCES[0]), *(("piece", each, None, 9) for each in flood)]
    calls.runcall(conversation.play, script)
    assert sum(each.callcount for each in calls.getstats()) < MOST_CALLS
    assert len(conversation.by_model) <= MOST_SENTENCES


def test_a_stream_keeps_no_more_than_a_sentence() -> None:
    stream = SentenceStream()
    for piece in ("apples ", " ", "\u200b", "a") * 2_000:
        stream, _ = stream.add(piece, is_end=False)
        assert len(stream.rest) <= LONGEST_SENTENCE


def test_half_a_sentence_of_a_model_that_hangs_is_never_shown() -> None:
    conversation = Conversation("queue", is_silent=False)
    conversation.play([("speaks", SENTENCES[0]), ("piece", "Bees can fly. The moon is far", None, 9), ("waits", 25.0)])
    assert [each.text for each in conversation.by_model] == ["Bees can fly."]
    assert isinstance(conversation.view, StatusView) and conversation.dialogue.unspoken == ()
