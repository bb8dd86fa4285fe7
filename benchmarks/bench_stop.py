# SPDX-License-Identifier: Apache-2.0
"""From an emergency stop to the cancel that the actuator's server hears, under load: `python -m benchmarks.bench_stop`.

A model hangs, events flood in from another thread, pictures of 640x480 arrive thirty times a second, and the journal is
on disk. In process, and over ROS 2 where it is installed: there the server, the camera and whoever stops are another
process, so both ways over the wire count.
"""

from __future__ import annotations

import importlib.util
import os
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

ROUNDS, PERIOD_S, EVENTS_S = 200, 1 / 30, 2000
ACTION, IMAGE, EMPTY = "test_msgs/action/Fibonacci", "sensor_msgs/msg/Image", "std_msgs/msg/Empty"
PICTURE: dict[str, Any] = {
    "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "camera"}, "height": 480, "width": 640,
    "encoding": "rgb8", "is_bigendian": 0, "step": 1920, "data": bytes(640 * 480 * 3),
}  # fmt: skip
MISSION = {
    "name": "loaded", "initial": "both", "events": ["poke"],
    "blackboard": {"camera": {"type": "image", "source": "robot", "max_age_s": 1, "optional": True},
                   "pokes": {"type": "integer", "source": "mission", "initial": 0}},
    "states": {
        "both": {"parallel": {
            "acts": {"initial": "moving", "states": {
                "moving": {"action": "move", "timeout_s": 600, "transitions": [
                    {"on": "poke", "do": [{"set": "pokes", "add": 1}]}]}}},
            "thinks": {"initial": "asks", "states": {
                "asks": {"decision": {"question": "?", "evidence": ["camera"], "options": {"stay": {}},
                                      "ask": ["agent"], "deadline_s": 600, "fallback": "stay"},
                         "transitions": [{"on": "stay", "to": "thought"}]},
                "thought": {}}}}},
    },
}  # fmt: skip


def profile(kind: str) -> dict[str, Any]:
    return {
        "name": "loaded", "connector": {"kind": kind},
        "blackboard": {"camera": {"topic": "/camera", "type": IMAGE}},
        "events": {"poke": {"posted": True}},
        "actions": {"move": {"action": "/move", "type": ACTION}},
    }  # fmt: skip


