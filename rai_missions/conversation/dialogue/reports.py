# SPDX-License-Identifier: Apache-2.0
"""Reports: what the mission reports of itself, each spoken whole exactly once in a process life.

A report is cut once at most: spoken again it is uncut. After a kill or a dead speaker it follows, marked as repeated.
Rule: a report has an identity; its texts may be spoken again, its identity is reported once.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, Literal, NamedTuple

from rai_missions.conversation.answers.spoken_starts import SpokenStarts
from rai_missions.conversation.language.language import Language, spoken
from rai_missions.conversation.language.question_words import question_text
from rai_missions.conversation.language.run_words import control_text, end_text, goals_text
from rai_missions.conversation.language.values import result_sentences
from rai_missions.conversation.settings import Settings
from rai_missions.conversation.view import StatusView
from rai_missions.voice.spoken_text import SpeechPriority

__all__ = ("MissionReport", "Reports")

AGAIN_S = 2.0
"""After a cut a report waits so long for the end of the person's sentence, then it is spoken over it."""
RETRY_S, MOST_DOUBLINGS = 5.0, 4
"""A speaker that fails without being known as dead, such as a topic whose broker is away, is tried again after so long;
each time after twice as long, at last after 80 s."""
HANDOVER_S = 2.0
"""A handover takes a moment: that the mission waits for control is reported where it lasts longer."""
KEPT = 200
"""Reports that are remembered; the oldest of those that were spoken are forgotten."""


class MissionReport(NamedTuple):
    """One report, and how far it is."""

    identity: str
    text: str
    priority: SpeechPriority
    state: Literal["owed", "speaking", "spoken"] = "owed"
    due: float = 0.0
    """Of an owed one: the instant from which on it is spoken."""
    key: str = ""
    """Of the speech that is under way, or was the last."""
    uncut: bool = False
    repeated: bool = False
    tries: int = 0


