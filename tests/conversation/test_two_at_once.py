# SPDX-License-Identifier: Apache-2.0
"""Two persons at two doors talk with one run: what each has open is theirs, and what is read back is for both.

The oracle keeps its own, simpler account: of each person the order that was refused or dropped last, and of both the
one order that waits for a yes.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.conversation import (
    Dialogue,
    KeyView,
    MissionView,
    Output,
    Settings,
    Speech,
    StatusView,
    TalkNote,
    Utterance,
)
from rai_missions.conversation.dialogue.confirmation import CROSSING_S
from tests.rigs.laws import drill

ARGUMENTS = tuple(KeyView(name, "string", "argument") for name in ("task", "place"))
VIEW = StatusView(mode="running", mission="assist", missions=(MissionView("assist", "", ARGUMENTS),))
PLACES = ("kitchen", "study", "bedroom")
SETTINGS = Settings(phrases={"go to {place}": {"task": "go"}}, names={"place": {each: each for each in PLACES}})
PERSONS = (("terminal", "Anna"), ("page", "Ben"))
MOST_CONFIRMED = 3
"""Requests that may wait; a new run follows, since a start is refused after them."""

turns = st.lists(
    st.tuples(
        st.sampled_from((0, 1)),
        st.sampled_from((0.5, 2.0, 2.0, 2.0, 25.0)),
        st.sampled_from(("order", "value", "unknown", "asks", "yes", "yes", "no")),
        st.sampled_from(PLACES),
    ),
    min_size=25,
    max_size=30,
)
"""Enough turns that one person's order is followed by the other's sentence, and by its own yes or value."""
SENTENCES = {
    "order": "go to the {}", "value": "the {}", "unknown": "go to the attic", "yes": "yes", "no": "no",
    "asks": "what are you doing?",
}  # fmt: skip


class Read(NamedTuple):
    """What a sentence led to."""

    read_back: str = ""
    """The place of the order that is read back."""
    confirmed: str = ""
    """That of the order that counts."""


class Oracle:
    """Who has what open."""

    def __init__(self) -> None:
        self.at, self.until, self.ended = 0.0, 0.0, (-9.0, -1)
        self.pending, self.owner = "", 0
        self.unclear = set[int]()
        """Whose yes may be meant for something else."""
        self.kept = dict[int, float]()
        """Person → when an order of theirs was refused or dropped; their next sentence may complete it."""

    def turn(self, person: int, kind: str, place: str) -> Read:
        if self.pending and self.at >= self.until:
            self._end(-1)
        is_kept = self.at - self.kept.pop(person, -99.0) < SETTINGS.confirm_s
        if kind == "yes" and self.pending:
            return self._yes(person)
        if kind == "no" and self.pending:
            self._end(person)
            self.kept[person] = self.at
            return Read()
        self.unclear.add(person)
        if kind == "unknown":
            self.kept[person] = self.at
        if kind == "order" or (kind == "value" and (is_kept or self.pending)):
            if self.pending:
                self._end(person)
            at, by = self.ended
            self.unclear = {0, 1} - {by} if self.at - at < CROSSING_S else set()
            return self._read_back(place, person)
        return Read()

    def _end(self, person: int) -> None:
        self.pending, self.ended = "", (self.at, person)

    def _read_back(self, place: str, owner: int) -> Read:
        self.pending, self.owner, self.until = place, owner, self.at + SETTINGS.confirm_s
        return Read(place)

    def _yes(self, person: int) -> Read:
        if person in self.unclear:
            self.unclear = set()
            return self._read_back(self.pending, self.owner)
        place = self.pending
        self._end(person)
        return Read(confirmed=place)


def place_of(kind: str, outputs: Sequence[Output]) -> str:
    """The place of the order that a note of this kind has."""
    notes = [each.data["order"] for each in outputs if isinstance(each, TalkNote) and each.kind == kind]
    return notes[0]["arguments"]["place"] if notes else ""


def play(script: Sequence[tuple[int, float, str, str]]) -> None:
    """Hold each reply against the oracle: what it led to, and at which doors it is shown."""
    dialogue, oracle, confirmed, at = Dialogue(SETTINGS, VIEW), Oracle(), 0, 0.0
    for person, after, kind, place in script:
        if confirmed == MOST_CONFIRMED:
            dialogue, oracle, confirmed = Dialogue(SETTINGS, VIEW), Oracle(), 0
        at = oracle.at = at + after
        before = oracle.owner
        dialogue.on_time(at)
        channel, author = PERSONS[person]
        received = Utterance(SENTENCES[kind].format(place), "operator", channel, author, at)
        outputs = dialogue.on_utterance(received, VIEW._replace(at=at))
        expected = oracle.turn(person, kind, place)
        assert Read(place_of("read_back", outputs), place_of("confirmed", outputs)) == expected, (received, expected)
        doors = {each.to for each in outputs if isinstance(each, Speech) and not each.report}
        assert doors and doors <= {channel, PERSONS[before][0]}, (received, doors)
        confirmed += bool(expected.confirmed)


test_what_is_open_belongs_to_whom_the_design_names = settings(max_examples=60, deadline=None)(given(turns)(play))
test_what_is_open_belongs_to_whom_the_design_names_often = drill(
    play, turns, tried=settings(max_examples=5_000, deadline=None)
)


@pytest.mark.parametrize("other", ["go to the attic", "no", "what are you doing?"])
def test_an_order_of_one_that_was_refused_waits_for_its_value_whatever_the_other_utters(other: str) -> None:
    dialogue, channels = Dialogue(SETTINGS, VIEW), [channel for channel, _ in PERSONS]
    for at, channel, text in ((1.0, 0, "go to the attic"), (2.0, 1, other), (3.0, 0, "the study")):
        received = Utterance(text, "operator", channels[channel], at=at)
        outputs = dialogue.on_utterance(received, VIEW._replace(at=at))
    assert place_of("read_back", outputs) == "study"
