# SPDX-License-Identifier: Apache-2.0
"""What others may read of a run while it continues: its chart's public values, its time and its robot's readings.

Rule: from any thread, and nothing of the run can be changed through it; what is mutable is copied.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.engine import Chart, Snapshot
from rai_missions.engine.activities.goal_ledger import OpenGoal
from rai_missions.engine.decision import Question
from rai_missions.engine.modes import Mode
from rai_missions.engine.step import Cause
from rai_missions.event import Event, Origin
from rai_missions.guards.view import Truth
from rai_missions.keys import Blackboard
from rai_missions.mission.mission import Mission
from rai_missions.runtime.effects import EffectExecutor
from rai_missions.runtime.lifecycle import Control
from rai_missions.runtime.readings import SourceState
from rai_missions.runtime.scheduler import Scheduler
from rai_missions.states.control import Holder
from rai_missions.states.final import FinalOutcome

__all__ = ("RunView",)


class RunView:
    """A run, to be read; also a guard's `View` of it.

    Args:
        chart: The run's.
        scheduler: The run's.
        control: Who holds control, and may get it.
        executor: Knows what the robot's sources report.
        mode_by: Of a run that is resumed, who brought it into the mode in which it continues; empty where no one did.
    """

    def __init__(
        self, chart: Chart, scheduler: Scheduler, control: Control, executor: EffectExecutor, mode_by: str = ""
    ) -> None:
        self._chart, self._scheduler, self._control, self._executor = chart, scheduler, control, executor
        self.resumed_mode_by = mode_by

    def now(self) -> float:
        """Seconds on the run's clock."""
        return self._scheduler.now()

    @property
    def mission(self) -> Mission:
        return self._chart.mission

    @property
    def seq(self) -> int:
        """Steps so far."""
        return self._chart.seq

    @property
    def mode(self) -> Mode:
        """`ready`, `running`, `paused` or `canceling`; of a run that has ended, its outcome."""
        return self._chart.mode

    @property
    def outcome(self) -> FinalOutcome | None:
        """How the mission ended; None while it runs."""
        return self._chart.outcome

    @property
    def why(self) -> str:
        """The rule that decided the outcome."""
        return self._chart.why

    @property
    def cause(self) -> Cause:
        """What has ended the mission, where no rule of it did."""
        return self._chart.cause

    @property
    def false_invariant(self) -> str:
        """The name of the invariant that has ended the mission; empty for any other end."""
        return self._chart.false_invariant

    @property
    def questions(self) -> tuple[Question, ...]:
        """Those that are open, the oldest first."""
        return self._chart.questions

    @property
    def waiting_answers(self) -> tuple[Event, ...]:
        """The answers that are judged once a pause ends, or control is given back."""
        return self._chart.waiting_answers

    @property
    def unheard(self) -> tuple[str, ...]:
        """The robot keys that the start waits for."""
        return self._chart.unheard

    @property
    def awaited_goals(self) -> int:
        """How many goals have an end that has not been confirmed and that the run waits for.

        Those that are left unconfirmed, `open_goals` of `Result` and of the status, are `loose_goals`.
        """
        return self._chart.awaited_goals

    @property
    def loose_goals(self) -> tuple[OpenGoal, ...]:
        """The goals that may still be executing, and that no cancel can be relied on to end."""
        return self._chart.loose_goals

    @property
    def awaited(self) -> frozenset[int]:
        """The numbers of goals, calls, questions and behaviours whose end the run still waits for."""
        return self._chart.awaited

    @property
    def thinking(self) -> bool:
        """A model or a person is asked, and has yet to answer."""
        return self._executor.thinking

    @property
    def urgent(self) -> bool:
        """An e-stop waits to be taken."""
        return self._scheduler.mailbox.urgent

    def snapshot(self) -> Snapshot:
        """All that the chart remembers, as values that later steps do not change; on the run's own thread."""
        return self._chart.snapshot()

    def branch(self) -> Chart:
        """The chart again, where it is: what is done to it changes nothing in the run; on the run's own thread."""
        return self._chart.branch()

    @property
    def run(self) -> str:
        """The run's identity."""
        return self._executor.run

    def source(self, key: str) -> SourceState:
        """What is known of the readings of a robot key's source."""
        return self._executor.source(key)

    # -- control and time -----------------------------------------------------------------------------------------

    @property
    def holder(self) -> Holder:
        """Who holds control."""
        return self._chart.holder

    @property
    def wanted(self) -> frozenset[str]:
        """Who must have control for what waits to begin."""
        return self._chart.wanted

    @property
    def held_by(self) -> str:
        """Who holds the mission up; empty while it is not held."""
        return self._chart.held_by

    @property
    def held_since(self) -> float | None:
        """Since when, in seconds on the run's clock; None while the mission is not held."""
        return self._chart.held_since

    def refuses_control(self, to: str, role: Origin) -> str:
        """Why a handover may not be asked for in a role; empty if it may."""
        return self._control.refuses(to, role)

    @property
    def paused_at(self) -> float | None:
        """Since when no question loses time; None while the run is not paused."""
        return self._chart.paused_at

    def still_since(self, state: str) -> float | None:
        """Since when the time of a state does not pass, in seconds on the run's clock; None while it runs."""
        return self._chart.still_since(state)

    # -- what guards see ------------------------------------------------------------------------------------------

    @property
    def at(self) -> float:
        """The instant of the last step, in seconds on the run's clock."""
        return self._chart.at

    @property
    def active(self) -> frozenset[str]:
        """The names of the active states, ancestors included."""
        return self._chart.active

    @property
    def rounds(self) -> Mapping[str, tuple[int, int]]:
        """Active `each` → how many of its items are over, and how many it has."""
        return self._chart.rounds

    @property
    def board(self) -> Blackboard:
        """Key → the value that was last received, with its stamp."""
        return dict(self._chart.view.board)

    @property
    def entered(self) -> Mapping[str, float]:
        """State → when it was last entered, for the states whose age a guard asks for."""
        return dict(self._chart.view.entered)

    @property
    def held(self) -> Mapping[str, float]:
        """Held guard → since when its inner guard has been true without a break."""
        return dict(self._chart.view.held)

    @property
    def event(self) -> Mapping[str, Any]:
        """The payload of the event in hand."""
        return self._chart.view.event

    @property
    def answer(self) -> Mapping[str, Any]:
        """The parameters of the option in hand."""
        return self._chart.view.answer

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        """The value of a predicate of the user's program; on the run's own thread."""
        return self._chart.view.named(name, arguments)

    def note(self, text: str) -> None:
        """Nothing is noted: this view is for looking, outside of a step."""
