# SPDX-License-Identifier: Apache-2.0
"""What others may read of a run while it continues: its chart's public values, its time and its robot's readings.

Rule: from any thread, and nothing of the run can be changed through it; what is mutable is copied.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.engine import Chart
from rai_missions.engine.chart_view import ChartView
from rai_missions.event import Origin
from rai_missions.guards.view import Truth
from rai_missions.keys import Blackboard
from rai_missions.runtime.effects import EffectExecutor
from rai_missions.runtime.lifecycle import Control
from rai_missions.runtime.readings import SourceState
from rai_missions.runtime.scheduler import Scheduler

__all__ = ("RunView",)


class RunView(ChartView):
    """A run, to be read; also a guard's `View` of it.

    Args:
        chart: The run's.
        scheduler: The run's.
        control: Who holds control, and may get it.
        executor: Knows what the robot's sources report.
        missing: The robot keys that a run of another process waits for before it continues.
        mode_by: Of a run that is resumed, who brought it into the mode in which it continues; empty where no one did.
    """

    def __init__(
        self,
        chart: Chart,
        scheduler: Scheduler,
        control: Control,
        executor: EffectExecutor,
        missing: Callable[[], tuple[str, ...]],
        mode_by: str = "",
    ) -> None:
        super().__init__(chart.program, chart.state)
        self._chart, self._scheduler, self._control, self._executor = chart, scheduler, control, executor
        self._missing, self.resumed_mode_by = missing, mode_by

    def now(self) -> float:
        """Seconds on the run's clock."""
        return self._scheduler.now()

    @property
    def run(self) -> str:
        """The run's identity."""
        return self._executor.run

    @property
    def thinking(self) -> bool:
        """A model or a person is asked, and has yet to answer."""
        return self._executor.thinking

    @property
    def urgent(self) -> bool:
        """An e-stop waits to be taken."""
        return self._scheduler.mailbox.urgent

    def branch(self) -> Chart:
        """The chart again, where it is: what is done to it changes nothing in the run; on the run's own thread."""
        return self._chart.branch()

    @property
    def unreported(self) -> tuple[str, ...]:
        """The robot keys that the run waits for: to start, or to continue in another process."""
        return super().unreported if self._state.mode == "ready" else self._missing()

    def source(self, key: str) -> SourceState:
        """What is known of the readings of a robot key's source."""
        return self._executor.source(key)

    def can_ask(self, answerer: str) -> bool:
        """Whether there is one of that name: a question to one who is absent is open for the length of a step."""
        return self._executor.can_ask(answerer)

    def refuses_control(self, to: str, role: Origin) -> str:
        """Why a handover may not be asked for in a role; empty if it may."""
        return self._control.refuses(to, role)

    # -- what guards see ------------------------------------------------------------------------------------------

    @property
    def board(self) -> Blackboard:
        """Key → the value that was last received, with its stamp."""
        return dict(self._state.board)

    @property
    def entered(self) -> Mapping[str, float]:
        """State → when it was last entered, for the states whose age a guard asks for."""
        return dict(self._state.entered)

    @property
    def true_since(self) -> Mapping[str, float]:
        """Held guard → since when its inner guard has been true without a break."""
        return dict(self._state.true_since)

    @property
    def event(self) -> Mapping[str, Any]:
        """The payload of the event in hand."""
        return self._state.event

    @property
    def answer(self) -> Mapping[str, Any]:
        """The parameters of the option in hand."""
        return self._state.answer

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        """The value of a predicate of the user's program; on the run's own thread."""
        return self._state.named(name, arguments)

    def note(self, text: str) -> None:
        """Nothing is noted: this view is for looking, outside of a step."""