def loaded(connector: Any, kind: str, folder: Path, number: int, ended: threading.Event) -> Any:
    """A runner under full load, and its flood."""
    from rai_missions.agents.decision import DecisionAgent
    from rai_missions.event import Event
    from rai_missions.journal import Header, Journal
    from rai_missions.load import dump
    from rai_missions.mission import Mission
    from rai_missions.robot import Robot
    from rai_missions.runner import Runner
    from rai_missions.testing import HangingModel

    mission = Mission.model_validate(MISSION)
    journal = Journal.create(folder / f"{number}.journal", Header(dump(mission), "", {}))
    runner = Runner(
        mission, robot=Robot.model_validate(profile(kind)), connector=connector, journal=journal,
        answerers={"agent": DecisionAgent(HangingModel())},
    )  # fmt: skip

    def flood() -> None:
        while not ended.wait(1 / 100):
            for _ in range(EVENTS_S // 100):
                runner.post(Event("poke", runner.clock.now()))

    threading.Thread(target=flood, daemon=True).start()
    return runner, journal


def told(name: str, spent: list[float]) -> None:
    ordered = sorted(spent)
    middle, late = statistics.median(ordered), ordered[min(len(ordered) - 1, int(len(ordered) * 0.99))]
    figures = f"median {1e3 * middle:.2f} ms, p99 {1e3 * late:.2f} ms, longest {1e3 * ordered[-1]:.2f} ms"
    late_ones = sum(each > 1.0 for each in ordered)
    print(f"{name:<26}{len(ordered)} stops: {figures}, {late_ones} over a second", flush=True)


class Server:
    """Moves until it is told to stop, and writes down when."""

    def __init__(self) -> None:
        self.moves, self.stopped = threading.Event(), threading.Event()
        self.at = 0.0
        self._report: Callable[[Any], None] = lambda said: None

    def accept(self, goal_id: str, goal: Mapping[str, Any], report: Callable[[Any], None]) -> None:
        from rai_missions.connectors.connector import Report

        self._report = report
        report(Report(goal_id, "accepted", {}))
        self.moves.set()

    def cancel(self, goal_id: str) -> None:
        from rai_missions.connectors.connector import Report

        self.at = time.perf_counter()
        self.stopped.set()
        self._report(Report(goal_id, "canceled", {}))


def in_process(folder: Path) -> list[float]:
    from rai_missions.connectors.local import LocalConnector

    spent = []
    for number in range(ROUNDS):
        connector, server, ended = LocalConnector(), Server(), threading.Event()
        connector.start()
        connector.offer("/move", ACTION, server)
        runner, journal = loaded(connector, "local", folder, number, ended)
        run = threading.Thread(target=runner.run)
        run.start()
        server.moves.wait(30)
        threading.Thread(target=pictures, args=(connector, ended), daemon=True).start()
        time.sleep(0.1 + 0.0007 * (number % 50))
        began = time.perf_counter()
        runner.kill("the button")
        if not server.stopped.wait(30):
            raise SystemExit("the actuator was not stopped")
        spent.append(server.at - began)
        ended.set()
        run.join()
        journal.close()
    return spent


def pictures(connector: Any, ended: threading.Event) -> None:
    while not ended.wait(PERIOD_S):
        connector.publish("/camera", IMAGE, PICTURE)


# -- over ROS 2: this process is the robot, another the mission --------------------------------------------------------


def mission_process() -> None:
    """One mission after the other, until stopped for good; each stops when `/stop` says so."""
    from rai_missions.connectors.ros2 import open_connector

    folder = Path(tempfile.mkdtemp())
    connector = open_connector({})
    connector.start()
    runners: list[Any] = []
    connector.subscribe("/stop", EMPTY, lambda heard: runners[-1].kill("the button"))
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
    node, goals = rclpy.create_node("plain"), []  # type: ignore[var-annotated]
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

    node.create_subscription(Image, "/camera", lambda heard: None, 10)
    node.create_subscription(
        Empty, "/stop", lambda heard: (unwanted.set(), goals and goals[-1].cancel_goal_async()), 10
    )
    start()
    rclpy.spin(node)


def over_ros(kind: str) -> list[float]:
    import rclpy
    from rclpy.action import ActionServer, CancelResponse
    from rclpy.executors import SingleThreadedExecutor
    from sensor_msgs.msg import Image
    from std_msgs.msg import Empty
    from test_msgs.action import Fibonacci

    rclpy.init()
    node, moves, stopped, at = rclpy.create_node("stopped_robot"), threading.Event(), threading.Event(), [0.0]
    executor = SingleThreadedExecutor()

    def canceled(handle: Any) -> Any:
        handle.canceled()
        return Fibonacci.Result()

    def cancel(handle: Any) -> Any:
        at[0] = time.perf_counter()
        stopped.set()
        executor.create_task(lambda: handle.execute(canceled))
        return CancelResponse.ACCEPT

    ActionServer(
        node, Fibonacci, "/move", lambda handle: Fibonacci.Result(),
        handle_accepted_callback=lambda handle: moves.set(), cancel_callback=cancel,
    )  # fmt: skip
    stop = node.create_publisher(Empty, "/stop", 10)
    camera = node.create_publisher(Image, "/camera", 1)
    picture = Image(width=640, height=480, encoding="rgb8", step=1920, data=PICTURE["data"])
    node.create_timer(PERIOD_S, lambda: camera.publish(picture))
    executor.add_node(node)
    threading.Thread(target=executor.spin, daemon=True).start()
    spent = []
    other = [sys.executable, "-W", "ignore", "-m", "benchmarks.bench_stop", kind]
    with subprocess.Popen(other, cwd=Path(__file__).parents[1]) as process:
        for number in range(ROUNDS):
            if not moves.wait(60):
                process.kill()
                raise SystemExit("the mission's process started no goal")
            while not stop.get_subscription_count():
                time.sleep(0.05)
            time.sleep(0.0 if number else 2.0)  # until both sides have found each other
            moves.clear()
            stopped.clear()
            time.sleep(0.1 + 0.0007 * (number % 50))
            began = time.perf_counter()
            stop.publish(Empty())
            if not stopped.wait(30):
                process.kill()
                raise SystemExit("the actuator was not stopped")
            spent.append(at[0] - began)
    return spent


def main() -> None:
    with tempfile.TemporaryDirectory() as folder:
        told("in process", in_process(Path(folder)))
    if importlib.util.find_spec("rclpy") is None or importlib.util.find_spec("test_msgs") is None:
        print("ROS 2 is not installed; over it nothing is measured")
        return
    for kind in ("plain", "mission"):
        command = [sys.executable, "-W", "ignore", "-m", "benchmarks.bench_stop", "robot", kind]
        subprocess.run(command, cwd=Path(__file__).parents[1], check=True)


if __name__ == "__main__":
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    os.environ.setdefault("ROS_DOMAIN_ID", "73")
    os.environ.setdefault("ROS_LOG_DIR", tempfile.mkdtemp())
    if sys.argv[1:2] == ["robot"]:
        told(
            {"plain": "over ROS 2, plain rclpy", "mission": "over ROS 2, a mission"}[sys.argv[2]], over_ros(sys.argv[2])
        )
        os._exit(0)
    {"mission": mission_process, "plain": plain_process}.get("".join(sys.argv[1:]), main)()
