# SPDX-License-Identifier: Apache-2.0
"""A run as a person reads it: a line a step, each question with its answer and verdict, and the end with its rule.

Rule: it receives steps and prints; no other part needs anything that it keeps.
"""

from __future__ import annotations

from collections.abc import Collection, Sequence
from itertools import groupby
from typing import Any, Literal, Protocol, TextIO

from rai_missions.answerers.model.providers import model_words
from rai_missions.engine.activities.goal_ledger import OpenGoal, may_move
from rai_missions.engine.decision import Answerer
from rai_missions.engine.description import Description, describe
from rai_missions.engine.step import Ask, Effect, Step
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import listed, printable
from rai_missions.runtime.lifecycle import Status
from rai_missions.runtime.result import Result
from rai_missions.runtime.view import RunView
from rai_missions.states import answerer_words
from rai_missions.states.final import FinalOutcome

__all__ = ("Lines", "Person", "Tone", "trimmed", "value_words")

WIDTH = 150
MOVED_ASIDE = "the journal of an earlier run, which had this name, is now {}"
Tone = Literal["plain", "question", "refused", "remark", "ignored", FinalOutcome]
"""What a line is about."""


def trimmed(value: Any, width: int = WIDTH) -> str:
    """A value in one line of bounded length, without control characters."""
    text = value if isinstance(value, str) else listed(value)
    text = " ".join(printable(text, " ").split())
    return text if len(text) <= width else text[: width - 1] + "…"


def value_words(value: Any, width: int) -> str:
    """A value of a key in one line of bounded length; a text without letters is seen by its quotes."""
    return trimmed(value, width) or '""'


def _reasons(mission: Mission) -> dict[str, str]:
    """JSON pointer of a transition → its guard in words."""
    guarded = ((place, each.when) for place, each in mission.every_transition())
    return {place: guard.words() for place, guard in guarded if guard is not None}


WHY_ABSENT = {
    "agent": "no model configured; use --model",
    "operator": "--no-operator, or standard input is no terminal",
    "rules": "the profile has none",
}
"""Why an answerer that missions commonly ask cannot answer."""
UNOFFERED = "neither the program nor a package in 'uses' offers it"


def _answerers(present: Sequence[str], absent: Sequence[str]) -> str:
    """Who answers, in the order in which the mission asks, and who does not and why."""
    skipped = ", ".join(f"{answerer_words(name)} ({WHY_ABSENT.get(name, UNOFFERED)})" for name in absent)
    who = ", ".join(map(answerer_words, present)) or "no one, so each takes its fallback"
    return f"{who}; skipped: {skipped}" if skipped else who


class Person(Answerer, Protocol):
    """A person at the terminal."""

    def stop(self) -> None:
        """Nothing more will be asked."""


