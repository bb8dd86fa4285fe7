# SPDX-License-Identifier: Apache-2.0
"""What the action servers of our worlds share: one goal at a time, whose reports leave when a step is over."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, ClassVar, Literal, Protocol, runtime_checkable

from rai_missions.connectors.connector import Data, OnReport, Report

__all__ = ("End", "GoalServer", "Later", "RunningGoal", "SupportsHeir")

FEEDBACK_S = 0.5
End = Literal["succeeded", "failed", "canceled"]
GoalStatus = Literal["accepted", "rejected", "feedback", End]
Later = Callable[[Callable[[], None]], None]
"""Does something once the world's step is over and its lock is free."""


def unreported(report: Report) -> None:
    """Takes the reports about a goal whose client is in another world."""


@dataclass
class RunningGoal:
    """The goal being pursued."""

    LEADS_OUT: ClassVar = {"on_report": lambda: unreported}

    goal_id: str
    on_report: OnReport
    begun: float
    number: int = 0
    """Of the navigation's goals."""
    place: tuple[float, float] = (0.0, 0.0)
    is_unwanted: bool = False
    next_feedback: float = 0.0
    arrived_at: float | None = None


@runtime_checkable
class SupportsHeir(Protocol):
    """A server in the branch of a world, whose goal's client is in the other world."""

    def continue_with(self, client_of: Callable[[str], OnReport]) -> None:
        """Report about the goal that is pursued, if there is one without a client, to the client of its id."""


class GoalServer:
    """The reports about one goal at a time.

    Args:
        later: Reports go out through it.
        at: Simulated seconds at the start.
    """

    def __init__(self, later: Later, at: float) -> None:
        self._later, self.at = later, at
        self.running: RunningGoal | None = None

    def continue_with(self, client_of: Callable[[str], OnReport]) -> None:
        """Report about the goal that is pursued, if there is one without a client, to the client of its id."""
        if self.running is not None and self.running.on_report is unreported:
            self.running.on_report = client_of(self.running.goal_id)

    def _begin(self, running: RunningGoal) -> None:
        self.running = running
        self._report(running, "accepted")

    def _reject(self, running: RunningGoal, why: str) -> None:
        self._report(running, "rejected", why=why)

    def _end(self, running: RunningGoal, end: End, result: Data, why: str) -> None:
        self.running = None
        self._report(running, end, result, why)

    def _feed_back(self, running: RunningGoal, feedback: Callable[[float], dict[str, Any]]) -> None:
        """Report feedback, if it is time; it is made of how long the goal has been pursued."""
        if self.at >= running.next_feedback:
            running.next_feedback = self.at + FEEDBACK_S
            self._report(running, "feedback", feedback(self.at - running.begun))

    def _report(self, running: RunningGoal, status: GoalStatus, data: Data | None = None, why: str = "") -> None:
        self._later(lambda: running.on_report(Report(running.goal_id, status, data or {}, why)))
