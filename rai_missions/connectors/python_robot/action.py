# SPDX-License-Identifier: Apache-2.0
"""One goal pursued by a function: what the function may ask and report, and how its return or exception is an end.

Rule: whatever the function does, exactly one end is reported.
"""

from __future__ import annotations

import sysconfig
import traceback
from collections.abc import Mapping
from pathlib import Path
from typing import Any, Generic, Literal, TypeVar

from rai_missions.connectors.connector import Data, OnReport, Report
from rai_missions.connectors.python_robot.robot_time import Execution, RobotTime
from rai_missions.errors import meant
from rai_missions.redaction import cut, cut_repr, logger

__all__ = ("ActionRun", "GoalRun", "fault_of", "response_of")

log = logger(__name__)

E = TypeVar("E", bound=Execution)
ActionStatus = Literal["accepted", "feedback", "succeeded", "failed", "canceled", "overdue"]
NOTHING: Data = {}
OURS = str(Path(__file__).parent)
LIBRARIES = tuple({sysconfig.get_path(each) for each in ("stdlib", "purelib", "platlib")})
"""Where an author has written nothing: the place of a fault is the last line outside of them."""


class CancelResult:
    """What `run.cancel()` gives, to be returned."""


CANCELED = CancelResult()


class GoalRun(Generic[E]):
    """What the function of an action knows of the run of its goal.

    Args:
        goal_id: The goal's.
        execution: Its function's.
        robot_time: Of its run.
        on_report: Who is notified.
    """

    def __init__(self, goal_id: str, execution: E, robot_time: RobotTime, on_report: OnReport) -> None:
        self._goal_id, self.execution, self._time, self._on_report = goal_id, execution, robot_time, on_report
        self._is_canceled = False

    @property
    def canceled(self) -> bool:
        """The mission wants the goal to end: stop what moves, and `return run.cancel()`."""
        return self._is_canceled

    def cancel(self) -> CancelResult:
        """Return this: the goal has ended because it was canceled."""
        return CANCELED

    def feedback(self, value: Any) -> None:
        """Report progress: a dict, or a value of plain data, which is then the field `value`."""
        data = value if isinstance(value, Mapping) else {"value": value}
        self.report("feedback", data=data)

    def ask_to_cancel(self) -> None:
        """The mission asks for the end: a wait ends at once, and later ones last as long as they should."""
        self._is_canceled = True
        self._time.wake(self.execution)

    def report(self, status: ActionStatus, why: str = "", data: Data = NOTHING) -> None:
        """Report how the goal is going, or its end."""
        self._on_report(Report(self._goal_id, status, data, why))

    def finish(self, returned: Any) -> None:
        """The function has returned."""
        if isinstance(returned, CancelResult):
            self.report("canceled")
            return
        try:
            self.report("succeeded", data=response_of(self.execution.name, "result", returned))
        except TypeError as error:
            self.report("failed", str(error))

    def fail(self, error: BaseException) -> None:
        """The function has raised."""
        why = fault_of(error)
        log.warning("%s failed: %s", self.execution.name, why)
        self.report("failed", why)


class ActionRun(GoalRun[Execution]):
    """The run of a goal that a function pursues on a thread of its own."""

    def sleep(self, seconds: float) -> None:
        """Wait for seconds of the run's clock; less where the mission cancels the goal meanwhile."""
        self.execution.sleep(seconds)


def response_of(name: str, what: str, returned: Any) -> Data:
    """What a function has returned, as a result or a response.

    Raises:
        TypeError: It is no dict.
    """
    if returned is None:
        return {}
    if not isinstance(returned, Mapping):
        raise TypeError(f"{name} returned {cut_repr(returned, 60)}; its {what} is a dict or None")
    return returned


def fault_of(error: BaseException) -> str:
    """The last line of an exception, and its place: `ValueError: no motor (my_robot.py, line 17, in drive)`."""
    last = traceback.format_exception_only(error)[-1].strip()
    frames = [each for each in traceback.extract_tb(error.__traceback__) if not each.filename.startswith(OURS)]
    frames = [each for each in frames if not each.filename.startswith(LIBRARIES)] or frames
    place = f" ({Path(frames[-1].filename).name}, line {frames[-1].lineno}, in {frames[-1].name})" if frames else ""
    return cut(last, 300) + place + (meant(error) if "Did you mean" not in last else "")