class Lines:
    """Prints a run line by line.

    Args:
        mission: Whose run it is.
        out: Where the lines go.
        verbose: Quiet steps, such as ignored events, too.
    """

    def __init__(self, mission: Mission, out: TextIO, *, verbose: bool = False) -> None:
        self._mission, self._out, self._verbose = mission, out, verbose
        self._is_resumed = False
        self._absent: frozenset[str] = frozenset()
        """Who is asked by the mission and cannot answer in this run."""
        self._persons: list[Person] = []
        self._shown: tuple[str, ...] = ()
        self._answered: dict[str, int] = {}
        self._fallbacks = 0
        self._reasons = _reasons(mission)
        self._view: RunView | None = None
        self._is_waiting = False
        self._open_goals: tuple[OpenGoal, ...] = ()
        self._warned: tuple[OpenGoal, ...] = ()
        """The goals of the last line, where that was on goals that may still move the robot."""
        self._unfit: set[str] = set()
        """The keys of which a value was received that they cannot have."""

    def begin(
        self,
        robot: str,
        answerers: Collection[str],
        journal: str,
        *,
        model: str | None,
        resumption: str = "",
        moved_aside: str = "",
    ) -> None:
        """The head of a run: what runs on what, who answers, where it is written down, from where it resumes.

        Args:
            robot: Its name; empty for none.
            answerers: Who answers, by the names in `ask`.
            journal: Its file; empty for none.
            model: The model that answers as 'agent'.
            resumption: From where a run continues.
            moved_aside: Where the journal is now that had this name.
        """
        self._is_resumed, self._answered, self._shown, self._is_waiting = bool(resumption), {}, (), False
        self._fallbacks = 0
        decisions = (each for _, _, state in self._mission.walk() for each in state.decisions().values())
        asked = tuple(dict.fromkeys(name for each in decisions for name in each.ask))
        absent = [name for name in asked if name not in answerers]
        self._absent = frozenset(absent)
        lines = (
            f"{self._mission.name} {self._mission.version} on {robot or 'no robot'}",
            model and f"model: {model_words(model)}",
            f"questions are answered by: {_answerers([each for each in asked if each in answerers], absent)}"
            if asked
            else "",
            f"journal: {journal or 'none'}",
            moved_aside and MOVED_ASIDE.format(moved_aside),
            resumption,
        )
        for line in (*filter(None, lines), ""):
            self._print(line)

    def watch(self, view: RunView) -> None:
        """The run begins; its state may be shown below the lines."""
        self._view = view

    def lend(self, person: Person) -> Answerer:
        """A person who is asked where these lines are printed; stopped when the run is over."""
        self._persons.append(person)
        return person

    def close(self) -> None:
        """The run is over, however it went."""
        for person in self._persons:
            person.stop()

    def status(self, status: Status) -> None:
        """The run's mode, control or states have changed, or which goals may still move the robot."""
        if status.open_goals and status.open_goals != self._open_goals:
            self._print(f"{'':13}{trimmed(may_move(status.open_goals), 400)}")
            self._warned = status.open_goals
        self._open_goals = status.open_goals

    def step(self, step: Step) -> None:
        """One step; those that changed nothing are left out unless all are wanted."""
        if step.refusal == "not_started" and not self._verbose:
            self._wait(step)
            return
        if step.refusal == "unfit" and step.event.kind == "write" and not self._verbose:
            self._report_unfit(step)
            return
        if step.ignored and not (step.why and step.event.kind != "write") and not self._verbose:
            return
        described = describe(step)
        effects = zip(step.effects, described.effects, strict=True)
        does = [trimmed(words, 100) for effect, words in effects if not self._is_shown_below(step, effect)]
        writes = groupby(step.writes if step.event.kind != "write" else ())
        does += [f"{key} := {value_words(value, 40)}" for (key, value), _again in writes]
        parts = [described.way, *does]
        if step.ignored:
            parts = [f"ignored: {step.why}" if step.why else "ignored"]
        text, remarks = " · ".join(part for part in parts if part), described.remarks
        if text or remarks:
            self._warned = ()
            shown = f"{trimmed(self._event(step.event, described), 28):<28}  {text or '; '.join(remarks)}"
            self._print(f"{step.at:9.2f} s  {shown}", "ignored" if step.ignored else "plain" if text else "remark")
            for reason in self._because(step) if text else ():
                self._print(f"{'':13}{trimmed(reason)}")
            for remark in remarks if text else ():
                self._print(f"{'':13}{trimmed(remark)}", "remark")
        self._verdicts(step, described.verdicts)
        if step.moves:
            self._shown = ()
        for effect in step.effects:
            if isinstance(effect, Ask):
                self._question(effect)

    def _report_unfit(self, step: Step) -> None:
        """Once a key: the robot reports what it cannot have."""
        if step.event.name not in self._unfit:
            self._unfit.add(step.event.name)
            self._print(f"{step.at:9.2f} s  received and not understood: {trimmed(step.why, 300)}", "remark")

    def _wait(self, step: Step) -> None:
        """Once: what the mission must receive before it starts; until then nothing else counts."""
        unreported = self._view.unreported if self._view is not None else ()
        if unreported and not self._is_waiting:
            self._is_waiting = True
            self._print(f"{step.at:9.2f} s  waiting for the robot: {', '.join(unreported)}")

    def end(self, result: Result, picture: str = "") -> None:
        """How it ended, and where everything is."""
        self._print("")
        self._print(f"{result.outcome}: {trimmed(result.why, 400)}", result.outcome)
        counts = ", ".join(f"{who} {count}" for who, count in sorted(self._answered.items())) or "none"
        since = " since it was resumed" if self._is_resumed else ""
        asked = f"questions {result.decisions} (answers that counted{since}: {counts})"
        asked += f" · fallbacks {self._fallbacks}" if self._fallbacks else ""
        stated = self._mission.end_words(result.outcome, result.state) if result.outcome != "succeeded" else ""
        # By the clock of the lines above, which has run since the robot was looked for.
        ended_s = self._view.at if self._view is not None else result.duration_s
        lines = (
            stated and f"{'':4}{trimmed(stated, 400)}",
            trimmed(result.warning, 400) if result.open_goals != self._warned else "",
            f"steps {result.steps} · {asked} · {ended_s:.1f} s",
            result.journal and f"journal: {result.journal}",
            picture and f"picture: {picture}",
        )
        for line in filter(None, lines):
            self._print(line)

    def _event(self, event: Event, described: Description) -> str:
        if event.kind != "write":
            return described.event
        return f"{event.name} = {value_words(event.data.get('value'), 20)}"

    def _because(self, step: Step) -> list[str]:
        """What was so that moved the mission without an event or outcome."""
        places = [place for move in step.moves if not move.trigger for place in move.taken]
        return [f"because {self._reasons[place]}" for place in places if place in self._reasons]

    def _question(self, ask: Ask) -> None:
        """What is asked; printed once for all who are asked the same."""
        question = ask.question
        offered = ", ".join(offer.name for offer in question.options)
        words = (question.owner, offered, *(trimmed(shown.words().rpartition(", ")[0]) for shown in question.evidence))
        if words != self._shown:
            self._shown = words
            self._print(f"{'':13}question: {trimmed(question.text)}", "question")
            for shown in question.evidence:
                self._print(f"{'':15}{trimmed(shown.words())}")
            self._print(f"{'':15}offered: {offered}", "question")
        if self._is_vain(ask):
            return
        again = f", attempt {question.attempt}" if question.attempt > 1 else ""
        self._print(f"{'':13}question {question.number} to {answerer_words(question.asked)}{again}", "question")

    def _is_shown_below(self, step: Step, effect: Effect) -> bool:
        """Whether an effect is a question whose lines follow: the next attempt, or one for an absent answerer."""
        is_next = step.event.kind == "proposal" and not step.moves and isinstance(effect, Ask)
        return is_next or self._is_vain(effect)

    def _is_vain(self, effect: Effect) -> bool:
        """Whether an effect asks an answerer that is absent in this run; the head of the run names it once."""
        return isinstance(effect, Ask) and effect.question.asked in self._absent

    def _verdicts(self, step: Step, words: tuple[str, ...]) -> None:
        why = step.event.data.get("why") if step.event.kind == "proposal" else ""
        for verdict, text in zip((each for each in step.verdicts if each.note is not None), words, strict=True):
            if verdict.kind == "absent" and verdict.by in self._absent:
                continue
            if verdict.kind == "fallback":
                self._fallbacks += 1
            elif verdict.accepted:
                who = answerer_words(verdict.by)
                self._answered[who] = self._answered.get(who, 0) + 1
            reason = f" (“{trimmed(why, 80)}”)" if why else ""
            self._print(f"{'':13}{trimmed(text)}{reason}", "question" if verdict.accepted else "refused")

    def _print(self, line: str, tone: Tone = "plain") -> None:
        """Print a line.

        Args:
            line: Its text.
            tone: What the line is about, for a terminal with colours.
        """
        print(line, file=self._out, flush=True)
