# SPDX-License-Identifier: Apache-2.0
"""How a run ended."""

from __future__ import annotations

from typing import NamedTuple

from rai_missions.engine.activities.goal_ledger import OpenGoal, may_move
from rai_missions.states.final import FinalOutcome

__all__ = ("Result",)


class Result(NamedTuple):
    """How a run ended."""

    outcome: FinalOutcome
    """`succeeded`, `failed`, `aborted` or `canceled`."""
    why: str
    """The rule that decided it."""
    steps: int
    """As `step_count` counts those of its journal."""
    journal: str | None = None
    """The journal's file."""
    run: str = ""
    """The run's identity."""
    state: tuple[str, ...] = ()
    """The states in which it ended."""
    decisions: int = 0
    """Questions that were asked; those to an answerer that was absent are not counted."""
    duration_s: float = 0.0
    """On the run's clock."""
    open_goals: tuple[OpenGoal, ...] = ()
    """The goals of the run that may still be executing: the robot may still move."""
    moved_aside: str | None = None
    """Where the journal of an earlier run is now, whose name this one's took."""

    @property
    def warning(self) -> str:
        """What a person near the robot has to know: which goals may still move it; empty if none does."""
        return may_move(self.open_goals)
