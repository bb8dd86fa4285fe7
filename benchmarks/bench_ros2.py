# SPDX-License-Identifier: Apache-2.0
"""From a message on a topic to the call, or the cancel, that it causes: `python -m benchmarks.bench_ros2`.

The robot is one process and the mission another, on the real rclpy. The floor is the same round trip in plain rclpy, in
the same run; the peer is what is often done, a loop that looks 50 times a second at what its callbacks left.
"""

from __future__ import annotations

import gc
import importlib.util
import os
import statistics
import subprocess
import sys
import threading
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from benchmarks.figures import figure
from rai_missions.runtime.run_options import RunObserver

ROUNDS, GAP_S, IDLE_S, MISSIONS = 400, 0.004, 5.0, 100
STRING, TRIGGER, ACTION = "std_msgs/msg/String", "std_srvs/srv/Trigger", "test_msgs/action/Fibonacci"
WANTED = "wanted: within 1 ms of the floor at the median and 5 ms at p99; idle 2 % of a core; ready in 1.5 s"
THINK = {
    "decision": {"question": "?", "options": {"stay": {}}, "ask": ["agent"], "deadline_s": 600, "fallback": "stay"},
    "transitions": [{"on": "stay", "to": "thought"}],
}
ROBOT: dict[str, Any] = {
    "name": "bench",
    "connector": {"kind": "ros2"},
    "services": {"horn": {"service": "/horn", "type": TRIGGER}},
    "actions": {"move": {"action": "/move", "type": ACTION}},
}


class Robot:
    """The other process's side: reports `/go`, and writes down when the horn or a cancel is received."""

    def __init__(self) -> None:
        import rclpy
        from rclpy.action import ActionServer, CancelResponse
        from rclpy.event_handler import PublisherEventCallbacks
        from rclpy.executors import SingleThreadedExecutor
        from std_msgs.msg import String
        from std_srvs.srv import Trigger
        from test_msgs.action import Fibonacci

        rclpy.init()
        self.node, self._string, self._result = rclpy.create_node("bench_robot"), String, Fibonacci.Result
        self._takes = CancelResponse.ACCEPT
        self._silent = PublisherEventCallbacks(use_default_callbacks=False)
        self.at, self.called, self.moves = 0.0, threading.Event(), threading.Event()
        self._publishers: dict[str, Any] = {}
        self.node.create_service(Trigger, "/horn", self._horn)
        self._server = ActionServer(
            self.node,
            Fibonacci,
            "/move",
            lambda handle: self._result(),
            handle_accepted_callback=lambda handle: self.moves.set(),
            cancel_callback=self._cancel,
        )
        self._executor = SingleThreadedExecutor()
        self._executor.add_node(self.node)
        self._thread = threading.Thread(target=self._executor.spin)
        self._thread.start()

    def _horn(self, _request: Any, response: Any) -> Any:
        self.at = time.perf_counter()
        self.called.set()
        response.success = True
        return response

    def _cancel(self, handle: Any) -> Any:
        self.at = time.perf_counter()
        self._executor.create_task(lambda: handle.execute(self._canceled))
        self.called.set()
        return self._takes

    def _canceled(self, handle: Any) -> Any:
        handle.canceled()
        return self._result()

    def order(self, topic: str) -> None:
        if topic not in self._publishers:  # without rclpy's own callbacks, which it would wait for in each round
            self._publishers[topic] = self.node.create_publisher(self._string, topic, 10, event_callbacks=self._silent)
        self._publishers[topic].publish(self._string(data="x"))

    def until(self, happened: threading.Event, topic: str) -> None:
        """State it until something comes of it: the other process may not have been found yet."""
        happened.clear()
        for _ in range(40):
            self.order(topic)
            if happened.wait(0.5):
                return
        raise SystemExit(f"nothing came of {topic}")

    def until_received(self, topic: str) -> float:
        """Seconds from a message to what it causes."""
        self.called.clear()
        time.sleep(GAP_S)  # so that each finds the other side waiting
        begin = time.perf_counter()
        self.order(topic)
        if not self.called.wait(20.0):
            raise SystemExit(f"nothing came of {topic}")
        return self.at - begin

    def close(self) -> None:
        import rclpy

        self._executor.shutdown()
        self._thread.join()
        self._server.destroy()
        rclpy.shutdown()


# -- the other process -------------------------------------------------------------------------------------------------


