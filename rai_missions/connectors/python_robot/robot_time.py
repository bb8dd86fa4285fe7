# SPDX-License-Identifier: Apache-2.0
"""The run's time as a robot's functions see it: which of them execute now, and which wait for an instant.

Rule: time that is steered does not move here. A run's clock moves it, while every function waits.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable

from rai_missions.redaction import logger

__all__ = ("Execution", "RobotTime", "RunOver")

log = logger(__name__)

PATIENCE_S = 5.0
"""So long on the wall steered time stops for a function that executes and does not wait."""
UNSTUCK = (
    "%s has executed for %g s without waiting in run.sleep: simulated time stopped for it, and passes as on the "
    "wall until it waits or returns; use run.sleep instead of time.sleep, or run without --speed max"
)


class RunOver(BaseException):
    """Raised in `run.sleep` once the run is over and waits no longer: a function that ignores its cancel ends there."""


class Execution:
    """A function that was called and has not returned.

    Args:
        name: The name of the fact, service or action.
        robot_time: Of its run.
    """

    def __init__(self, name: str, robot_time: RobotTime) -> None:
        self.name, self._time = name, robot_time
        self._release = threading.Event()
        self.due: float | None = None
        """It waits until then; None while it executes."""
        self.since = time.monotonic()
        """When it began to execute, on the wall."""
        self.is_named = False
        self.is_over = False

    def sleep(self, seconds: float) -> None:
        """Wait for seconds of the run's clock, or until `release`.

        Raises:
            RunOver: The run is over.
        """
        if self._time.wait(self, seconds):
            self._release.wait(None if self._time.is_steered else min(seconds, threading.TIMEOUT_MAX))
            self._release.clear()  # only now: a cancel that came just before the wait ends it at once
        self._time.awake(self)
        if self.is_over:
            raise RunOver

    def release(self) -> None:
        """End its wait; from any thread."""
        self._release.set()


class RobotTime:
    """Who executes and who waits; and, where it is steered, the time itself.

    Args:
        steered: It moves by `advance` alone. Else it passes as on the wall, by itself.
    """

    def __init__(self, *, steered: bool = False) -> None:
        self.is_steered = steered
        self.at = 0.0
        """Of steered time: now, in seconds."""
        self._lock = threading.RLock()
        self._all: dict[Execution, None] = {}
        self._is_over = False
        self._on_change: Callable[[], None] = _nothing

    def follow(self, on_change: Callable[[], None]) -> None:
        """Have a function called, from any thread, whenever one of the robot's begins to wait or returns."""
        self._on_change = on_change

    def open(self) -> None:
        """A run begins."""
        self._is_over = False

    def add(self, execution: Execution) -> None:
        """A function is about to be called."""
        with self._lock:
            execution.is_over = self._is_over
            self._all[execution] = None

    def remove(self, execution: Execution) -> None:
        """Forget an execution that has returned."""
        with self._lock:
            self._all.pop(execution, None)
        if self.is_steered:
            self._on_change()

    def wait(self, execution: Execution, seconds: float) -> bool:
        """A function begins to wait; whether it has to."""
        with self._lock:
            if execution.is_over or not seconds > 0:
                return False
            execution.due = self.at + seconds
        if self.is_steered:
            self._on_change()
        return True

    def awake(self, execution: Execution) -> None:
        """Note that an execution waits no more."""
        with self._lock:
            if execution.due is not None:
                execution.due, execution.since, execution.is_named = None, time.monotonic(), False

    def wake(self, execution: Execution) -> None:
        """End a wait before its time."""
        with self._lock:
            self.awake(execution)  # it executes from now on: time must not move before its thread has noticed
            execution.release()

    def close(self) -> None:
        """The run is over: whatever waits now or later ends by `RunOver`."""
        with self._lock:
            self._is_over, self._on_change = True, _nothing
            for execution in self._all:
                execution.is_over = True
                execution.release()

    # -- steered time -------------------------------------------------------------------------------------------------

    @property
    def next_due(self) -> float:
        """The instant that the first of those waits for; infinity where none does."""
        with self._lock:
            return min((each.due for each in self._all if each.due is not None), default=math.inf)

    def patience_s(self) -> float:
        """How long on the wall time is stopped for functions that execute; 0 if it may move.

        One that does not wait for too long is named in the log, once until it does.
        """
        now, left_s = time.monotonic(), 0.0
        with self._lock:
            executing = [each for each in self._all if each.due is None]
        for each in executing:
            left_s = max(left_s, each.since + PATIENCE_S - now)
            if each.since + PATIENCE_S <= now and not each.is_named:
                each.is_named = True
                log.warning(UNSTUCK, each.name, PATIENCE_S)
        return left_s

    @property
    def is_stuck(self) -> bool:
        """A function does not wait for so long that time passes as on the wall."""
        with self._lock:
            return any(each.due is None for each in self._all)

    def advance(self, to: float) -> None:
        """Steered time has come to an instant; functions whose wait is over execute from now on."""
        with self._lock:
            self.at = max(self.at, to)
            for execution in [each for each in self._all if each.due is not None and each.due <= self.at]:
                self.wake(execution)


def _nothing() -> None:
    """No clock follows."""
