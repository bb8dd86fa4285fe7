# SPDX-License-Identifier: Apache-2.0
"""An e-stop over ROS 2, for `bench_stop.py`: this process is the robot, others are the mission and the gate.

Who stops speaks from the robot's process. So does the camera, which fills the shared memory that Fast DDS gives a
process (`together`); the same with our profile for a process that publishes pictures (`roomy`); or the camera is a
process of its own, as drivers mostly are (`apart`). Anyone who is not ours has Fast DDS as it comes.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

from benchmarks.bench_stop import EMPTY, PERIOD_S, PICTURE, ROUNDS, loaded, print_times

KINDS = {"plain": "plain rclpy", "mission": "a mission", "gate": "the gate"}
LAYOUTS = {"together": "", "roomy": ", our profile", "apart": ", camera apart"}
VARIABLES = ("FASTRTPS_DEFAULT_PROFILES_FILE", "FASTDDS_DEFAULT_PROFILES_FILE")
COMMANDS_S, PATIENCE_S = 0.01, 60


def other(*words: str) -> subprocess.Popen[bytes]:
    """Another process; it has no profile of Fast DDS but its own."""
    environment = {name: value for name, value in os.environ.items() if name not in VARIABLES}
    return subprocess.Popen(
        [sys.executable, "-W", "ignore", "-m", *words], cwd=Path(__file__).parents[1], env=environment
    )


# -- the mission, the gate, a few lines of rclpy -----------------------------------------------------------------------


def mission_process() -> None:
    """One mission after the other, until stopped for good; each stops when `/stop` states it."""
    from rai_missions.connectors.ros2 import open_connector

    folder = Path(tempfile.mkdtemp())
    connector = open_connector({})
    connector.start()
    runners: list[Any] = []
    connector.subscribe("/stop", EMPTY, lambda _message: runners[-1].kill("the button"))
    for number in range(ROUNDS):
        ended = threading.Event()
        runner, journal = loaded(connector, "ros2", folder, number, ended)
        runners.append(runner)
        runner.run()
        ended.set()
        journal.close()
    os._exit(0)


def plain_process() -> None:
    """The floor: what a program of a few lines does with rclpy under the same pictures, and without anything else."""
    import rclpy
    from rclpy.action import ActionClient
    from sensor_msgs.msg import Image
    from std_msgs.msg import Empty
    from test_msgs.action import Fibonacci

    rclpy.init()
    node = rclpy.create_node("plain")
    goals: list[Any] = []
    move = ActionClient(node, Fibonacci, "/move")
    move.wait_for_server()

    unwanted = threading.Event()

    def accepted(sent: Any) -> None:
        goals.append(sent.result())
        if unwanted.is_set():  # stopped before it was known to be accepted
            goals[-1].cancel_goal_async()
        goals[-1].get_result_async().add_done_callback(lambda ended: start() if len(goals) < ROUNDS else os._exit(0))

    def start() -> None:
        unwanted.clear()
        move.send_goal_async(Fibonacci.Goal()).add_done_callback(accepted)

    node.create_subscription(Image, "/camera", lambda _message: None, 10)

    def stop(_message: Any) -> None:
        unwanted.set()
        if goals:
            goals[-1].cancel_goal_async()

    node.create_subscription(Empty, "/stop", stop, 10)
    start()
    rclpy.spin(node)


def camera_process() -> None:
    import rclpy

    rclpy.init()
    node = rclpy.create_node("camera")
    films(node)
    rclpy.spin(node)


def films(node: Any) -> None:
    from sensor_msgs.msg import Image

    camera = node.create_publisher(Image, "/camera", 1)
    picture = Image(width=640, height=480, encoding="rgb8", step=1920, data=PICTURE["data"])
    node.create_timer(PERIOD_S, lambda: camera.publish(picture))


# -- the robot ---------------------------------------------------------------------------------------------------------


class Actuator:
    """Stops when its server receives a cancel."""

    def __init__(self, node: Any, executor: Any) -> None:
        from rclpy.action import ActionServer, CancelResponse
        from std_msgs.msg import Empty
        from test_msgs.action import Fibonacci

        self.moves, self.stopped, self.at = threading.Event(), threading.Event(), 0.0
        self._result, self._accept, self._executor, self._empty = (
            Fibonacci.Result,
            CancelResponse.ACCEPT,
            executor,
            Empty(),
        )
        ActionServer(
            node,
            Fibonacci,
            "/move",
            lambda handle: self._result(),
            handle_accepted_callback=lambda handle: self.moves.set(),
            cancel_callback=self._cancel,
        )
        self._stop = node.create_publisher(Empty, "/stop", 10)

    def _cancel(self, handle: Any) -> Any:
        self.at = time.perf_counter()
        self.stopped.set()
        self._executor.create_task(lambda: handle.execute(self._canceled))
        return self._accept

    def _canceled(self, handle: Any) -> Any:
        handle.canceled()
        return self._result()

    def begin(self) -> None:
        """Anyone who is measured starts the next goal, and listens."""
        while not self._stop.get_subscription_count():
            time.sleep(0.05)

    def stop(self) -> None:
        self.moves.clear()  # the next goal sets it
        self._stop.publish(self._empty)


class Base:
    """Is commanded past the gate, a hundred times a second, and stops at the first command that is zero."""

    def __init__(self, node: Any, executor: Any) -> None:
        from geometry_msgs.msg import Twist
        from std_msgs.msg import String

        self.moves, self.stopped, self.at = threading.Event(), threading.Event(), 0.0
        self._request, self._string = node.create_publisher(String, "/gate/operator/request", 10), String
        command, drive = node.create_publisher(Twist, "/gate/autonomy/cmd_vel", 10), Twist()
        drive.linear.x = 1.0
        node.create_subscription(Twist, "/cmd_vel", self._on_command, 10)
        node.create_timer(COMMANDS_S, lambda: command.publish(drive))

    def _on_command(self, command: Any) -> None:
        if command.linear.x:
            self.moves.set()
        elif self.moves.is_set():
            self.at = time.perf_counter()
            self.moves.clear()
            self.stopped.set()

    def begin(self) -> None:
        while not self._request.get_subscription_count():
            time.sleep(0.05)
        self._request.publish(self._string(data='{"to": "autonomy"}'))

    def stop(self) -> None:
        self._request.publish(self._string(data='{"to": "no one"}'))


@contextlib.contextmanager
def others(kind: str, *, is_apart: bool) -> Iterator[None]:
    """The process that is measured, and those that load the machine meanwhile."""
    here = "benchmarks.stop_over_ros"
    started = [other(here, "mission" if kind == "gate" else kind)]
    if kind == "gate":
        started.append(
            other("rai_missions.cli.main", "gate", "--ros", "--quiet", "--command", "/cmd_vel=geometry_msgs/msg/Twist")
        )
    if is_apart:
        started.append(other(here, "camera"))
    try:
        yield
    finally:
        for each in started:
            each.kill()
            each.wait()


def measured(kind: str, *, is_apart: bool) -> list[float]:
    import rclpy
    from rclpy.executors import SingleThreadedExecutor

    rclpy.init()
    node, executor = rclpy.create_node("stopped_robot"), SingleThreadedExecutor()
    robots: dict[str, Callable[[Any, Any], Any]] = {"gate": Base}
    robot = robots.get(kind, Actuator)(node, executor)
    if kind == "gate":
        Actuator(node, executor)  # the mission that runs meanwhile moves it, and is not stopped
    if not is_apart:
        films(node)
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    spent = []
    with others(kind, is_apart=is_apart):
        for number in range(ROUNDS):
            robot.begin()
            if not robot.moves.wait(PATIENCE_S):
                raise SystemExit(f"nothing moved: {KINDS[kind]}")
            time.sleep(0.0 if number else 2.0)  # until both sides have found each other
            time.sleep(0.1 + 0.0007 * (number % 50))
            robot.stopped.clear()
            began = time.perf_counter()
            robot.stop()
            if not robot.stopped.wait(PATIENCE_S):
                raise SystemExit("the actuator was not stopped")
            spent.append(robot.at - began)
    return spent


def robot_process(kind: str, layout: str) -> None:
    if layout == "roomy":
        from rai_missions.connectors.ros2.fastdds import edition

        os.environ[edition().variable] = str(edition().pictures)
    print_times(f"over ROS 2, {KINDS[kind]}{LAYOUTS[layout]}", measured(kind, is_apart=layout == "apart"))
    os._exit(0)


if __name__ == "__main__":
    if sys.argv[1] == "robot":
        robot_process(*sys.argv[2:4])
    {"mission": mission_process, "plain": plain_process, "camera": camera_process}[sys.argv[1]]()