def plain(kind: str) -> None:
    """What a program of a few lines would do with rclpy: call, cancel, or leave it to a loop that looks."""
    import rclpy
    from rclpy.action import ActionClient
    from rclpy.executors import SingleThreadedExecutor
    from sensor_msgs.msg import Image
    from std_msgs.msg import String
    from std_srvs.srv import Trigger
    from test_msgs.action import Fibonacci

    rclpy.init()
    node, wanted = rclpy.create_node("bench_plain"), threading.Event()
    horn, move, goals = node.create_client(Trigger, "/horn"), ActionClient(node, Fibonacci, "/move"), []
    horn.wait_for_service()
    move.wait_for_server()

    unwanted = threading.Event()

    def start(_message: Any) -> None:
        move.send_goal_async(Fibonacci.Goal()).add_done_callback(accepted)

    def accepted(sent: Any) -> None:
        goals.append(sent.result())
        if unwanted.is_set():
            leave(None)

    def leave(_message: Any) -> None:
        """Where the word of its acceptance has not come, cancel the goal when it does."""
        unwanted.clear() if goals else unwanted.set()
        if goals:
            goals.pop().cancel_goal_async()

    def look() -> None:
        while True:
            time.sleep(0.02)
            if wanted.is_set():
                wanted.clear()
                horn.call_async(Trigger.Request())

    deeds = {"floor": lambda _message: horn.call_async(Trigger.Request()), "polling": lambda _message: wanted.set()}
    if kind == "seeing":
        node.create_subscription(Image, "/camera", lambda _message: None, 10)
    node.create_subscription(String, "/go", deeds.get(kind, deeds["floor"]), 10)
    node.create_subscription(String, "/leave", leave, 10)
    node.create_subscription(String, "/again", start, 10)
    if kind == "polling":
        threading.Thread(target=look, daemon=True).start()
    executor = SingleThreadedExecutor()
    executor.add_node(node)
    report("ready")
    threading.Thread(target=executor.spin, daemon=True).start()


def missions(kind: str) -> None:
    """One mission, or a hundred with one connector."""
    from rai_missions.answerers.model.agent import DecisionAgent
    from rai_missions.connectors.ros2 import open_connector
    from rai_missions.mission.mission import Mission
    from rai_missions.profile import Robot as Profile
    from rai_missions.runtime.runner import Runner
    from rai_missions.testing import HangingModel

    begin = time.perf_counter()
    count, is_thinking, sees = (MISSIONS if kind == "hundred" else 1), kind == "thinking", kind == "camera"
    connector, started = open_connector({}), threading.Semaphore(0)
    gc.freeze()  # as the command `run` does, with `set_apart`
    connector.start()
    for number in range(count):
        suffix = str(number) if count > 1 else ""
        made = Mission.model_validate(mission(is_thinking=is_thinking, sees=sees))
        events = {name: {"topic": f"/{name}{suffix}", "type": STRING} for name in ("go", "leave", "again")}
        eyes = {"camera": {"topic": "/camera", "type": "sensor_msgs/msg/Image"}} if sees else {}
        runner = Runner(
            made,
            robot=Profile.model_validate({**ROBOT, "events": events, "blackboard": eyes}),
            connector=connector,
            answerers={"agent": DecisionAgent(HangingModel())},
            observer=RunObserver(lambda step: started.release() if step.seq == 1 else None),
        )
        threading.Thread(target=runner.run, daemon=True).start()
    for _ in range(count):
        started.acquire()
    report(f"ready {time.perf_counter() - begin:.3f}")


def mission(*, is_thinking: bool, sees: bool) -> dict[str, Any]:
    """Sounds the horn on `go`; leaves its goal on `leave`, and resumes another on `again`."""
    work = {"transitions": [{"on": "go", "do": [{"call": "horn"}]}, {"on": "again", "to": "moving"}]}
    moving = {"action": "move", "transitions": [{"on": "leave", "to": "work"}]}
    states: dict[str, Any] = {"initial": "work", "states": {"work": work, "moving": moving}}
    if is_thinking:
        asks = {"initial": "asks", "states": {"asks": THINK, "thought": {}}}
        states = {"initial": "both", "states": {"both": {"parallel": {"acts": states, "thinks": asks}}}}
    camera = {"camera": {"type": "image", "source": "robot", "max_age_s": 1, "optional": True}} if sees else {}
    return {"name": "bench", "events": ["go", "leave", "again"], "blackboard": camera, **states}


def camera() -> None:
    """Another process still: 640x480 pictures, ten a second."""
    import rclpy
    from sensor_msgs.msg import Image

    rclpy.init()
    node = rclpy.create_node("bench_camera")
    picture = Image(width=640, height=480, encoding="rgb8", step=1920, data=bytes(640 * 480 * 3))
    publisher = node.create_publisher(Image, "/camera", 1)
    node.create_timer(0.1, lambda: publisher.publish(picture))
    report("ready")
    threading.Thread(target=rclpy.spin, args=(node,), daemon=True).start()


def report(line: str) -> None:
    print(line, flush=True)


@contextmanager
def other(kind: str) -> Iterator[tuple[int, str]]:
    """The other process, while it is needed: its number, and what it reported when it was ready."""
    with subprocess.Popen(
        [sys.executable, "-W", "ignore", "-m", "benchmarks.bench_ros2", kind],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
        cwd=Path(__file__).parents[1],
    ) as process:
        assert process.stdin is not None and process.stdout is not None
        printed = process.stdout.readline().strip()
        yield process.pid, printed
        process.stdin.close()
        process.wait()


