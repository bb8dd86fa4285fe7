# SPDX-License-Identifier: Apache-2.0
"""An action's server in another process, in plain rclpy, whose behaviour is in each goal's `order`.

Rule: it writes down what it does before its client can know of it, so that the order of its log is the order of facts.
"""

from __future__ import annotations

import sys
import threading
import time
from pathlib import Path
from typing import Any, NamedTuple

from tests.connectors.ros2.peer_process import report_line

__all__ = ("PROGRAM", "Script")

PROGRAM = Path(__file__)
ACCEPTS = ("at once", "late", "never")
CANCELS = ("taken", "late", "refused")
ENDS = ("succeeds", "aborts", "succeeds later", "runs on")
LATE_S, LATER_S, STUBBORN_S = 0.08, 0.04, 0.6


class Script(NamedTuple):
    """What the server does with one goal. A goal whose cancel is refused ends by itself after 0.6 s."""

    accept: str = "at once"
    cancel: str = "taken"
    end: str = "runs on"
    is_repeated: bool = False
    """Each of its answers is sent twice."""

    def order(self, token: int) -> int:
        """The script and a number that no other goal has, as an `order`."""
        word = ((ACCEPTS.index(self.accept) * 3 + CANCELS.index(self.cancel)) * 4 + ENDS.index(self.end)) * 2
        return token * 100 + word + self.is_repeated

    @classmethod
    def read(cls, order: int) -> tuple[int, Script]:
        token, rest = divmod(order, 100)
        rest, is_repeated = divmod(rest, 2)
        rest, end = divmod(rest, 4)
        accept, cancel = divmod(rest, 3)
        return token, cls(ACCEPTS[accept], CANCELS[cancel], ENDS[end], bool(is_repeated))


class StammeringHandle:
    """A server's handle that sends the answers of some goals twice."""

    def __init__(self, handle: Any) -> None:
        self._handle, self.is_stammering = handle, False

    def __enter__(self) -> Any:
        return self._handle.__enter__()

    def __exit__(self, *fault: object) -> Any:
        return self._handle.__exit__(*fault)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._handle, name)
        if name not in ("send_goal_response", "send_result_response") or not self.is_stammering:
            return found

        def twice(*arguments: Any) -> None:
            found(*arguments)
            found(*arguments)

        return twice


def serve(name: str) -> None:
    import os

    import rclpy
    from rclpy.action import ActionServer, CancelResponse, GoalResponse
    from rclpy.callback_groups import ReentrantCallbackGroup
    from rclpy.executors import MultiThreadedExecutor
    from test_msgs.action import Fibonacci

    rclpy.init()
    node = rclpy.create_node(name)

    def decide(goal: Any) -> Any:
        token, script = Script.read(goal.order)
        report_line("asked", token)
        server._handle.is_stammering = script.is_repeated
        if script.accept == "late":
            time.sleep(LATE_S)
        if script.accept == "never":
            report_line("over", token, "rejected")
        return GoalResponse.REJECT if script.accept == "never" else GoalResponse.ACCEPT

    def cancel(handle: Any) -> Any:
        token, script = Script.read(handle.request.order)
        report_line("cancel", token)
        if script.cancel == "late":
            time.sleep(LATE_S)
        return CancelResponse.REJECT if script.cancel == "refused" else CancelResponse.ACCEPT

    def execute(handle: Any) -> Any:
        token, script = Script.read(handle.request.order)
        report_line("runs", token)
        handle.publish_feedback(Fibonacci.Feedback(sequence=[token]))
        lasts_s = {"succeeds later": LATER_S, "runs on": STUBBORN_S if script.cancel == "refused" else 120.0}
        until = time.monotonic() + lasts_s.get(script.end, 0.0)
        while time.monotonic() < until and not handle.is_cancel_requested:
            time.sleep(0.005)
        end = "canceled" if handle.is_cancel_requested else "aborted" if script.end == "aborts" else "succeeded"
        report_line("over", token, end)
        {"canceled": handle.canceled, "aborted": handle.abort, "succeeded": handle.succeed}[end]()
        return Fibonacci.Result(sequence=[token])

    server = ActionServer(
        node,
        Fibonacci,
        f"/{name}/move",
        execute,
        goal_callback=decide,
        cancel_callback=cancel,
        callback_group=ReentrantCallbackGroup(),
    )
    server._handle = StammeringHandle(server._handle)
    executor = MultiThreadedExecutor(8)
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    report_line("ready")
    sys.stdin.read()
    os._exit(0)


if __name__ == "__main__":
    serve(sys.argv[1])
