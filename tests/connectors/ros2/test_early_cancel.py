# SPDX-License-Identifier: Apache-2.0
"""A server has taken a goal, its word of that is lost for the while, and the goal is not wanted any more."""

from __future__ import annotations

import threading
import uuid
from collections.abc import Callable, Iterator
from typing import Any

import pytest

from rai_missions.connectors.connector import Report
from rai_missions.connectors.contract import Inbox
from tests.connectors.ros2.peer_process import FIBONACCI

PATIENCE_S = 30


class Unheard:
    """An action's server whose acceptance is not received before a cancel; by hand, from the services of an action."""

    def __init__(self) -> None:
        import rclpy
        from action_msgs.msg import GoalStatus
        from action_msgs.srv import CancelGoal
        from rclpy.callback_groups import ReentrantCallbackGroup
        from rclpy.context import Context
        from rclpy.executors import MultiThreadedExecutor
        from rclpy.qos import DurabilityPolicy, QoSProfile
        from test_msgs.action import Fibonacci

        self.taken, self.cancels = Inbox[str](PATIENCE_S), Inbox[str](PATIENCE_S)
        self.name, self.canceled = f"/unheard_{uuid.uuid4().hex[:6]}", threading.Event()
        self._context = Context()
        rclpy.init(context=self._context)
        self._node = rclpy.create_node("unheard", context=self._context)
        group, below = ReentrantCallbackGroup(), f"{self.name}/_action"
        node, offered = self._node, Fibonacci.Impl
        node.create_service(offered.SendGoalService, f"{below}/send_goal", self._accept, callback_group=group)
        node.create_service(CancelGoal, f"{below}/cancel_goal", self._cancel, callback_group=group)
        node.create_service(offered.GetResultService, f"{below}/get_result", self._result, callback_group=group)
        latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
        self._publishers = [
            node.create_publisher(offered.FeedbackMessage, f"{below}/feedback", 10),
            node.create_publisher(offered.GoalStatusMessage, f"{below}/status", latched),
        ]
        self._ended = GoalStatus.STATUS_CANCELED
        self._executor = MultiThreadedExecutor(4, context=self._context)
        self._executor.add_node(node)
        self._thread = threading.Thread(target=self._executor.spin)
        self._thread.start()

    def _accept(self, request: Any, response: Any) -> Any:
        self.taken("goal")
        response.accepted = self.canceled.wait(PATIENCE_S)
        return response

    def _cancel(self, request: Any, response: Any) -> Any:
        self.cancels("again" if self.canceled.is_set() else "first")
        if self.canceled.is_set():
            response.return_code = response.ERROR_GOAL_TERMINATED
        else:
            response.goals_canceling = [request.goal_info]
        self.canceled.set()
        return response

    def _result(self, request: Any, response: Any) -> Any:
        response.status = self._ended
        return response

    def close(self) -> None:
        self.canceled.set()
        self._executor.shutdown()
        self._thread.join()
        self._node.destroy_node()
        self._context.try_shutdown()


@pytest.fixture
def unheard(ros: None) -> Iterator[Unheard]:
    server = Unheard()
    yield server
    server.close()


def test_a_stop_does_not_wait_for_the_word_that_its_goal_was_accepted(
    open_ros: Callable[..., Any], unheard: Unheard
) -> None:
    connector, reports = open_ros(), Inbox[Report](PATIENCE_S)
    goal_id = uuid.uuid4().hex
    connector.send_goal(unheard.name, FIBONACCI, {"order": 3}, goal_id=goal_id, on_report=reports)
    unheard.taken.wait(bool, "the server has the goal")
    connector.cancel_goal(goal_id)
    connector.cancel_goal(goal_id)
    reported = reports.wait(lambda all_: all_[-1].status == "canceled", "the goal has ended")
    assert [each.status for each in reported] == ["accepted", "canceled"]
    # The server answers the request for the result, which was sent before the second cancel, maybe before it too.
    unheard.cancels.wait(lambda all_: len(all_) > 1, "once before its acceptance was received, and once after")
    assert unheard.cancels.all == ["first", "again"]
