# SPDX-License-Identifier: Apache-2.0
"""A goal that an earlier process sent, resumed by its id.

Rule: its server alone reports what has become of it. What the server does not list and has no result of is lost.
"""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalStatus, GoalStatusArray
from rclpy.action.client import ClientGoalHandle
from rclpy.qos import qos_profile_action_status_default

from rai_missions.connectors.connector import Report
from rai_missions.connectors.ros2.action_client import ClientGoal, End
from rai_missions.connectors.ros2.node_thread import Work

__all__ = ("RecoveredGoal",)

RUNNING = frozenset({GoalStatus.STATUS_ACCEPTED, GoalStatus.STATUS_EXECUTING, GoalStatus.STATUS_CANCELING})


class RecoveredGoal(ClientGoal):
    """One goal of another process. On its runtime's thread only; arguments as `ClientGoal` has them."""

    _ears: tuple[Work, ...] = ()
    _is_known = False

    def find(self) -> None:
        """Ask for it as soon as its server is found."""
        client = self._client
        ready = client.client.server_is_ready
        client.runtime.when(lambda: self.is_over or ready(), client.patience_s, self._ask_after)

    def _ask_after(self, is_there: bool) -> None:
        client = self._client
        if self.is_over:
            return
        if not is_there:
            self.end("lost", why=f"no server offers {client.action}")
            return
        self.peers, self._is_sent = client.peers(), True
        self._handle = ClientGoalHandle(client.client, self._uuid, None)
        self._ears = (
            client.observe("feedback", client.cls.Impl.FeedbackMessage, 10, self._on_feedback),
            client.observe("status", GoalStatusArray, qos_profile_action_status_default, self._on_status),
        )
        self._ask_for_result()
        client.watch(self)
        if self._is_unwanted:
            self._ask_to_cancel(self._handle)

    def _on_feedback(self, message: Any) -> None:
        if bytes(message.goal_id.uuid) == bytes(self._uuid.uuid):
            self._advance(message)

    def _on_status(self, message: Any) -> None:
        mine = [each.status for each in message.status_list if each.goal_info.goal_id == self._uuid]
        if mine and mine[0] in RUNNING and not self._is_known and not self.is_over:
            self._is_known = True
            self._deliver(Report(self.goal_id, "accepted", {}))

    def _finished(self, future: Any) -> None:
        was_over = self.is_over
        super()._finished(future)
        if self.is_over and not was_over:
            self._client.caught(self)  # its server has reported what became of it: there is nothing to chase

    def end(self, how: End, data: dict[str, Any] | None = None, why: str = "") -> None:
        for close in self._ears:
            close()
        self._ears = ()
        super().end(how, data, why)
