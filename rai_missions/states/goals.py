# SPDX-License-Identifier: Apache-2.0
"""The ledger of goals: each stands here from its start until its server has confirmed its end.

Rule: a goal is nobody's only when its end is confirmed or when it is written down as orphaned.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, NamedTuple

from rai_missions.event import Event
from rai_missions.states.terms import Terms
from rai_missions.step import CancelGoal

__all__ = ("Goal", "Ledger")


class Goal(NamedTuple):
    """One goal that was sent."""

    number: int
    owner: str
    action: str
    cancel_s: float
    phase: str = "sent"
    """`sent`, `running` once accepted, `withdrawn` (canceled as soon as it is accepted), `canceling`, `orphaned`."""
    until: float = math.inf
    """When a cancel must have been confirmed."""


class Ledger:
    """All goals whose end is not confirmed."""

    def __init__(self, terms: Terms) -> None:
        self.terms = terms
        self.goals: dict[int, Goal] = {}
        self.changed = False
        """A goal has ended or was given up since the machines were last told."""

    def open(self, number: int, owner: str, action: str, cancel_s: float) -> None:
        self.goals[number] = Goal(number, owner, action, cancel_s)

    def obstruction(self, action: str) -> str:
        """`busy`, `orphan` or empty: whether a goal stands in the way of a start."""
        rivals = [goal for goal in self.goals.values() if self.terms.conflict(goal.action, action)]
        if any(goal.phase != "orphaned" for goal in rivals):
            return "busy"
        return "orphan" if rivals else ""

    def cancel(self, number: int, at: float) -> tuple[CancelGoal, ...]:
        """End a goal: what is to be sent now; before its acceptance that is nothing yet."""
        goal = self.goals.get(number)
        if goal is None or goal.phase in ("withdrawn", "canceling", "orphaned"):
            return ()
        accepted = goal.phase == "running"
        phase = "canceling" if accepted else "withdrawn"
        self.goals[number] = goal._replace(phase=phase, until=at + goal.cancel_s)
        return (CancelGoal(number, goal.action),) if accepted else ()

    def stop_all(self, at: float) -> tuple[CancelGoal, ...]:
        """Cancel whatever may run, accepted or not: the emergency stop does not wait for an acceptance."""
        cancels = tuple(CancelGoal(goal.number, goal.action) for goal in self.goals.values())
        self.goals = {
            number: goal._replace(phase="canceling", until=min(goal.until, at + goal.cancel_s))
            for number, goal in self.goals.items()
        }
        return cancels

    def hear(self, event: Event) -> tuple[CancelGoal, ...]:
        """An acceptance or an end; returns the cancel that waited for it."""
        goal = self.goals.get(event.number)
        if goal is None:
            return ()
        if event.kind == "result":
            self.finish(event.number)
        elif event.kind == "accepted" and goal.phase == "sent":
            self.goals[event.number] = goal._replace(phase="running")
        elif event.kind == "accepted" and goal.phase in ("withdrawn", "canceling", "orphaned"):
            # A cancel that was sent before the acceptance, by an emergency stop, may have reached no goal: once more.
            phase = "orphaned" if goal.phase == "orphaned" else "canceling"
            self.goals[event.number] = goal._replace(phase=phase)
            return (CancelGoal(goal.number, goal.action),)
        return ()

    def finish(self, number: int) -> None:
        """A goal has ended."""
        self.changed = self.goals.pop(number, None) is not None or self.changed

    def overdue(self, at: float) -> list[Goal]:
        """Goals whose cancel was not confirmed in time; they are orphaned from now on."""
        late = [goal for goal in self.goals.values() if goal.phase in ("withdrawn", "canceling") and at >= goal.until]
        self.changed = self.changed or bool(late)
        for goal in late:
            self.goals[goal.number] = goal._replace(phase="orphaned", until=math.inf)
        return late

    def wake_at(self) -> float:
        """The next instant at which a cancel is overdue."""
        return min((goal.until for goal in self.goals.values() if goal.phase != "orphaned"), default=math.inf)

    def saved(self) -> list[list[Any]]:
        return [list(goal) for goal in self.goals.values()]

    def restore(self, saved: Iterable[Iterable[Any]]) -> None:
        self.goals = {goal.number: goal for goal in (Goal(*fields) for fields in saved)}
