# SPDX-License-Identifier: Apache-2.0
"""A run, seen from outside: what may be done to it, and how it ended."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any, NamedTuple, Protocol

from rai_missions.engine.activities.goal_ledger import OpenGoal, may_move
from rai_missions.event import Event
from rai_missions.states.final import FinalOutcome

__all__ = ("Commands", "Result")


class Result(NamedTuple):
    """How a run ended."""

    outcome: FinalOutcome
    """`succeeded`, `failed`, `aborted` or `canceled`."""
    why: str
    """The rule that decided it."""
    steps: int
    journal: str | None = None
    """The journal's file."""
    run: str = ""
    state: tuple[str, ...] = ()
    """The states in which it ended."""
    decisions: int = 0
    """Questions that were asked."""
    duration_s: float = 0.0
    open_goals: tuple[OpenGoal, ...] = ()
    """The goals of the run that may still be executing: the robot may still move."""
    moved_aside: str | None = None
    """Where the journal of an earlier run is now, whose name this one's took."""

    @property
    def warning(self) -> str:
        """What a person near the robot has to know: which goals may still move it; empty if none does."""
        return may_move(self.open_goals)


class Commands(Protocol):
    """What a person or another program may do to a run; each from any thread, each an event in the journal."""

    def pause(self, by: str = "operator") -> None: ...

    def resume(self, by: str = "operator") -> None: ...

    def cancel(self, by: str = "operator") -> None: ...

    def kill(self, by: str = "operator") -> None: ...

    def control(self, to: str, by: str = "operator") -> str:
        """Ask for control to change its holder; returns why it may not, or empty."""

    def answer(
        self, number: int, option: str, parameters: Mapping[str, Any] | None = None, by: str = "operator"
    ) -> None:
        """Answer an open question."""

    def post(self, event: Event) -> None:
        """Something has happened outside."""
