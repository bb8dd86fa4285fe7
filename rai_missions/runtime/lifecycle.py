# SPDX-License-Identifier: Apache-2.0
"""Two small fixed machines: the mode of a run, and who holds control of the actuators.

Rule: this is the only place that knows `transitions`; no mission draws these states, and every agent reads them here.
Rule: the machines are made once a process and remember nothing; where a run is in one of them is a `Position`.
"""

from __future__ import annotations

from collections.abc import Mapping
from functools import cache
from typing import Any, NamedTuple

from transitions import Machine, MachineError

from rai_missions.engine.activities.goal_ledger import OpenGoal
from rai_missions.engine.chart_view import ChartView
from rai_missions.engine.modes import ALIVE, MODE_TABLE, MODES, Mode, next_mode
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.event import Origin
from rai_missions.states.control import HOLDERS, Holder

__all__ = ("Control", "Lifecycle", "Status", "status_of")


CONTROL_TRANSITIONS: list[dict[str, Any]] = [
    {"trigger": "hand_to_autonomy", "source": ["autonomy", "agent", "operator"], "dest": "autonomy"},
    {"trigger": "hand_to_agent", "source": ["autonomy", "agent", "operator"], "dest": "agent"},
    {"trigger": "hand_to_operator", "source": "*", "dest": "operator"},
    {"trigger": "hand_to_nobody", "source": "*", "dest": "nobody"},
]


class Status(NamedTuple):
    """What every other agent reads instead of remembering it."""

    revision: int
    """Counts every change; a reader with a lower one is out of date."""
    mode: Mode
    control: Holder
    active: tuple[str, ...]
    """The active states in the order of the hierarchy: outer before inner, in document order."""
    outcome: str | None = None
    why: str = ""
    waits: str = ""
    """What the run waits for, in words: facts of the robot, or someone to have control; empty where nothing does."""
    open_goals: tuple[OpenGoal, ...] = ()
    """The goals that may still be executing although nothing waits for them: the robot may still move."""
    held_by: str = ""
    """Who holds the mission up: the `operator`, who has taken control, or `nobody`; empty while it is not held."""
    held_since: float | None = None
    """Since when, in seconds on the run's clock; None while it is not held."""
    unreported: tuple[str, ...] = ()
    """The robot keys without which the run does not start, or does not continue in another process."""


def status_of(run: ChartView, revision: int = 0) -> Status:
    """How things are with a run."""
    unreported = run.unreported
    facts = f"waits for the robot: {', '.join(unreported)}" if unreported else ""
    control = _waits(run.waiting, run.holder, run.held_by) if run.mode in ALIVE else ""
    waits = "; ".join(filter(None, (facts, control)))
    return Status(
        revision,
        run.mode,
        run.holder,
        run.active_in_order,
        run.outcome,
        run.why,
        waits,
        run.loose_goals,
        run.held_by,
        run.held_since,
        unreported,
    )


@cache
def mode_machine() -> Machine:
    """The machine of the modes."""
    transitions = [{"trigger": each.trigger, "source": list(each.sources), "dest": each.target} for each in MODE_TABLE]
    return _machine(transitions, MODES)


@cache
def control_machine() -> Machine:
    """The machine of who holds control."""
    return _machine(CONTROL_TRANSITIONS, HOLDERS)


def _machine(transitions: list[dict[str, Any]], states: tuple[str, ...]) -> Machine:
    """A flat machine in the only setting that is safe: no `to_…` shortcuts, an illegal trigger is an error."""
    return Machine(
        model=None,
        states=list(states),
        transitions=transitions,
        initial=states[0],
        auto_transitions=False,
        ignore_invalid_triggers=False,
    )


class Position:
    """Where one run is in a machine.

    Args:
        machine: The machine, which all runs share.
        state: The name of its state.
    """

    __slots__ = ("_machine", "state")

    def __init__(self, machine: Machine, state: str) -> None:
        self._machine, self.state = machine, state

    def fire(self, trigger: str) -> None:
        """Go where a trigger leads from here.

        Raises:
            MachineError: It leads nowhere from here.
        """
        self._machine.events[trigger].trigger(self)


def _waits(waiting: Mapping[str, str], holder: str, held_by: str) -> str:
    """What waits for which holder of control, in words for the status; empty where nothing does."""
    if held_by:
        each = ", ".join(sorted(waiting))
        return f"held until the operator gives control back; {holder} has it" + (f"; {each} waits" if each else "")
    if not waiting:
        return ""
    each = ", ".join(f"{name} waits until control is with {wanted}" for name, wanted in sorted(waiting.items()))
    return f"{each}; {holder} has it"


