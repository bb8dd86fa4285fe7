# SPDX-License-Identifier: Apache-2.0
"""A robot in another process, in plain rclpy, that lives on while the runs which drive it are killed.

Rule: nothing of ours is used on its side; it reports on its output what it did, before anybody else can know of it.
"""

from __future__ import annotations

import sys
import time
from typing import Any

from tests.connectors.ros2.peer_process import report_line, spin_until_closed

THINKS_S = 0.06
"""How long a goal is looked at before it is accepted."""
ANSWERS_S = 0.04
"""How long a service takes, once it has done what it does."""
PERIOD_S = 0.1


def serve(name: str) -> None:
    import rclpy
    from rclpy.action import ActionServer, CancelResponse, GoalResponse
    from rclpy.callback_groups import ReentrantCallbackGroup
    from std_msgs.msg import Bool, Int32
    from std_srvs.srv import Trigger
    from test_msgs.action import Fibonacci

    rclpy.init()
    node, group = rclpy.create_node(name), ReentrantCallbackGroup()
    done = 0

    def decide(goal: Any) -> Any:
        report_line("asked", goal.order)
        time.sleep(THINKS_S)
        return GoalResponse.ACCEPT

    def execute(handle: Any) -> Any:
        nonlocal done
        goal_id, order = bytes(handle.goal_id.uuid).hex(), handle.request.order
        report_line("runs", goal_id)
        until = time.monotonic() + order / 100
        while time.monotonic() < until and not handle.is_cancel_requested:
            time.sleep(0.01)
        if handle.is_cancel_requested:
            report_line("canceled", goal_id)
            handle.canceled()
        else:
            done += 1
            report_line("ended", goal_id)
            handle.succeed()
        return Fibonacci.Result(sequence=[done])

    def answering(service: str) -> Any:
        def answer(_request: Any, response: Any) -> Any:
            report_line(service)
            time.sleep(ANSWERS_S)
            response.success = True
            return response

        return answer

    ActionServer(
        node,
        Fibonacci,
        f"/{name}/move",
        execute,
        goal_callback=decide,
        cancel_callback=lambda handle: CancelResponse.ACCEPT,
        callback_group=group,
    )
    for service in ("horn", "lamp"):
        node.create_service(Trigger, f"/{name}/{service}", answering(service), callback_group=group)
    node.create_subscription(Bool, f"/{name}/light", lambda received: report_line("light"), 10, callback_group=group)
    reported = node.create_publisher(Int32, f"/{name}/done", 10)
    node.create_timer(PERIOD_S, lambda: reported.publish(Int32(data=done)), callback_group=group)
    spin_until_closed(node, threads=6)


if __name__ == "__main__":
    serve(sys.argv[1])
