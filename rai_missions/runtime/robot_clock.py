# SPDX-License-Identifier: Apache-2.0
"""Simulated time for a robot whose functions execute in this process, as slowly or as fast as they do.

Rule: time stops while a function executes, and jumps while all of them wait.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Protocol

from rai_missions.runtime.clock import SimulatedClock
from rai_missions.runtime.mailbox import Mailbox

__all__ = ("RobotClock", "SteeredTime")


class SteeredTime(Protocol):
    """Which functions of a robot execute, and which wait for an instant."""

    def follow(self, on_change: Callable[[], None]) -> None:
        """Have a function called, from any thread, whenever one begins to wait or returns."""

    def patience_s(self) -> float:
        """How long on the wall time is stopped for functions that execute; 0 if it may move."""

    @property
    def is_stuck(self) -> bool:
        """A function has executed for so long that time passes as on the wall."""

    @property
    def next_due(self) -> float:
        """The instant that the first of those that wait waits for; infinity where none does."""

    def advance(self, to: float) -> None:
        """Time has come to an instant."""


class RobotClock(SimulatedClock):
    """Time that moves only while every function of a robot waits in `run.sleep`, or has executed for too long.

    Then it passes as on the wall, so that what hangs has its time-out and holds up no run for good.

    Args:
        robot: Which functions execute and which wait; steered by this clock alone.
        speed: Simulated seconds to one of the wall at the most; infinity for as fast as it goes.
    """

    def __init__(self, robot: SteeredTime, speed: float = math.inf) -> None:
        super().__init__(None, speed)
        self._robot = robot

    def wait(self, mailbox: Mailbox, until: float, *, paced: bool) -> None:
        self._robot.follow(mailbox.wake)
        while mailbox.empty and self.now() < until:
            if (patience_s := self._robot.patience_s()) > 0:
                mailbox.wait(patience_s)
            else:
                speed = self._go_at(paced=paced or self._robot.is_stuck)
                self._go_to(mailbox, min(until, self._robot.next_due), speed)
        self._refill(mailbox)

    def taken(self, mailbox: Mailbox, *, paced: bool) -> None:
        if self._robot.patience_s() <= 0:
            super().taken(mailbox, paced=paced)

    def _flow(self, target: float) -> None:
        super()._flow(target)
        self._robot.advance(self.now())

    def _advance(self, target: float) -> None:
        super()._advance(target)
        self._robot.advance(target)
