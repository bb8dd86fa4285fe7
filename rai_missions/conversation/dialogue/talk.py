# SPDX-License-Identifier: Apache-2.0
"""What all parts of a dialogue share: its settings, its present, the run's view, the history, and what goes out."""

from __future__ import annotations

from collections import deque
from itertools import islice
from typing import Any

from rai_missions.conversation.answers.order_words import order_words
from rai_missions.conversation.answers.spoken_starts import SpokenStarts
from rai_missions.conversation.answers.state_answers import StateAnswers
from rai_missions.conversation.grammar.senses import Sense
from rai_missions.conversation.grammar.start_phrases import StartPhrases
from rai_missions.conversation.inputs import Utterance
from rai_missions.conversation.language.language import language
from rai_missions.conversation.outputs import NoteKind, Output, Speech, TalkNote, TalkTurn, Way
from rai_missions.conversation.settings import Settings
from rai_missions.conversation.view import StatusView
from rai_missions.planning.text.normalise import LONGEST
from rai_missions.redaction import cut

__all__ = ("Talk",)

MOST_IDS = 1_000
"""Ids of messages that are remembered."""


class Talk:
    """The present of a dialogue.

    Args:
        settings: What the profile sets.
        view: The run as it is now.
    """

    def __init__(self, settings: Settings, view: StatusView) -> None:
        self.settings, self.view = settings, view
        self.language = language(settings.language)
        self.starts = StartPhrases(settings.phrases, settings.names, self.language)
        self.spoken_starts = SpokenStarts(settings.spoken, settings.names, self.language)
        self.answers = StateAnswers(self.language, self.starts, settings.results, settings.places, settings.asked_with)
        self.now = float("-inf")
        self.turns: deque[TalkTurn] = deque(maxlen=settings.history)
        self._out: list[Output] = []
        self._number = 0
        self._ids: deque[tuple[str, ...]] = deque(maxlen=MOST_IDS)

    def pass_time(self, at: float) -> None:
        """The present is never earlier than it was."""
        self.now = max(self.now, at)

    def follow(self, view: StatusView) -> StatusView:
        """The run is as in this view now; returns how it was."""
        before, self.view = self.view, view
        return before

    def order_words(self, sense: Sense) -> str:
        """An order in words, as it is read back and reported."""
        return order_words(sense, self.view, self.spoken_starts, self.language)

    def is_new(self, utterance: Utterance) -> bool:
        """Whether its message was not received before; an id is unique for its author at most, and may be a talk's."""
        identity = (utterance.channel, utterance.author, utterance.id, utterance.text)
        if utterance.id and identity in self._ids:
            return False
        self._ids.append(identity)
        return True

    def add_person(self, utterance: Utterance) -> Utterance:
        """A person's turn; returns the sentence with its number."""
        self._number += 1
        text = cut(utterance.text, LONGEST)
        self.turns.append(
            TalkTurn(self._number, utterance.role, text, "", utterance.channel, self.now, utterance.author)
        )
        self.note(
            "heard",
            number=self._number,
            text=text,
            role=utterance.role,
            channel=utterance.channel,
            author=utterance.author,
            readings=[cut(each, LONGEST) for each in utterance.readings],
        )
        return utterance._replace(number=self._number)

    def add_robot(self, speech: Speech) -> None:
        """The robot's turn."""
        self._number += 1
        self.turns.append(TalkTurn(self._number, "robot", speech.text, speech.way, speech.to, self.now))

    def ends_with(self, channel: str, *ways: Way) -> bool:
        """Whether the robot's last text there was made in one of these ways: a yes or a no may be meant for that."""
        robot = (each for each in reversed(self.turns) if each.by == "robot" and each.channel in ("", channel))
        return any(each.way in ways for each in islice(robot, 1))

    def put(self, output: Output) -> None:
        """Something goes out."""
        self._out.append(output)

    def note(self, kind: NoteKind, **data: Any) -> None:
        """A line for the journal."""
        self._out.append(TalkNote(kind, self.now, data))

    def taken(self) -> tuple[Output, ...]:
        """Everything that goes out after this input."""
        out, self._out = tuple(self._out), []
        return out
