# SPDX-License-Identifier: Apache-2.0
"""A goal that an earlier process sent, resumed by its id.

Rule: its server alone reports what has become of it. What the server does not list and has no result of is lost.
"""

from __future__ import annotations

from typing import Any

from action_msgs.msg import GoalStatusArray
from rclpy.qos import qos_profile_action_status_default

from rai_missions.connectors.connector import Report
from rai_missions.connectors.ros2.remote_goal import End, RemoteGoal
from rai_missions.connectors.ros2.rivals import statuses_in
from rai_missions.connectors.worker import Work

__all__ = ("RecoveredGoal",)


class RecoveredGoal(RemoteGoal):
    """One goal of another process. On its runtime's thread only; arguments as `RemoteGoal` has them."""

    _ears: tuple[Work, ...] = ()
    _is_known = False

    def find(self) -> None:
        """Ask for it as soon as its server is found."""
        client = self._client
        ready = client.client.server_is_ready
        client.runtime.when(lambda: self.is_over or ready(), client.patience_s, self._ask_after)

    def cancel(self) -> None:
        """Ask for its end; its server may be executing it, so until that is found the wish is kept."""
        if self._is_sent:
            super().cancel()
        else:
            self._is_unwanted = True

    def _ask_after(self, is_there: bool) -> None:
        client = self._client
        if self.is_over:
            return
        self.peers, self._is_sent = client.peers(), True
        self._handle = self._unanswered()
        client.watch(self)
        if not is_there:
            self.end("lost", why=client.why_absent())
            return
        self._ears = (
            client.observe("feedback", client.cls.Impl.FeedbackMessage, 10, self._on_feedback),
            client.observe("status", GoalStatusArray, qos_profile_action_status_default, self._on_status),
        )
        self._ask_for_result()
        if self._is_unwanted:
            self._ask_to_cancel(self._handle)

    def _on_feedback(self, message: Any) -> None:
        if bytes(message.goal_id.uuid) == self.uuid:
            self._advance(message)

    def _on_status(self, message: Any) -> None:
        for goal_id, stamp, status in statuses_in(message):
            if goal_id == self.uuid:
                self.sight(stamp, status)

    def sight(self, stamp: int, status: int) -> None:
        super().sight(stamp, status)
        if self.sightings.is_active and not self._is_known and not self.is_over:
            self._is_known = True
            self._deliver(Report(self.goal_id, "accepted", {}))

    def look(self) -> None:
        """Ask again until a server has answered, or is seen to execute the goal."""
        if self._held is None and not self.sightings.is_active:
            self._ask_for_result()

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
