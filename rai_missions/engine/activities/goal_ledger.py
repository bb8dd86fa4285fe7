# SPDX-License-Identifier: Apache-2.0
"""The ledger of goals: each is kept from its start until its server has confirmed its end.

Rule: a goal leaves the ledger only by a confirmed end. One that nothing waits for is kept as orphaned or lost, and is
named to those who ask what may still move the robot.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, Literal, NamedTuple

from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.step import CancelGoal
from rai_missions.event import Event

__all__ = (
    "Goal",
    "GoalPhase",
    "Goals",
    "LedgerChange",
    "Obstruction",
    "OpenGoal",
    "awaited",
    "cancel",
    "give_up_overdue",
    "loose",
    "may_move",
    "next_overdue",
    "obstruction",
    "report",
    "stop_all",
)  # fmt: skip

CANCEL_S = 5.0
"""Seconds within which the end of a goal without an owner has to be confirmed."""
GIVEN_UP = ("orphaned", "lost")
"""The phases of goals whose end the run does not wait for."""


Obstruction = Literal["", "busy", "orphan"]
"""Why a start has to wait: a goal on the same resources has not ended; one never confirmed its end; empty for none."""
GoalPhase = Literal["sent", "running", "withdrawn", "canceling", "orphaned", "lost"]
"""`running` once accepted, `withdrawn` (canceled as soon as it is accepted), `orphaned` (its end was not confirmed in
time), `lost` (its server is gone, which ends it for the mission alone)."""


Reason = Literal["orphaned", "refused", "lost"]
"""Why a goal may still be executing: see `REASONS`."""
REASONS: Mapping[Reason, str] = {
    "orphaned": "its end was not confirmed",
    "refused": "its server refuses to cancel it",
    "lost": "its server is gone",
}


class OpenGoal(NamedTuple):
    """A goal that may still be executing somewhere, although nothing waits for it."""

    number: int
    """The number of its start."""
    action: str
    """The action's name in the mission."""
    owner: str
    """The state, or the leaf of a tree, that started it."""
    reason: Reason

    def words(self) -> str:
        """In words: `goal 3 of 'drive' (its server refuses to cancel it)`."""
        return f"goal {self.number} of '{self.action}' ({REASONS[self.reason]})"

    def data(self) -> dict[str, Any]:
        """As JSON has it."""
        return self._asdict()


def may_move(goals: Iterable[OpenGoal]) -> str:
    """The warning that open goals deserve; empty without any."""
    each = ", ".join(goal.words() for goal in goals)
    return f"the robot may still move: {each}" if each else ""


class Goal(NamedTuple):
    """One goal that was sent."""

    number: int
    owner: str
    action: str
    cancel_s: float
    phase: GoalPhase = "sent"
    until: float = math.inf
    """When a cancel must have been confirmed."""
    is_refused: bool = False
    """Its server has refused to cancel it."""
    is_lost: bool = False
    """Its server is gone, and its end for the mission is on its way."""


Goals = dict[int, Goal]
"""Number → goal: all whose end is not confirmed."""


def obstruction(goals: Goals, facts: RobotFacts, action: str) -> Obstruction:
    """Whether a goal prevents a start.

    One that was lost does not: it is its connector's concern until its server is back.
    """
    rivals = [goal for goal in goals.values() if goal.phase != "lost" and facts.conflict(goal.action, action)]
    if any(goal.phase != "orphaned" for goal in rivals):
        return "busy"
    return "orphan" if rivals else ""


def awaited(goals: Goals) -> int:
    """How many goals have an end that the run waits for; from any thread."""
    return sum(goal.phase not in GIVEN_UP for goal in tuple(goals.values()))


def reason_of(goal: Goal) -> Reason:
    """Why no cancel can be relied on to end a goal."""
    if goal.is_refused:
        return "refused"
    return "lost" if goal.phase == "lost" else "orphaned"


