# SPDX-License-Identifier: Apache-2.0
"""A robot in another process, in plain rclpy: it does what each goal's `order` and each request ask.

Rule: nothing of ours is used on its side; it reports on its output what it received.
"""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import threading
import time
from collections import Counter
from pathlib import Path
from typing import Any

from rai_missions.connectors.contract import Inbox

ROOT = Path(__file__).parents[3]
SUCCEED, RUN, REJECT, STUBBORN, ABORT, SLOW_TO_ACCEPT = range(6)
"""What a goal's `order` asks for; `RUN` until canceled, `STUBBORN` until it has refused to be canceled twice."""
STARTS_WITHIN_S = 120.0
"""A process that loads ROS takes two seconds, and far longer where many others want the same cores."""
LASTS = 100
"""From here on, an order is the hundredths of a second that a goal lasts."""
DROPPED = "feed"
"""Of goals whose id begins so every second reply is dropped, beginning with the first, as a middleware does."""
FIBONACCI, TRIGGER = "test_msgs/action/Fibonacci", "std_srvs/srv/Trigger"


class Peer:
    """The process, from outside.

    Args:
        name: Its node's name, and what its topics, services and action are named below.
        program: What it runs.
    """

    def __init__(self, name: str, program: Path = Path(__file__)) -> None:
        self.name = name
        self.lines: Inbox[Any] = Inbox(30.0)
        self._ready: Inbox[Any] = Inbox(STARTS_WITHIN_S)
        environment = {**os.environ, "PYTHONPATH": str(ROOT)}
        self._process = subprocess.Popen(
            [sys.executable, "-X", "faulthandler", "-W", "ignore", str(program), name],
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
            text=True,
            cwd=ROOT,
            env=environment,
        )
        self._reader = threading.Thread(target=self._read)
        self._reader.start()

    def _read(self) -> None:
        assert self._process.stdout is not None
        for line in self._process.stdout:
            if not line.startswith("["):
                continue  # Fast DDS prints its errors there too
            self.lines(reported := json.loads(line))
            if reported == ["ready"]:
                self._ready(reported)

    def signal(self, number: signal.Signals) -> None:
        """Send a signal; after one to stop, each of its threads has stopped."""
        self._process.send_signal(number)
        if number == signal.SIGSTOP:
            os.waitid(os.P_PID, self._process.pid, os.WSTOPPED)

    def still_runs(self) -> Peer:
        """This peer; an `AssertionError` where its process has ended, which no test has asked for."""
        code = self._process.poll()
        assert code is None, f"the peer '{self.name}' has ended with exit code {code}; it reported {self.lines.all}"
        return self

    def kill(self) -> None:
        self._process.kill()
        self._process.wait()

    def __enter__(self) -> Peer:
        try:
            self._ready.wait(bool, "the peer has started")
        except AssertionError:
            self.kill()
            self.__exit__()
            raise
        return self

    def __exit__(self, *_: object) -> None:
        assert self._process.stdin is not None and self._process.stdout is not None
        self._process.stdin.close()
        try:
            self._process.wait(30)
        except subprocess.TimeoutExpired:
            self._process.kill()
            self._process.wait()
        self._reader.join()
        self._process.stdout.close()


def spin_until_closed(node: Any, threads: int) -> None:
    """Report `ready`, and serve until the standard input is closed."""
    from rclpy.executors import MultiThreadedExecutor

    executor = MultiThreadedExecutor(threads)
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    report_line("ready")
    sys.stdin.read()
    os._exit(0)  # a robot that is switched off


def report_line(*what: Any) -> None:
    with TALKING:
        sys.stdout.write(json.dumps(what) + "\n")
        sys.stdout.flush()


TALKING = threading.Lock()


class DroppingHandle:
    """A server's handle that drops every second reply about some goals, beginning with the first of each kind."""

    def __init__(self, handle: Any) -> None:
        self._rclpy, self._goal_ids, self._replies = handle, dict[int, str](), Counter[tuple[str, str]]()

    def expect(self, header: Any, goal_id: str) -> None:
        """A request has come, whose reply will carry this header."""
        self._goal_ids[id(header)] = goal_id

    def __enter__(self) -> Any:
        return self._rclpy.__enter__()

    def __exit__(self, *fault: object) -> Any:
        return self._rclpy.__exit__(*fault)

    def __getattr__(self, name: str) -> Any:
        found = getattr(self._rclpy, name)
        if name not in ("send_goal_response", "send_result_response"):
            return found

        def reply(header: Any, response: Any) -> None:
            goal_id = self._goal_ids.pop(id(header), "")
            self._replies[name, goal_id] += 1
            if goal_id.startswith(DROPPED) and self._replies[name, goal_id] % 2:
                report_line("dropped", goal_id)
            else:
                found(header, response)

        return reply