# -- figures -----------------------------------------------------------------------------------------------------------


def print_times(
    name: str,
    spent: list[float],
    floor: list[float] | None = None,
    most_over_ms: float | None = None,
    most_late_ms: float | None = None,
) -> list[float]:
    spent = sorted(spent)
    middle, late = statistics.median(spent), spent[int(len(spent) * 0.99)]
    line = f"{name:<46}{1e3 * middle:>10.3f}{1e3 * late:>10.3f}{1e3 * spent[-1]:>10.3f}"
    if floor is not None:
        line += f"{1e3 * (middle - statistics.median(floor)):>+10.3f}{middle / statistics.median(floor):>8.2f}"
    print(line, flush=True)
    peer = ("plain rclpy", 1e3 * statistics.median(floor)) if floor is not None else None
    most = peer[1] + most_over_ms if peer is not None and most_over_ms is not None else None
    figure(f"ROS 2, wall, median: {name}", 1e3 * middle, "ms", peer=peer, most=most)
    figure(f"ROS 2, wall, p99: {name}", 1e3 * late, "ms", most=most_late_ms)
    return spent


def calls(
    robot: Robot,
    name: str,
    floor: list[float] | None,
    topic: Callable[[int], str],
    *,
    most_over_ms: float | None = None,
    most_late_ms: float | None = None,
) -> list[float]:
    for each in dict.fromkeys(topic(number) for number in range(ROUNDS)):
        robot.until(robot.called, each)
    time.sleep(1.0)  # what was reported more than once is received more than once
    spent = [robot.until_received(topic(number)) for number in range(ROUNDS)]
    return print_times(name, spent, floor, most_over_ms, most_late_ms)


def cancels(robot: Robot, name: str, floor: list[float] | None) -> list[float]:
    spent = []
    for _ in range(ROUNDS // 4):
        robot.until(robot.moves, "/again")
        time.sleep(0.01)  # until the other side knows that it was accepted
        spent.append(robot.until_received("/leave"))
    return print_times(name, spent, floor)


def idle(name: str, pid: int) -> None:
    """Processor time of a process that waits."""

    def used_s() -> float:
        words = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()
        return (int(words[11]) + int(words[12])) / os.sysconf("SC_CLK_TCK")

    time.sleep(1.0)
    before = used_s()
    time.sleep(IDLE_S)
    print(f"    {name}, nothing happens: {100 * (used_s() - before) / IDLE_S:.1f} % of a core", flush=True)


def main() -> None:
    if importlib.util.find_spec("rclpy") is None or importlib.util.find_spec("test_msgs") is None:
        print("ROS 2 is not installed, nothing is measured: pip install -e '.[ros,ros-test]'")
        return
    robot = Robot()
    gc.freeze()  # a full search would be a late answer of the robot
    try:
        measure(robot)
    finally:  # its thread would keep the process
        robot.close()


def measure(robot: Robot) -> None:
    print(
        f"{'from a message to its call, ms':<46}{'median':>10}{'p99':>10}{'longest':>10}{'over floor':>10}{'ratio':>8}"
    )
    with other("floor") as (pid, _):
        floor = calls(robot, "floor: plain rclpy", None, lambda _: "/go")
        floor_cancel = cancels(robot, "floor: plain rclpy, a cancel", None)
        idle("plain rclpy", pid)
    with other("polling") as (pid, _):
        calls(robot, "peer: a loop that looks 50 times a second", floor, lambda _: "/go")
        idle("such a loop", pid)
    with other("mission") as (pid, printed):
        calls(robot, "mission", floor, lambda _: "/go")
        cancels(robot, "mission, a cancel", floor_cancel)
        idle("mission", pid)
        print(f"    from the connector's start to the mission's: {printed.split()[-1]} s")
    with other("thinking"):
        calls(robot, "mission, while a model hangs", floor, lambda _: "/go")
    with other("pictures"):
        with other("seeing"):
            seen = calls(robot, "floor: plain rclpy, while pictures come", None, lambda _: "/go")
        with other("camera"):
            calls(robot, "mission, while pictures come", seen, lambda _: "/go")
    with other("hundred") as (pid, printed):
        calls(
            robot,
            f"{MISSIONS} missions, one connector",
            floor,
            lambda number: f"/go{number % MISSIONS}",
            most_over_ms=0.4,
            most_late_ms=3.0,
        )
        idle(f"{MISSIONS} missions", pid)
        print(f"    {MISSIONS} missions from the connector's start to the last one's: {printed.split()[-1]} s")
    print(WANTED)


if __name__ == "__main__":
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    os.environ.setdefault("ROS_DOMAIN_ID", "71")
    if len(sys.argv) == 1:
        main()
    else:
        kind = sys.argv[1]
        camera() if kind == "pictures" else plain(kind) if kind in ("floor", "polling", "seeing") else missions(kind)
        sys.stdin.read()
        os._exit(0)
