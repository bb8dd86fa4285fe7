# SPDX-License-Identifier: Apache-2.0
"""What the robot speaks in a dialogue: every text that goes out has a key, and its end is waited for."""

from __future__ import annotations

from typing import NamedTuple

from rai_missions.conversation.dialogue.reports import MissionReport, Reports
from rai_missions.conversation.dialogue.talk import Talk
from rai_missions.conversation.inputs import SpeechEnd, Utterance
from rai_missions.conversation.outputs import NoteKind, Silence, Speech, Way
from rai_missions.redaction import redacted
from rai_missions.voice.spoken_text import SpeechPriority

__all__ = ("SpeechOutput",)


class OutstandingSpeech(NamedTuple):
    """A speech whose end has not been reported."""

    speech: Speech
    until: float


class SpeechOutput:
    """Gives out speech and reports, and follows what becomes of them.

    Args:
        talk: What the parts of the dialogue share.
    """

    def __init__(self, talk: Talk) -> None:
        self._talk = talk
        self._keys = 0
        self._open: dict[str, OutstandingSpeech] = {}
        self.reports = Reports(talk.language, talk.settings, talk.spoken_starts)

    def reply(self, name: str, to: Utterance, /, **values: object) -> Speech:
        """A template of the language, as an answer to a sentence."""
        return self.answer(self._talk.language.text(name, **values), to)

    def answer(self, text: str, to: Utterance, *, way: Way = "rules") -> Speech:
        """A text, as an answer to a sentence."""
        return self.speak(text, to=to.channel, reply_to=to.number, way=way)

    def acknowledge(self, name: str, to: Utterance) -> None:
        """A template that fills the time until an answer: it is no turn of the conversation."""
        self._put(Speech("", self._talk.language.text(name), "chatter", to=to.channel, reply_to=to.number))

    def speak(
        self,
        text: str,
        *,
        to: str = "",
        reply_to: int = 0,
        priority: SpeechPriority = "answer",
        way: Way = "rules",
        report: MissionReport | None = None,
    ) -> Speech:
        """Give out a text, without secrets: what it is made of has many authors."""
        speech = Speech("", redacted(text), priority, way, to=to, reply_to=reply_to)
        if way == "model":
            speech = speech._replace(aloud=self._talk.language.text("model_thinks", text=speech.text))
        if report is not None:
            speech = speech._replace(report=report.identity, uncut=report.uncut, repeated=report.repeated)
        self._talk.add_robot(speech)
        return self._put(speech)

    def _put(self, speech: Speech) -> Speech:
        """Give a speech out, under a key of its own."""
        self._keys += 1
        speech = speech._replace(key=f"s{self._keys}")
        self._open[speech.key] = OutstandingSpeech(speech, self._talk.now + self._talk.settings.speech_s)
        self._talk.put(speech)
        return speech

    def silence(self, *, is_total: bool) -> None:
        """Stop speaking."""
        self._talk.put(Silence(self._talk.now, is_total))

    def follow(self) -> None:
        """The run's status is new."""
        self.reports.follow(self._talk.view, self._talk.now)

    def speak_due(self, *, now: bool) -> None:
        """Speak the reports that are due; with `now` also those that wait for the end of a sentence."""
        for report in self.reports.due(self._talk.now, now=now):
            text = report.text
            if report.repeated:
                text = self._talk.language.text("repeated", text=text)
            speech = self.speak(text, priority=report.priority, report=report)
            self.reports.begin(report, speech.key)

    def on_end(self, end: SpeechEnd) -> bool:
        """A speech has ended; False where none of its key is waited for."""
        open_one = self._open.pop(end.key, None)
        report = self.reports.end(end.key, end.result, self._talk.now)
        if open_one is None:
            return report is not None
        kind: NoteKind = "spoken" if end.result == "whole" else "unspoken"
        speech = open_one.speech
        self._talk.note(kind, key=end.key, result=end.result, report=speech.report, text=speech.text, way=speech.way)
        return True

    def on_speaker(self, *, is_alive: bool) -> None:
        """The speaker died, or speaks again."""
        if not is_alive:
            self.reports.mute()
        elif not self.reports.is_speaker_alive:
            self.reports.revive(self._talk.now)
            self.speak_due(now=False)
        for key in list(self._open) if not is_alive else ():
            self.on_end(SpeechEnd(key, "failed", self._talk.now))

    def on_time(self) -> None:
        """A speech without an end has failed; owed reports follow."""
        for key, each in list(self._open.items()):
            if each.until <= self._talk.now:
                self.on_end(SpeechEnd(key, "failed", self._talk.now))
        self.speak_due(now=False)

    def wake_at(self) -> float | None:
        """When the next of both is due."""
        times = [each.until for each in self._open.values()]
        due = self.reports.wake_at()
        return min([*times, *([] if due is None else [due])], default=None)
