# SPDX-License-Identifier: Apache-2.0
"""The server of an action that a function pursues: on a thread of its own, or on the robot's event loop.

Rule: the end of a goal is reported before its function counts as returned, so that no time passes in between.
"""

from __future__ import annotations

import inspect
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Protocol

from rai_missions.connectors.connector import Data, OnReport
from rai_missions.connectors.python_robot.action import ActionRun, GoalRun
from rai_missions.connectors.python_robot.robot import ActionFunction
from rai_missions.connectors.python_robot.robot_time import Execution, RobotTime, RunOver
from rai_missions.redaction import logger

if TYPE_CHECKING:
    from rai_missions.connectors.python_robot.tasks import EventLoop

__all__ = ("FunctionServer", "GoalHost")

log = logger(__name__)


class GoalHost(Protocol):
    """Knows the goals that functions of a robot pursue, and where these execute."""

    @property
    def time(self) -> RobotTime: ...
    @property
    def loop(self) -> EventLoop: ...

    def begin(self, goal_id: str, run: GoalRun[Any]) -> None:
        """A function is about to pursue a goal."""

    def end(self, goal_id: str) -> None:
        """Drop a goal whose function has returned, and whose end is reported."""

    def find(self, goal_id: str) -> GoalRun[Any] | None:
        """The run of a goal whose function has not returned."""

    def refresh(self) -> None:
        """Have every fact read again, so that what was done is known before it is reported as done."""


class FunctionServer:
    """The server of an action that a function pursues; an `ActionServer`."""

    def __init__(self, host: GoalHost, name: str, action: ActionFunction) -> None:
        self._host, self._name, self._action = host, f"action '{name}'", action

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        if inspect.iscoroutinefunction(self._action.pursue):
            self._begin_task(goal_id, goal, report)
        else:
            self._begin_thread(goal_id, goal, report)

    def cancel(self, goal_id: str) -> None:
        if (run := self._host.find(goal_id)) is not None:
            run.ask_to_cancel()

    def _begin_thread(self, goal_id: str, goal: Data, report: OnReport) -> None:
        run = ActionRun(goal_id, Execution(self._name, self._host.time), self._host.time, report)

        def pursue() -> None:
            with self._ending(goal_id, run):
                returned = self._action.pursue(dict(goal), run)
                self._host.refresh()
                run.finish(returned)

        self._begin(goal_id, run)
        threading.Thread(target=pursue, name=self._name, daemon=True).start()

    def _begin_task(self, goal_id: str, goal: Data, report: OnReport) -> None:
        loop = self._host.loop
        run = loop.run(goal_id, self._name, self._host.time, report)

        async def pursue() -> None:
            with self._ending(goal_id, run):
                returned = await self._action.pursue(dict(goal), run)
                await loop.apart(self._host.refresh)
                run.finish(returned)

        self._begin(goal_id, run)
        loop.begin(pursue())

    def _begin(self, goal_id: str, run: GoalRun[Any]) -> None:
        self._host.begin(goal_id, run)
        self._host.time.add(run.execution)
        run.report("accepted")

    @contextmanager
    def _ending(self, goal_id: str, run: GoalRun[Any]) -> Iterator[None]:
        """Whatever the function raises is an end; its end is known before time moves without it."""
        try:
            yield
        except RunOver:
            log.info("%s was ended, because the run is over", self._name)
        except BaseException as error:  # noqa: BLE001 - also an exit is the action's failure, never the process's
            run.fail(error)
        finally:
            self._host.end(goal_id)
            self._host.time.remove(run.execution)
