# SPDX-License-Identifier: Apache-2.0
"""Actions that are served: rclpy's server, whose answers may come later than its callbacks return.

Rule: nothing is awaited. rclpy keeps one core busy for as long as a coroutine waits.
"""

from __future__ import annotations

from collections.abc import Callable, Coroutine
from dataclasses import dataclass
from typing import Any

from rclpy.action import ActionServer as RclpyServer
from rclpy.action import CancelResponse, GoalResponse

from rai_missions.connectors.connector import ENDS, ActionServer, Report
from rai_missions.connectors.ros2.messages import goal_id_from_bytes, to_data, to_message
from rai_missions.connectors.ros2.node_thread import Runtime, guarded
from rai_missions.connectors.ros2.services import MANY
from rai_missions.errors import ConnectorError, raised_text
from rai_missions.redaction import logger

__all__ = ("ServedAction",)

log = logger(__name__)

KEPT_S = 10
"""How long a result is kept for anyone who asks late; every status message lists the goals that are kept."""


@dataclass(eq=False)
class _Goal:
    goal_id: str
    request: Any
    """The request as rclpy took it, until it is answered."""
    handle: Any = None
    is_over: bool = False
    is_refused: bool = False
    """The server has just refused to cancel it."""


class ServedAction:
    """One action that is served. Made and destroyed on the runtime's thread; closed from any."""

    def __init__(self, runtime: Runtime, action: str, cls: Any, server: ActionServer) -> None:
        self._runtime, self._action, self._class, self._server = runtime, action, cls, server
        self._is_open = True
        self._entity: _Entity | None = None
        self._goals: dict[str, _Goal] = {}
        runtime.post(self._open)

    def close(self) -> None:
        """Abort the goals, then stop serving the action."""
        self._is_open = False
        self._runtime.post(self._abandon)

    @property
    def is_done(self) -> bool:
        """Every goal has ended, and who sent it can know."""
        return not self._goals

    def _open(self) -> None:
        if self._is_open:
            self._entity = _Entity(self, self._runtime, self._action, self._class)
            self._runtime.keep(self, self._entity.destroy)

    def _abandon(self) -> None:
        for goal in list(self._goals.values()):
            self._report(goal, Report(goal.goal_id, "rejected" if goal.handle is None else "failed", {}))
        self._runtime.when(lambda: self.is_done, 1.0, lambda _done: self._runtime.dispose(self))

    # -- what rclpy reports -------------------------------------------------------------------------------------------

    def arrived(self, request: Any) -> None:
        """A goal has come; `request` is its header and message.

        A run that continues sends a goal again of which no server knew, since it was not accepted yet: then that
        request is the one that is answered.
        """
        goal = _Goal(goal_id_from_bytes(bytes(request[1].goal_id.uuid)), request)
        known = self._goals.get(goal.goal_id)
        if self._is_open and known is not None and known.handle is None:
            known.request = request
            return
        if not self._is_open or known is not None:
            self._answer(goal, GoalResponse.REJECT)
            return
        self._goals[goal.goal_id] = goal
        try:
            self._server.accept(goal.goal_id, to_data(request[1].goal), lambda report: self._on_report(goal, report))
        except Exception as fault:
            log.exception("%s could not take goal %s", self._action, goal.goal_id)
            self._on_report(goal, Report(goal.goal_id, "rejected", {}, raised_text(fault)))

    def accepted(self, handle: Any) -> None:
        """rclpy has answered the client: its goal is accepted."""
        goal = self._goals[goal_id_from_bytes(bytes(handle.goal_id.uuid))]
        goal.handle = handle
        handle.execute()

    def cancel_wanted(self, handle: Any) -> CancelResponse:
        """A client wants a goal to end."""
        goal = self._goals.get(goal_id_from_bytes(bytes(handle.goal_id.uuid)))
        if goal is None or goal.is_over:
            return CancelResponse.REJECT
        goal.is_refused = False
        try:
            self._server.cancel(goal.goal_id)
        except Exception:
            log.exception("%s could not cancel goal %s", self._action, goal.goal_id)
            goal.is_refused = True
        return CancelResponse.REJECT if goal.is_refused else CancelResponse.ACCEPT

    # -- what the server reports --------------------------------------------------------------------------------------

    def _on_report(self, goal: _Goal, report: Report) -> None:
        if report.status == "cancel_rejected":
            goal.is_refused = True  # counts while the server is being asked; ROS cannot report it later
        elif report.goal_id == goal.goal_id:
            self._runtime.post(lambda: self._report(goal, report))

    def _report(self, goal: _Goal, report: Report) -> None:
        if goal.is_over:
            return
        if goal.handle is None and report.status == "rejected":
            goal.is_over = True
            log.info("%s rejects goal %s: %s", self._action, goal.goal_id, report.why)
            self._answer(goal, GoalResponse.REJECT)
            self._forget(goal)
            return
        if goal.handle is None:
            self._answer(goal, GoalResponse.ACCEPT)
        if goal.handle is not None and report.status == "feedback":
            goal.handle.publish_feedback(to_message(self._class.Feedback, report.data, self._action))
        elif report.status in ENDS:
            goal.is_over = True
            self._finish(goal, report)

    def _answer(self, goal: _Goal, decision: GoalResponse) -> None:
        assert self._entity is not None
        self._entity.decide(goal.request, decision)

    def _finish(self, goal: _Goal, report: Report) -> None:
        if goal.handle is None or self._entity is None:  # its client went away before
            self._forget(goal)
            return

        def conclude(handle: Any) -> Any:
            try:
                result = to_message(self._class.Result, report.data, self._action)
            except ConnectorError:
                log.exception("%s: the result of goal %s is left empty", self._action, goal.goal_id)
                result = self._class.Result()
            self._close_off(handle, report)
            self._runtime.post(lambda: self._forget(goal))  # by then the result is on its way
            return result

        self._entity.conclude(goal.handle, conclude)

    def _close_off(self, handle: Any, report: Report) -> None:
        if report.status == "succeeded":
            handle.succeed()
        elif report.status == "canceled" and handle.is_cancel_requested:
            handle.canceled()
        else:
            if report.status == "canceled":
                log.warning("%s ended a goal as canceled that no one canceled; ROS reports aborted", self._action)
            handle.abort()

    def _forget(self, goal: _Goal) -> None:
        if self._goals.get(goal.goal_id) is goal:
            del self._goals[goal.goal_id]