def serve(name: str) -> None:  # noqa: C901 - one robot, with all that it may be asked
    import rclpy
    from rclpy.action import ActionServer, CancelResponse, GoalResponse
    from rclpy.callback_groups import ReentrantCallbackGroup
    from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
    from std_msgs.msg import String
    from std_srvs.srv import SetBool, Trigger
    from test_msgs.action import Fibonacci

    rclpy.init()
    node = rclpy.create_node(name)
    group, refused = ReentrantCallbackGroup(), Counter[str]()

    def decide(goal: Any) -> Any:
        report_line("asked", goal.order)
        if goal.order == SLOW_TO_ACCEPT:
            time.sleep(1.5)  # so that a busy machine's test still finds it thinking
        return GoalResponse.REJECT if goal.order == REJECT else GoalResponse.ACCEPT

    def cancel(handle: Any) -> Any:
        goal_id = bytes(handle.goal_id.uuid).hex()
        refused[goal_id] += handle.request.order == STUBBORN
        report_line("cancel", goal_id)
        return CancelResponse.REJECT if handle.request.order == STUBBORN else CancelResponse.ACCEPT

    def execute(handle: Any) -> Any:
        goal_id, order, result = bytes(handle.goal_id.uuid).hex(), handle.request.order, Fibonacci.Result()
        report_line("runs", goal_id)
        handle.publish_feedback(Fibonacci.Feedback(sequence=[0]))
        done_at = time.monotonic() + (order / 100 if order >= LASTS else 0)
        while time.monotonic() < done_at and not handle.is_cancel_requested:
            time.sleep(0.01)
        until = time.monotonic() + 120
        while order in (RUN, STUBBORN, SLOW_TO_ACCEPT) and refused[goal_id] < 2 and time.monotonic() < until:
            if handle.is_cancel_requested or not rclpy.ok():
                handle.canceled()
                report_line("canceled", goal_id)
                return result
            time.sleep(0.01)
        if handle.is_cancel_requested:
            handle.canceled()
        elif order == ABORT:
            handle.abort()
        else:
            handle.succeed()
        result.sequence = [0, 1, 1, 2]
        report_line("ended", goal_id)
        return result

    def hang(_request: Any, response: Any) -> Any:
        report_line("hangs")
        time.sleep(60)
        return response

    def trigger(_request: Any, response: Any) -> Any:
        response.success, response.message = True, "done"
        return response

    def set_bool(request: Any, response: Any) -> Any:
        response.success, response.message = request.data, "failed: it is broken" if not request.data else ""
        return response

    class ReportingHandle(ActionServer):
        """Reports of which goals the end is asked for, also of those that it knows nothing of; may drop replies."""

        def __init__(self, *arguments: Any, **options: Any) -> None:
            super().__init__(*arguments, **options)
            self._handle = DroppingHandle(self._handle)

        async def _execute_goal_request(self, request: Any) -> None:
            self._handle.expect(request[0], bytes(request[1].goal_id.uuid).hex())
            await super()._execute_goal_request(request)

        async def _execute_get_result_request(self, request: Any) -> None:
            self._handle.expect(request[0], bytes(request[1].goal_id.uuid).hex())
            await super()._execute_get_result_request(request)

        async def _execute_cancel_request(self, request: Any) -> None:
            report_line("end wanted", bytes(request[1].goal_info.goal_id.uuid).hex())
            await super()._execute_cancel_request(request)

    ReportingHandle(
        node,
        Fibonacci,
        f"/{name}/fibonacci",
        execute,
        goal_callback=decide,
        cancel_callback=cancel,
        callback_group=group,
    )
    node.create_service(Trigger, f"/{name}/trigger", trigger, callback_group=group)
    node.create_service(Trigger, f"/{name}/hang", hang, callback_group=group)
    node.create_service(SetBool, f"/{name}/set", set_bool, callback_group=group)
    latched = QoSProfile(depth=1, durability=DurabilityPolicy.TRANSIENT_LOCAL)
    node.create_publisher(String, f"/{name}/latched", latched).publish(String(data="kept"))
    hasty = node.create_publisher(
        String, f"/{name}/hasty", QoSProfile(depth=5, reliability=ReliabilityPolicy.BEST_EFFORT)
    )
    node.create_timer(0.05, lambda: hasty.publish(String(data="hasty")))
    node.create_subscription(String, f"/{name}/ear", lambda received: report_line("heard", received.data), 10)
    spin_until_closed(node, threads=8)


if __name__ == "__main__":
    serve(sys.argv[1])
