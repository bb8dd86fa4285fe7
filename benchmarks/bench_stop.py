# SPDX-License-Identifier: Apache-2.0
"""From an e-stop to the cancel that the actuator's server receives, under load: `python -m
benchmarks.bench_stop`.

A model hangs, events flood in from another thread, pictures of 640x480 arrive thirty times a second, and the journal is
on disk. The floor is a thread that waits at a queue under the same events and pictures, and does nothing else. Then
over ROS 2 where it is installed, see `stop_over_ros.py`: there the stop has a wire to cross, and so has the cancel.
"""

from __future__ import annotations

import importlib.util
import os
import queue
import statistics
import subprocess
import sys
import tempfile
import threading
import time
from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any

ROUNDS, PERIOD_S, EVENTS_S = 200, 1 / 30, 2000
ACTION, IMAGE, EMPTY = "test_msgs/action/Fibonacci", "sensor_msgs/msg/Image", "std_msgs/msg/Empty"
PICTURE: dict[str, Any] = {
    "header": {"stamp": {"sec": 0, "nanosec": 0}, "frame_id": "camera"},
    "height": 480,
    "width": 640,
    "encoding": "rgb8",
    "is_bigendian": 0,
    "step": 1920,
    "data": bytes(640 * 480 * 3),
}
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
        "name": "loaded",
        "connector": {"kind": kind},
        "blackboard": {"camera": {"topic": "/camera", "type": IMAGE}},
        "events": {"poke": {"posted": True}},
        "actions": {"move": {"action": "/move", "type": ACTION}},
    }


def loaded(connector: Any, kind: str, folder: Path, number: int, ended: threading.Event, agent: Any = None) -> Any:
    """A runner under full load, and its flood."""
    from rai_missions.answerers.model.agent import DecisionAgent
    from rai_missions.event import Event
    from rai_missions.journal import Header, Journal
    from rai_missions.mission.files import dump
    from rai_missions.mission.mission import Mission
    from rai_missions.profile import Robot
    from rai_missions.runtime.runner import Runner
    from rai_missions.testing import HangingModel

    mission = Mission.model_validate(MISSION)
    journal = Journal.create(folder / f"{number}.journal", Header(dump(mission), "", {}))
    runner = Runner(
        mission,
        robot=Robot.model_validate(profile(kind)),
        connector=connector,
        journal=journal,
        answerers={"agent": agent or DecisionAgent(HangingModel())},
    )

    def poke() -> None:
        runner.post(Event("poke", runner.view.now()))

    threading.Thread(target=flooded, args=(poke, ended), daemon=True).start()
    return runner, journal


def flooded(poke: Callable[[], None], ended: threading.Event) -> None:
    while not ended.wait(1 / 100):
        for _ in range(EVENTS_S // 100):
            poke()


def print_times(name: str, spent: list[float]) -> None:
    ordered = sorted(spent)
    middle, late = statistics.median(ordered), ordered[min(len(ordered) - 1, int(len(ordered) * 0.99))]
    figures = f"median {1e3 * middle:.2f} ms, p99 {1e3 * late:.2f} ms, longest {1e3 * ordered[-1]:.2f} ms"
    late_ones = sum(each > 1.0 for each in ordered)
    print(f"{name:<40}{len(ordered)} stops: {figures}, {late_ones} over a second", flush=True)


class Server:
    """Moves until it is asked to stop, and writes down when."""

    def __init__(self) -> None:
        self.moves, self.stopped = threading.Event(), threading.Event()
        self.at = 0.0
        self._report: Callable[[Any], None] = lambda report: None

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


def floor() -> list[float]:
    """How long a thread takes to be woken, on this machine, at this load."""
    from rai_missions.connectors.local import LocalConnector

    spent = []
    for number in range(ROUNDS):
        connector, server, ended = LocalConnector(), Server(), threading.Event()
        connector.start()
        waits: queue.SimpleQueue[str] = queue.SimpleQueue()

        def work(waits: queue.SimpleQueue[str] = waits, server: Server = server) -> None:
            while waits.get() != "stop":
                pass
            server.cancel("")

        threading.Thread(target=work).start()
        threading.Thread(target=flooded, args=(partial(waits.put, "poke"), ended), daemon=True).start()
        threading.Thread(target=pictures, args=(connector, ended), daemon=True).start()
        time.sleep(0.1 + 0.0007 * (number % 50))
        began = time.perf_counter()
        waits.put("stop")
        server.stopped.wait(30)
        spent.append(server.at - began)
        ended.set()
    return spent


def pictures(connector: Any, ended: threading.Event) -> None:
    while not ended.wait(PERIOD_S):
        connector.publish("/camera", IMAGE, PICTURE)


def main() -> None:
    print_times("in process, a plain thread", floor())
    with tempfile.TemporaryDirectory() as folder:
        print_times("in process, a mission", in_process(Path(folder)))
    if importlib.util.find_spec("rclpy") is None or importlib.util.find_spec("test_msgs") is None:
        print("ROS 2 is not installed; over it nothing is measured")
        return
    for layout in ("together", "roomy", "apart"):
        for kind in ("plain", "mission", "gate"):
            command = [sys.executable, "-W", "ignore", "-m", "benchmarks.stop_over_ros", "robot", kind, layout]
            subprocess.run(command, cwd=Path(__file__).parents[1], check=True)


if __name__ == "__main__":
    os.environ.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    os.environ.setdefault("ROS_DOMAIN_ID", "73")
    os.environ.setdefault("ROS_LOG_DIR", tempfile.mkdtemp())
    main()
