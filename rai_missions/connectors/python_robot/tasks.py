# SPDX-License-Identifier: Apache-2.0
"""The `async def` functions of a robot: their event loop, and how one of them waits.

Rule: asyncio is imported by this file alone, which is loaded with the first such function: most robots have none.
"""

from __future__ import annotations

import asyncio
import inspect
import threading
from collections.abc import Callable, Coroutine
from contextlib import suppress
from typing import Any

from rai_missions.connectors.connector import OnReport
from rai_missions.connectors.python_robot.action import GoalRun
from rai_missions.connectors.python_robot.robot_time import Execution, RobotTime, RunOver

__all__ = ("AsyncActionRun", "EventLoop", "TaskExecution")

CLOSING_S = 2.0
"""So long tasks that are left may take to end by their cancel."""


class EventLoop:
    """The event loop that a robot's functions share, on a thread that begins with the first of them.

    Args:
        name: The name of the robot.
    """

    def __init__(self, name: str) -> None:
        self._name, self._lock = name, threading.Lock()
        self._loop: asyncio.AbstractEventLoop | None = None

    def get(self) -> asyncio.AbstractEventLoop:
        """The loop, which turns."""
        with self._lock:
            if self._loop is None:
                self._loop = asyncio.new_event_loop()
                threading.Thread(target=_turn, args=(self._loop,), name=f"{self._name}/async", daemon=True).start()
            return self._loop

    def run(self, goal_id: str, name: str, robot_time: RobotTime, on_report: OnReport) -> AsyncActionRun:
        """The run of a goal that a function is about to pursue on it."""
        return AsyncActionRun(goal_id, TaskExecution(name, robot_time, self.get()), robot_time, on_report)

    def begin(self, task: Coroutine[Any, Any, Any]) -> None:
        """Have a function executed; from any thread."""
        asyncio.run_coroutine_threadsafe(task, self.get())

    def result(self, task: Coroutine[Any, Any, Any]) -> Any:
        """What a function returns; waits for it on the thread that calls."""
        return asyncio.run_coroutine_threadsafe(task, self.get()).result()

    async def apart(self, work: Callable[[], None]) -> None:
        """Do what waits on another thread, while the loop turns."""
        await asyncio.to_thread(work)

    def close(self) -> None:
        """Cancel what is left, and end."""
        with self._lock:
            loop, self._loop = self._loop, None
        if loop is not None:
            asyncio.run_coroutine_threadsafe(_cancel_all(loop), loop)


class TaskExecution(Execution):
    """An `async def` that was called and has not returned.

    Args:
        name: The name of the fact, service or action.
        robot_time: Of its run.
        loop: Where it executes.
    """

    def __init__(self, name: str, robot_time: RobotTime, loop: asyncio.AbstractEventLoop) -> None:
        super().__init__(name, robot_time)
        self._loop, self._released = loop, asyncio.Event()

    async def sleep_async(self, seconds: float) -> None:
        """As `sleep`; on its event loop."""
        if self._time.wait(self, seconds):
            with suppress(TimeoutError):
                await asyncio.wait_for(self._released.wait(), None if self._time.is_steered else seconds)
            self._released.clear()
        else:
            await asyncio.sleep(0)  # others have their turn
        self._time.awake(self)
        if self.is_over:
            raise RunOver

    def release(self) -> None:
        if not self._loop.is_closed():
            self._loop.call_soon_threadsafe(self._released.set)


class AsyncActionRun(GoalRun[TaskExecution]):
    """The run of a goal that an `async def` pursues on the robot's event loop."""

    _waits: tuple[Coroutine[Any, Any, None], ...] = ()
    """The waits that have yet to begin."""

    def sleep(self, seconds: float) -> Coroutine[Any, Any, None]:
        """Await this: a wait for seconds of the run's clock; less where the mission cancels the goal meanwhile."""
        wait = self.execution.sleep_async(seconds)
        self._waits = (*self._unbegun(), wait)
        return wait

    def finish(self, returned: Any) -> None:
        """As of any run; but what did not await its waits has failed, for it was quicker than it should be."""
        forgotten = self._unbegun()
        for wait in forgotten:
            wait.close()
        if forgotten:
            self.fail(RuntimeError("run.sleep was called without await; write `await run.sleep(…)`"))
        else:
            super().finish(returned)

    def _unbegun(self) -> tuple[Coroutine[Any, Any, None], ...]:
        return tuple(wait for wait in self._waits if inspect.getcoroutinestate(wait) == inspect.CORO_CREATED)


def _turn(loop: asyncio.AbstractEventLoop) -> None:
    asyncio.set_event_loop(loop)
    try:
        loop.run_forever()
    finally:
        loop.close()


async def _cancel_all(loop: asyncio.AbstractEventLoop) -> None:
    left = asyncio.all_tasks(loop) - {asyncio.current_task(loop)}
    for task in left:
        task.cancel()
    if left:
        await asyncio.wait(left, timeout=CLOSING_S)
    loop.stop()
