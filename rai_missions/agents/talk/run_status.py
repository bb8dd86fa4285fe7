# SPDX-License-Identifier: Apache-2.0
"""A run as a dialogue sees it: made of its status, its blackboard and the mission's own sentences, for one moment.

Rule: it rests on what the engine and the robot report alone; the run's thread leaves values here and never waits.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

from rai_missions.agents.talk.happenings import happenings
from rai_missions.agents.talk.progress import progress
from rai_missions.conversation import BuildView, KeyView, MissionView, RunEvent, StatusView
from rai_missions.conversation.view import EndKind
from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step
from rai_missions.keys import Blackboard, Key, stale_at
from rai_missions.mission.mission import Mission
from rai_missions.runtime.lifecycle import Status, status_of
from rai_missions.runtime.runner import Runner
from rai_missions.states import State
from rai_missions.states.final import Final

__all__ = ("RobotWords", "RunStatus")

MOST_HAPPENINGS = 40


class RobotWords(NamedTuple):
    """Who the robot is, in words."""

    name: str = ""
    identity: str = ""
    """A sentence on who it is."""
    build: BuildView | None = None
    """Its build, where a description has it."""


@dataclass(frozen=True)
class ReportedRun:
    """What a run has reported of itself, as of one step: replaced as a whole, so that no reader sees parts of two."""

    status: Status
    waits: bool
    """For the order to start."""
    questions: tuple[Question, ...]
    mode_by: str
    mode_since: float | None
    began: float | None = None
    end: EndKind = ""
    end_name: str = ""
    """Of the end, as in `StatusView`."""
    # what changes without anything for a dialogue to do
    wanted: frozenset[str] = field(default=frozenset(), compare=False)
    board: Blackboard = field(default_factory=dict, compare=False)
    rounds: Mapping[str, tuple[int, int]] = field(default_factory=dict, compare=False)
    entered: Mapping[str, float] = field(default_factory=dict, compare=False)
    happened: tuple[RunEvent, ...] = field(default=(), compare=False)


class RunStatus:
    """Follows one run.

    Args:
        runner: The run; begun or not.
        robot: Who the robot is.
    """

    def __init__(self, runner: Runner, robot: RobotWords = RobotWords()) -> None:  # noqa: B008 - a frozen value
        self._runner, self._mission, self._robot = runner, runner.mission, robot
        self._states = {name: state.about for _, name, state in self._mission.walk()}
        self._abouts = dict(_abouts(self._mission.states))
        self._acting = tuple(name for _, name, state in self._mission.walk() if state.activity())
        self._events = {name: event.about for name, event in self._mission.events.items()}
        self._missions = (mission_view(self._mission),)
        run = runner.view
        self._status = status_of(run)
        """A run reports its status ahead of the step that made it so; they are seen together."""
        self._reported = ReportedRun(
            self._status,
            runner.waits,
            run.questions,
            run.resumed_mode_by,
            run.paused_at,
            wanted=run.wanted,
            board=run.board,
            rounds=run.rounds,
        )

    @property
    def run(self) -> str:
        """The run's identity."""
        return self._runner.run_id

    # -- on the run's thread ----------------------------------------------------------------------------------------

    def step(self, step: Step) -> bool:
        """Follow a step; whether a dialogue is to look again."""
        run, was, status, event = self._runner.view, self._reported, self._status, step.event
        now = replace(
            was,
            status=status,
            waits=self._runner.waits,
            questions=run.questions,
            wanted=run.wanted,
            board=run.board,
            rounds=run.rounds,
        )
        if event.kind == "command" and event.name == "start" and not step.refusal:
            now = replace(now, began=step.at)
        if status.mode != was.status.mode:
            by = str(event.data.get("by", "")) if event.kind == "command" else ""
            now = replace(now, mode_since=step.at, mode_by=by)
        if step.outcome and was.status.outcome is None:
            end, name = self._end(step, was)
            now = replace(now, end=end, end_name=name)
        if step.entered:
            now = replace(now, entered={**was.entered, **dict.fromkeys(step.entered, step.at)})
        if happened := tuple(happenings(step, self._states, self._events)):
            now = replace(now, happened=(*was.happened, *happened)[-MOST_HAPPENINGS:])
        self._reported = now
        return now != was or bool(step.moves or step.outcome)

    def _end(self, step: Step, was: ReportedRun) -> tuple[EndKind, str]:
        """The kind of an end for which its author has no sentence, and whom or what it is about."""
        run, status, event = self._runner.view, self._status, step.event
        by = str(event.data.get("by", "")) or "command" if event.kind == "command" else ""
        if self._mission.end_words(step.outcome, status.active):
            return "", ""
        if run.cause == "invariant":
            return "invariant", run.false_invariant
        if run.cause:
            return "cycle", ""
        if event.name == "kill" and by:
            return "killed", by
        if step.outcome == "canceled" and (who := was.mode_by if was.status.mode == "canceling" else by):
            return "canceled", who
        finals = (name for name in status.active if isinstance(self._mission.states.get(name), Final))
        if final := next(finals, ""):
            return "reached", final
        return "failed", _named(status.active, self._acting)

    def status(self, status: Status) -> None:
        """The run's status has changed; it is seen with the step that follows."""
        self._status = status

    # -- from any thread ----------------------------------------------------------------------------------------------

    def view(self) -> StatusView:
        """The run as of its last step, at the time that it is now."""
        reported, now, mission = self._reported, self._runner.view.now(), self._mission
        status, board = reported.status, reported.board
        can_ask = self._runner.view.can_ask("operator")
        questions = tuple(each for each in reported.questions if can_ask and each.asked == "operator")
        active = status.active
        state = _named(active, self._acting)
        keys = {name: key_view(name, key, board, now) for name, key in mission.blackboard.items()}
        return StatusView(
            at=now,
            run=self._runner.run_id,
            is_resumed=self._runner.is_resumed,
            revision=status.revision,
            mode=status.mode,
            awaits_start=reported.waits,
            control=status.control,
            active=active,
            state=state,
            outcome=status.outcome,
            why=mission.end_words(status.outcome, active) or status.why,
            end=reported.end,
            end_name=reported.end_name,
            began=reported.began,
            wanted=tuple(sorted(reported.wanted)),
            held_by=status.held_by,
            held_since=status.held_since,
            open_goals=tuple(dict.fromkeys(goal.action for goal in status.open_goals)),
            questions=questions,
            confirm=frozenset(one for each in questions for one in _confirmed(mission, each)),
            keys=keys,
            states=self._abouts,
            events=self._events,
            mission=mission.name,
            about=mission.about,
            robot=self._robot.name,
            identity=self._robot.identity,
            build=self._robot.build,
            missions=self._missions,
            progress=tuple(progress(mission, frozenset(active), keys, reported.rounds)),
            happened=reported.happened,
            since=reported.entered.get(state),
            mode_by=reported.mode_by,
            mode_since=reported.mode_since,
        )


