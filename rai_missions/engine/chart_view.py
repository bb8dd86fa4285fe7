# SPDX-License-Identifier: Apache-2.0
"""What may be read of a chart: its time, its mode, its states, its questions and goals, and who has control.

Rule: nothing is changed here. But for a snapshot it may be read from any thread.
"""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.engine.activities.goal_ledger import OpenGoal, awaited, loose
from rai_missions.engine.activities.tree import questions_in
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.decision import Question
from rai_missions.engine.modes import Mode
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.semantics.hold import held_by, holder_of, live
from rai_missions.engine.semantics.waiting import waiting_answers
from rai_missions.engine.snapshot import Snapshot, snapshot
from rai_missions.engine.state import RunState
from rai_missions.engine.step import Cause
from rai_missions.event import Event
from rai_missions.mission.mission import Mission
from rai_missions.states.control import Holder
from rai_missions.states.final import FinalOutcome

__all__ = ("ChartView",)


class ChartView:
    """A run of a mission, to be read.

    Args:
        program: The compiled mission.
        state: What the run remembers.
    """

    def __init__(self, program: Program, state: RunState) -> None:
        self._program, self._state = program, state

    def snapshot(self) -> Snapshot:
        """All that the run remembers, as values that later steps do not change; on the run's own thread."""
        return snapshot(self._program, self._state)

    @property
    def mission(self) -> Mission:
        """The mission."""
        return self._program.mission

    @property
    def robot_facts(self) -> RobotFacts:
        """What is known of the robot."""
        return self._program.robot_facts

    @property
    def at(self) -> float:
        """Now, in seconds on the run's clock."""
        return self._state.at

    @property
    def seq(self) -> int:
        """Steps so far."""
        return self._state.seq

    @property
    def mode(self) -> Mode:
        """`ready`, `running`, `paused` or `canceling`; of a run that has ended, its outcome."""
        return self._state.shown_mode

    @property
    def unstarted(self) -> bool:
        """Whether the run has neither been started nor ended: `ready`, or paused before its start."""
        return self._state.mode == "ready"

    @property
    def held_back(self) -> bool:
        """Whether the run was paused before its start, and not resumed: it does not begin by itself."""
        return self._state.held_back

    @property
    def active(self) -> frozenset[str]:
        """The names of the active states, ancestors included."""
        return self._state.active

    @property
    def active_in_order(self) -> tuple[str, ...]:
        """The names of the active states in the order of the mission's text, found without a look at the others."""
        nodes = self._program.graph.nodes
        return tuple(sorted(self._state.active, key=lambda name: nodes[name].index))

    @property
    def rounds(self) -> Mapping[str, tuple[int, int]]:
        """Active `each` → how many of its items are over, and how many it has: those of its entry."""
        return {name: (over, len(items)) for name, (items, over) in tuple(self._state.rounds.items())}

    @property
    def outcome(self) -> FinalOutcome | None:
        """How the mission ended; None while it runs."""
        return self._state.outcome

    @property
    def why(self) -> str:
        """The rule that decided the outcome."""
        return self._state.why

    @property
    def cause(self) -> Cause:
        """What has ended the mission, where no rule of it did."""
        return self._state.cause

    @property
    def false_invariant(self) -> str:
        """The name of the invariant that has ended the mission; empty for any other end."""
        return self._state.false_invariant

    @property
    def wake_at(self) -> float | None:
        """The earliest instant at which time alone can change something."""
        return self._state.wake_at

    @property
    def unreported(self) -> tuple[str, ...]:
        """The robot keys that the start waits for: never received, or stale whenever they were."""
        state, waited = self._state, self.mission.needed_facts() if self.unstarted else ()
        return tuple(name for name in waited if name not in state.board or name in state.outdated)

    @property
    def questions(self) -> tuple[Question, ...]:
        """The open questions, the oldest first, each with the time that it has by now."""
        found = (each for _, _, activity in live(self._program, self._state) for each in questions_in(activity))
        return tuple(sorted(found, key=lambda question: question.number))

    @property
    def waiting_answers(self) -> tuple[Event, ...]:
        """The answers that are judged once a pause ends, or control is given back."""
        return waiting_answers(self._state)

    @property
    def awaited(self) -> frozenset[int]:
        """The numbers of goals, calls, questions and behaviours whose end the run still waits for."""
        each = (machine.awaits(activity) for _, machine, activity in live(self._program, self._state))
        return frozenset(self._state.goals).union(self._state.calls, *each)

    @property
    def awaited_goals(self) -> int:
        """How many goals have an end that has not been confirmed and that the run waits for.

        Those that are left unconfirmed, `open_goals` of `Result` and of the status, are `loose_goals`.
        """
        return awaited(self._state.goals)

    @property
    def loose_goals(self) -> tuple[OpenGoal, ...]:
        """The goals that may still be executing, and that no cancel can be relied on to end."""
        return loose(self._state.goals)

    # -- who has control ------------------------------------------------------------------------------------------

    @property
    def holder(self) -> Holder:
        """Who holds control."""
        return holder_of(self._program, self._state)

    @property
    def taken(self) -> bool:
        """The operator holds it and has taken it, rather than been given it by the mission."""
        return self._state.taken

    @property
    def waiting(self) -> Mapping[str, str]:
        """State → who must have control before what it does can begin, or begin again."""
        nodes, state = self._program.graph.nodes, self._state
        each = {name: nodes[name].control for name in (*state.awaiting_control, *state.held_starts)}
        return {name: holder for name, holder in each.items() if holder is not None}

    @property
    def wanted(self) -> frozenset[str]:
        """Who must have control for what waits to begin."""
        wanted = (self._program.graph.nodes[name].control for name in tuple(self._state.awaiting_control))
        return frozenset(holder for holder in wanted if holder is not None)

    @property
    def held_by(self) -> str:
        """`operator`, who has taken control, or `nobody`; empty while the mission is not held."""
        return held_by(self._state)

    @property
    def held_since(self) -> float | None:
        """Since when, in seconds on the run's clock; None while the mission is not held."""
        return self._state.held_since if self.held_by else None

    @property
    def paused_at(self) -> float | None:
        """Since when no question loses time; None while the run is not paused."""
        return self._state.paused_at if self.mode == "paused" else None

    def still_since(self, name: str) -> float | None:
        """Since when the time of a state is stopped, in seconds on the run's clock; None while it runs."""
        state, control = self._state, self._program.graph.nodes[name].control
        instants = [state.paused_at] if self.mode == "paused" else []
        instants += [state.frozen[control]] if control in state.frozen else []
        return min(instants, default=None)