class _Entity(RclpyServer):  # type: ignore[misc]
    """rclpy's action server, whose goals are answered when the answer is known and concluded when they end."""

    def __init__(self, served: ServedAction, runtime: Runtime, action: str, cls: Any) -> None:
        self._served = served
        self._decision = GoalResponse.REJECT
        super().__init__(
            runtime.node,
            cls,
            action,
            _never,
            callback_group=runtime.group,
            result_timeout=KEPT_S,
            goal_callback=lambda _goal: self._decision,
            handle_accepted_callback=served.accepted,
            cancel_callback=served.cancel_wanted,
            goal_service_qos_profile=MANY,
            result_service_qos_profile=MANY,
            cancel_service_qos_profile=MANY,
        )

    async def execute(self, taken_data: dict[str, Any]) -> None:
        request = taken_data.pop("goal", None)
        if request is not None:
            guarded(lambda: self._served.arrived(request))
        await super().execute(taken_data)

    def decide(self, request: Any, decision: GoalResponse) -> None:
        """Have rclpy answer a goal's request."""
        self._decision = decision
        _run(super().execute({"goal": request}))

    def conclude(self, handle: Any, conclude: Callable[[Any], Any]) -> None:
        """Have rclpy send a goal's result."""
        super().notify_execute(handle, conclude)

    def notify_execute(self, goal_handle: Any, execute_callback: Any) -> None:
        """A goal begins to be executed: its server does that, on threads of its own."""


def _never(_handle: Any) -> None:
    raise AssertionError("goals are concluded by their server's reports")


def _run(coroutine: Coroutine[Any, Any, None]) -> None:
    """Run a coroutine that has nothing to wait for."""
    try:
        coroutine.send(None)
    except StopIteration:
        return
    coroutine.close()
    raise AssertionError("an action's callback waited")