def _named(active: Sequence[str], acting: Sequence[str]) -> str:
    """The state that is named for all that are active: the first that acts, else the innermost."""
    return next((name for name in acting if name in active), active[-1] if active else "")


def _abouts(states: Mapping[str, State], around: str = "") -> Iterator[tuple[str, str]]:
    """Each state with its sentence, or that of the nearest state around it that has one."""
    for name, state in states.items():
        about = state.about or around
        yield name, about
        yield from _abouts(state.children(), about)


def mission_view(mission: Mission) -> MissionView:
    """A mission that can be started."""
    arguments = tuple(
        KeyView(
            name,
            key.type,
            key.source,
            key.about,
            key.initial,
            frame=key.frame,
            fields=key.fields or {},
            minimum=key.minimum,
            maximum=key.maximum,
            enum=key.enum,
        )
        for name, key in mission.keys_of("argument").items()
    )
    return MissionView(mission.name, mission.about, arguments)


def key_view(name: str, key: Key, board: Blackboard, now: float) -> KeyView:
    """A key of the blackboard at one moment."""
    entry = board.get(name)
    words: Mapping[str, Any] = {"frame": key.frame, "fields": key.fields or {}}
    if entry is None:
        return KeyView(name, key.type, key.source, key.about, None, None, is_fresh=False, **words)
    age_s = max(0.0, now - entry.at)
    is_fresh = now < stale_at(key, entry)
    return KeyView(name, key.type, key.source, key.about, entry.value, age_s, is_fresh=is_fresh, **words)


def _confirmed(mission: Mission, question: Question) -> Iterator[tuple[int, str]]:
    """The question's options that count only once they are confirmed."""
    for each in mission.state(question.state).decisions().values():
        yield from ((question.number, name) for name, option in each.options.items() if option.confirm)