class Control:
    """Who holds control. It is handed over by request and acknowledgement; a command of anybody else is refused."""

    def __init__(self, holder: str = "autonomy", *, kept: bool = False) -> None:
        self._position = Position(control_machine(), holder)
        self.requested: str | None = None
        """Whom it was asked for and has not reached yet."""
        self.kept = kept
        """The operator has taken it, rather than been given it by the mission; then only the operator gives it back.

        It ends with the operator's hold, also where that ends elsewhere: at a gate, given back or lost by silence.
        """

    @property
    def holder(self) -> str:
        return self._position.state

    def refuses(self, to: str, role: Origin) -> str:
        """Why a handover may not be asked for; empty if it may.

        Args:
            to: Who is to have control.
            role: Whose request it is, by the door through which it came.

        Raises:
            UsageError: No one of that name can hold control.
        """
        if to not in HOLDERS:
            raise UsageError(f"nobody called '{to}' can hold control; there is: {', '.join(HOLDERS)}")
        if role in ("viewer", "person"):
            return f"a {role} hands over no control; the operator does"
        if self.holder == "nobody" and role != "operator":
            return "control is with 'nobody' since the stop; only the operator can lift it"
        if self.kept and role != "operator" and to != "nobody":
            return "the operator has control and has not given it back"
        return ""

    def keep(self, *, is_kept: bool) -> None:
        """Whether the operator has taken it, in a run that another process began."""
        self.kept = is_kept

    def request(self, to: str, role: Origin) -> str:
        """Ask for a handover; returns why not, or empty."""
        why = self.refuses(to, role)
        if not why:
            self.requested = to
            if role == "operator":
                self.kept = to == "operator"
        return why

    def acknowledge(self, to: str) -> None:
        """The handover has happened where the actuators are.

        Raises:
            UsageError: It may not happen from here.
        """
        if self.holder == "nobody" and to == "nobody":
            return
        lifted, was_operators = self.holder == "nobody" and to != "operator", self.holder == "operator"
        try:
            if lifted:
                self._position.fire("hand_to_operator")
            self._position.fire(f"hand_to_{to}")
        except MachineError as error:
            raise UsageError(f"control cannot go from '{self.holder}' to '{to}': {error}") from None
        self.requested = None
        if was_operators and to != "operator":
            self.kept = False

    def follow(self, holder: str, *, taken: bool) -> None:
        """Note who holds control, and whether it was taken; what the operator asked for counts already.

        Raises:
            UsageError: It may not have happened from here.
        """
        if holder != self.holder:
            self.acknowledge(holder)
        self.kept = taken or (self.kept and self.requested == "operator")

    def give_up(self, to: str) -> None:
        """A handover that was asked for does not come."""
        if self.requested == to:
            self.requested = None
            self.kept = self.kept and self.holder == "operator"


class Lifecycle:
    """The mode of one run, with its revision."""

    def __init__(self) -> None:
        self._position = Position(mode_machine(), MODES[0])
        self.control = Control()
        self.revision = 0
        self._last: Status | None = None
        self._made_of: tuple[Any, ...] = ()
        """What the last status was made of; most steps change nothing in it."""

    @property
    def mode(self) -> str:
        return self._position.state

    def observe(self, step: Step, chart: ChartView) -> Status | None:
        """Follow a step of a chart, which has made it last; the new status if anything in it changed.

        Raises:
            UsageError: The step went a way that no mission may go.
        """
        mode, holder, held_by = chart.mode, chart.holder, chart.held_by
        if mode != self.mode:
            self._go(step, mode)
        self.control.follow(holder, taken=chart.taken)
        of_chart = chart.active, chart.outcome, chart.why, chart.waiting, chart.loose_goals, chart.held_since
        made_of = (mode, holder, held_by, chart.unreported, *of_chart)
        if made_of == self._made_of:
            return None
        self._made_of = made_of
        status = status_of(chart, self.revision)
        if status == self._last:
            return None
        self.revision += 1
        self._last = status._replace(revision=self.revision)
        return self._last

    def _go(self, step: Step, target: str) -> None:
        """Fire what the step names: its command, and the outcome with which the mission ended in it.

        A command that leads neither there nor on the way there was refused. The step that is seen first may be of a
        run that began in another process.
        """
        if self._last is None:
            self._position.state = target
            return
        command = step.event.name if step.event.kind == "command" else ""
        through = next_mode(self.mode, command)
        if through is not None and (through == target or next_mode(through, target) is not None):
            self._position.fire(command)
        if self.mode != target and next_mode(self.mode, target) is not None:
            self._position.fire(target)
        if self.mode != target:
            raise UsageError(f"a run cannot go from '{self.mode}' to '{target}'")