class Reports:
    """The reports of a process life.

    Args:
        language: Their templates.
        settings: Which values are spoken with a question and with the end.
        starts: What starts are called.
    """

    def __init__(self, language: Language, settings: Settings, starts: SpokenStarts) -> None:
        self._language, self._settings, self._starts = language, settings, starts
        self._all: dict[str, MissionReport] = {}
        self._run = ""
        self._moving: frozenset[str] = frozenset()
        """The actions of the run that may still move the robot, and are reported."""
        self._waiting: MissionReport | None = None
        self.last_end = ""
        self.is_speaker_alive = True

    def follow(self, view: StatusView, at: float) -> None:
        """Add what the run's new status makes due; what a process before this one may have spoken is a repetition."""
        is_other, self._run = view.run != self._run, view.run
        repeated, reported = view.is_resumed and is_other, frozenset() if is_other else self._moving
        self._moving = frozenset(view.open_goals)
        for identity, text, priority in self._new(view, is_moving=not self._moving <= reported):
            if priority == "end":
                self.last_end = text
            if identity not in self._all:
                self._all[identity] = MissionReport(identity, text, priority, due=at, repeated=repeated)
        self._follow_control(view, at)
        self._forget(view.run or "run")

    def _follow_control(self, view: StatusView, at: float) -> None:
        """The mission waits for control, or no more: a report of that which has not begun is no news then."""
        text, run, before = control_text(view, self._language), view.run or "run", self._waiting
        if before is not None and before.text == text and before.identity.startswith(f"{run}:"):
            return
        if before is not None and self._all.get(before.identity) == before:
            del self._all[before.identity]
        self._waiting = None
        if text:
            self._waiting = MissionReport(f"{run}:waits:{view.revision}", text, "question", due=at + HANDOVER_S)
            self._all.setdefault(self._waiting.identity, self._waiting)

    def add(self, identity: str, text: str, at: float) -> None:
        """Add a report of a run, due at once, unless it is known already."""
        if identity not in self._all:
            self._all[identity] = MissionReport(identity, text, "question", due=at)

    def _forget(self, run: str) -> None:
        """Only of other runs: what was spoken of this one must not be spoken again."""
        old = [
            each.identity
            for each in self._all.values()
            if each.state == "spoken" and not each.identity.startswith(f"{run}:")
        ]
        for identity in old[: max(len(self._all) - KEPT, 0)]:
            del self._all[identity]

    def _new(self, view: StatusView, *, is_moving: bool) -> Iterator[tuple[str, str, SpeechPriority]]:
        """What there is to report now, with the identity of each.

        Args:
            view: The run.
            is_moving: An action may still move the robot of which that was not reported.
        """
        language, run = self._language, view.run or "run"
        if view.mode == "ready" and view.awaits_start:
            yield f"{run}:ready", language.text("report_ready", mission=spoken(view.mission)), "question"
        if view.mode and view.mode != "ready" and not view.awaits_start:
            about, mission = self._started_for(view), spoken(view.mission)
            form = "report_start" if about else "report_start_only"
            yield f"{run}:start", language.text(form, mission=mission, about=about), "question"
        for question in view.questions if view.is_alive else ():
            text = language.text(
                "report_question", question=question_text(question, language, self._settings.asked_with)
            )
            yield f"{run}:question:{question.number}", text, "question"
        if is_moving and (view.is_alive or f"{run}:end" in self._all):  # an end that is due has it in its text
            yield f"{run}:moving:{view.revision}", goals_text(view, language), "question"
        if view.has_ended:
            yield f"{run}:end", self._end(view), "end"

    def _started_for(self, view: StatusView) -> str:
        """What the run is for: its start as the profile calls it, or what its mission does."""
        offered = view.mission_named(view.mission)
        before = {key.name: key.value for key in offered.arguments} if offered is not None else {}
        keys = {key.name: key for key in view.keys.values() if key.source == "argument" and key.value is not None}
        given = {name: key.value for name, key in keys.items()}
        called = self._starts.words(given, keys, {name for name in given if given[name] == before.get(name)})
        return f"{called}." if called else view.about.strip()

    def _end(self, view: StatusView) -> str:
        results = result_sentences(self._settings.results, view.keys, self._language)
        why = "" if results and view.mode == "succeeded" else end_text(view, self._language)
        mode = self._language.word("modes", view.mode)
        text = self._language.text(
            "report_end_why" if why else "report_end", mission=spoken(view.mission), mode=mode, why=why
        )
        return " ".join(filter(None, [text, *results, goals_text(view, self._language)]))

    def due(self, at: float, *, now: bool = False) -> list[MissionReport]:
        """What is to be spoken, the oldest first, so that no end comes before its start; priorities are the speaker's.

        Args:
            at: The present.
            now: Also what waits for the end of a person's sentence: before the next answer.
        """
        return [each for each in self._speakable() if now or each.due <= at]

    def _speakable(self) -> Iterator[MissionReport]:
        """What is owed, and was not tried yet or has a speaker."""
        owed = (each for each in self._all.values() if each.state == "owed")
        return (each for each in owed if not each.tries or self.is_speaker_alive)

    def begin(self, report: MissionReport, key: str) -> None:
        """The report is being spoken under this key."""
        self._all[report.identity] = report._replace(state="speaking", key=key, tries=report.tries + 1)

    def end(self, key: str, result: str, at: float) -> MissionReport | None:
        """A speech has ended; the report that it was, None where it was none that is waited for."""
        report = next((each for each in self._all.values() if each.key == key), None)
        if report is None or report.state == "spoken":
            return None
        if result == "whole":
            ended = report._replace(state="spoken")
        elif result == "cut":
            ended = report._replace(state="owed", uncut=True, due=at + AGAIN_S, tries=0)
        else:
            due = at + RETRY_S * 2 ** min(report.tries - 1, MOST_DOUBLINGS)
            ended = report._replace(state="owed", repeated=True, due=due)
        self._all[report.identity] = ended
        return ended

    def mute(self) -> None:
        """The speaker is dead: what it did not speak waits for another."""
        self.is_speaker_alive = False

    def revive(self, at: float) -> None:
        """The speaker speaks again: what it did not speak is owed."""
        self.is_speaker_alive = True
        for each in self._all.values():
            if each.state == "owed" and each.tries:
                self._all[each.identity] = each._replace(state="owed", due=at, tries=0)

    def wake_at(self) -> float | None:
        """When the next owed report is due."""
        return min((each.due for each in self._speakable()), default=None)

    def is_spoken(self, identity: str) -> bool:
        """Whether it was spoken whole."""
        report = self._all.get(identity)
        return report is not None and report.state == "spoken"

    def unspoken(self) -> tuple[str, ...]:
        """The identities of the reports that were not spoken whole."""
        return tuple(each.identity for each in self._all.values() if each.state != "spoken")

    def snapshot(self) -> list[dict[str, Any]]:
        """As JSON."""
        return [each._asdict() for each in self._all.values()]

    def restore(self, saved: list[Mapping[str, Any]]) -> None:
        """Restore the reports of an ended process: one not spoken whole is owed, and may have been spoken before."""
        for each in saved:
            report = MissionReport(**each)
            if report.state != "spoken":
                begun = report.repeated or report.state != "owed" or report.uncut
                report = report._replace(state="owed", key="", due=0.0, tries=0, repeated=begun)
            self._all[report.identity] = report
