# SPDX-License-Identifier: Apache-2.0
"""A function that is asked for a key's value again and again, on a thread of its own.

Rule: one that raises or hangs brings nothing; the key's last value then goes stale.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Any

from rai_missions.connectors.python_robot.action import fault_of
from rai_missions.connectors.python_robot.robot_time import Execution, RobotTime, RunOver
from rai_missions.redaction import logger

__all__ = ("FactPoll", "refresh")

log = logger(__name__)

REFRESH_S = 2.0
"""So long on the wall what was done waits for readings that began after it."""


class FactPoll:
    """The readings of one fact; begins at once.

    Args:
        name: The key.
        read: Gives its value; None for nothing new.
        every_s: Seconds of the run's clock from the end of a reading to the next.
        robot_time: Of the run.
        on_value: Receives each value.
    """

    def __init__(
        self,
        name: str,
        read: Callable[[], Any],
        every_s: float,
        *,
        robot_time: RobotTime,
        on_value: Callable[[Any], None],
    ) -> None:
        self._name, self._read, self._every_s, self._on_value = name, read, every_s, on_value
        self._time, self._execution = robot_time, Execution(f"fact '{name}'", robot_time)
        self._changed = threading.Condition()
        self._begun = self._ended = self._wanted = 0
        self._is_stopped = self._is_late = False
        self._last_fault = ""
        robot_time.add(self._execution)
        threading.Thread(target=self._work, name=f"fact '{name}'", daemon=True).start()

    def stop(self) -> None:
        """Read no more; a reading under way brings nothing, and holds up no one who waits for it."""
        self._end()
        self._time.wake(self._execution)

    def _end(self) -> None:
        with self._changed:
            self._is_stopped = True
            self._changed.notify_all()

    def want(self) -> int:
        """Have a reading begin as soon as there is none under way; returns its number."""
        with self._changed:
            self._wanted = self._begun + 1
        self._time.wake(self._execution)
        return self._wanted

    def wait_for(self, number: int, until: float) -> None:
        """Return once a reading has ended, or at an instant of `time.monotonic`; at once while it hangs since then."""
        with self._changed:
            if not self._is_late:
                has_ended = lambda: self._ended >= number or self._is_stopped  # noqa: E731
                self._is_late = not self._changed.wait_for(has_ended, until - time.monotonic())

    def report_first(self) -> None:
        """Report where its first reading has not ended yet."""
        with self._changed:
            is_late = not self._ended and not self._is_stopped
        if is_late:
            log.warning("fact '%s': its function has not returned yet, so the key has no value", self._name)

    def _work(self) -> None:
        try:
            while not self._is_stopped:
                with self._changed:
                    self._begun += 1
                self._read_once()
                with self._changed:
                    self._ended, self._is_late = self._begun, False
                    self._changed.notify_all()
                    is_wanted = self._wanted > self._begun
                if not is_wanted:
                    self._execution.sleep(self._every_s)
        except RunOver:
            return
        finally:
            self._end()  # whatever ended it: a reading that will never begin is waited for by no one
            self._time.remove(self._execution)

    def _read_once(self) -> None:
        try:
            value = self._read()
        except BaseException as error:  # noqa: BLE001 - whatever a function raises, it is asked again
            last_line = fault_of(error)
            if last_line != self._last_fault:
                self._last_fault = last_line
                log.warning("fact '%s' failed and counts as not received: %s", self._name, last_line)
            return
        if value is not None and not self._is_stopped:
            self._on_value(value)


def refresh(polls: list[FactPoll]) -> None:
    """Wait for a reading of each fact that begins now: what was just done is then known before it is reported as done.

    A fact that hangs is waited for once, for two seconds on the wall.
    """
    until = time.monotonic() + REFRESH_S
    for poll, number in [(poll, poll.want()) for poll in polls]:
        poll.wait_for(number, until)