def loose(goals: Goals) -> tuple[OpenGoal, ...]:
    """The goals that may still be executing and that no cancel can be relied on to end; from any thread."""
    found = [goal for goal in tuple(goals.values()) if goal.phase in GIVEN_UP or goal.is_refused] if goals else ()
    return tuple(OpenGoal(goal.number, goal.action, goal.owner, reason_of(goal)) for goal in found) if found else ()


def cancel(goals: Goals, number: int, at: float) -> tuple[CancelGoal, ...]:
    """End a goal: what is to be sent now; before its acceptance that is nothing yet."""
    goal = goals.get(number)
    if goal is None or goal.phase in ("withdrawn", "canceling", *GIVEN_UP):
        return ()
    accepted = goal.phase == "running"
    goals[number] = goal._replace(phase="canceling" if accepted else "withdrawn", until=at + goal.cancel_s)
    return (CancelGoal(number, goal.action),) if accepted else ()


def stop_all(goals: Goals, at: float) -> tuple[CancelGoal, ...]:
    """Cancel whatever may run, accepted or not: the e-stop does not wait for an acceptance."""
    for number, goal in goals.items():
        if goal.phase != "lost":
            goals[number] = goal._replace(phase="canceling", until=min(goal.until, at + goal.cancel_s))
    return tuple(CancelGoal(goal.number, goal.action) for goal in goals.values())


class LedgerChange(NamedTuple):
    """What a report makes of the goals."""

    cancels: tuple[CancelGoal, ...] = ()
    """The cancel that waited for it, or that it calls for."""
    is_end: bool = False
    """A goal has ended, or no longer bars a start."""


def report(goals: Goals, event: Event) -> LedgerChange:
    """Take note of what was reported of a goal."""
    goal = goals.get(event.number)
    if event.kind == "stray":
        return LedgerChange(_chase(goals, event))
    if goal is None:
        return LedgerChange()
    if event.kind == "result" and goal.is_lost:
        goals[event.number] = goal._replace(phase="lost", until=math.inf)
        return LedgerChange(is_end=True)
    if event.kind in ("result", "over"):
        del goals[event.number]
        return LedgerChange(is_end=True)
    if event.kind == "refused":
        goals[event.number] = goal._replace(is_refused=True)
    elif event.kind == "lost":
        goals[event.number] = goal._replace(is_lost=True)
    elif event.kind == "overdue" and goal.phase in ("withdrawn", "canceling"):
        goals[event.number] = goal._replace(until=min(goal.until, event.at))
    elif event.kind == "accepted" and goal.phase == "sent":
        goals[event.number] = goal._replace(phase="running")
    elif event.kind == "accepted" and goal.phase in ("withdrawn", "canceling", "orphaned"):
        # A cancel that was sent before the acceptance, by an e-stop, may have reached no goal: once more.
        goals[event.number] = goal._replace(phase="orphaned" if goal.phase == "orphaned" else "canceling")
        return LedgerChange((CancelGoal(goal.number, goal.action),))
    return LedgerChange()


def _chase(goals: Goals, event: Event) -> tuple[CancelGoal, ...]:
    """A goal whose end was reported is executing at some server: it has no owner, and is canceled."""
    owner, cancel_s = str(event.data.get("owner", "")), float(event.data.get("cancel_s", CANCEL_S))
    goal = goals.get(event.number) or Goal(event.number, owner, event.name, cancel_s)
    goals[event.number] = goal._replace(phase="canceling", until=event.at + goal.cancel_s)
    return (CancelGoal(goal.number, goal.action),)


def give_up_overdue(goals: Goals, at: float) -> list[Goal]:
    """Make orphans of the goals whose cancel was not confirmed in time; returns them as they were before."""
    late = [goal for goal in goals.values() if goal.phase in ("withdrawn", "canceling") and at >= goal.until]
    for goal in late:
        goals[goal.number] = goal._replace(phase="orphaned", until=math.inf)
    return late


def next_overdue(goals: Goals) -> float:
    """The next instant at which a cancel is overdue; infinity for none."""
    soonest = math.inf
    for goal in goals.values():
        if goal.until < soonest and goal.phase not in GIVEN_UP:
            soonest = goal.until
    return soonest
