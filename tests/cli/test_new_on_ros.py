# SPDX-License-Identifier: Apache-2.0
"""A new mission's ROS profile carries a run over real ROS 2: its robot, simulated, is there behind the same names."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from contextlib import ExitStack
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from rai_missions.connectors.connector import Connector, Data, Message, Report
from rai_missions.connectors.python_robot.connector import PythonRobotConnector
from rai_missions.connectors.python_robot.robot import EVENTS, FACTS
from rai_missions.profile import Robot, load_profile, read_program
from rai_missions.profile.sources import Source
from tests.ros2 import QUICK_DISCOVERY, load_quietly, lock_free_domain, on_ros

FIBONACCI = "test_msgs/action/Fibonacci"
SUBSTITUTES: Mapping[str, Mapping[str, Any]] = {
    "drive": {"type": FIBONACCI, "goal": {"order": {"from": "to_m"}}},
    "go_around": {"type": FIBONACCI},
    "hand_over": {"type": FIBONACCI},
}
"""Types that are installed here for those that a person's own robot brings along, `my_robot_interfaces`."""


class PassedOn:
    """An action's server, whose goals a robot in Python pursues."""

    def __init__(self, robot: Connector, name: str, goal_of: Callable[[Data], Data]) -> None:
        self._robot, self._name, self._goal_of = robot, name, goal_of

    def accept(self, goal_id: str, goal: Data, report: Callable[[Report], None]) -> None:
        self._robot.send_goal(self._name, "", self._goal_of(goal), goal_id=goal_id, on_report=report)

    def cancel(self, goal_id: str) -> None:
        self._robot.cancel_goal(goal_id)


def message_of(source: Source, value: Any) -> dict[str, Any]:
    """The message in whose field a profile finds a value."""
    content = json.dumps(value) if source.json_ else value
    for word in reversed((source.field or "data").split(".")):
        content = {word: content}
    return dict(content)


def put_on_ros(robot: Connector, profile: Robot, wire: Connector) -> None:
    """Have everything that a profile names there, and behind it a robot in Python."""

    def publish(source: Source, message: Callable[[Message], Data]) -> Callable[[Message], None]:
        return lambda received: wire.publish(source.topic or "", source.type, message(received))

    for name, action in profile.actions.items():
        goal_of = (lambda goal: {"to_m": goal["order"]}) if name == "drive" else (lambda _: {})
        wire.offer(action.action or "", action.type, PassedOn(robot, name, goal_of))
    for name, source in profile.events.items():
        robot.subscribe(EVENTS + name, "", publish(source, lambda _: {}))
    for name, source in profile.blackboard.items():
        robot.subscribe(
            FACTS + name, "", publish(source, lambda received, of=source: message_of(of, received.data["value"]))
        )


@pytest.fixture
def domain(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Iterator[None]:
    number, lock = lock_free_domain()
    monkeypatch.setenv("ROS_DOMAIN_ID", str(number))
    monkeypatch.setenv("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    monkeypatch.setenv("FASTRTPS_DEFAULT_PROFILES_FILE", str(QUICK_DISCOVERY))
    monkeypatch.setenv("ROS_LOG_DIR", str(tmp_path))
    with lock:
        yield


@pytest.mark.long
@on_ros
@pytest.mark.timeout(240)
def test_the_ros_profile_of_a_new_mission_carries_a_run(tmp_path: Path, domain: None) -> None:
    load_quietly()
    from rai_missions.connectors.ros2 import open_connector

    made = tmp_path / "first_try"  # its facts may be late, on a busy machine
    assert main(["new", str(made)]) == 0
    written = json.loads((made / "robot.ros.json").read_text(encoding="utf-8"))
    for name, substitute in SUBSTITUTES.items():
        assert written["actions"][name]["type"].startswith("my_robot_interfaces/action/")
        written["actions"][name] |= substitute
    (made / "robot.ros.json").write_text(json.dumps(written), encoding="utf-8")
    mission = (made / "mission.json").read_text(encoding="utf-8")
    (made / "mission.json").write_text(re.sub(r'"max_age_s": \d+', '"max_age_s": 60', mission), encoding="utf-8")
    command = [sys.executable, "-m", "rai_missions.cli.main", "run", "mission.json", "--robot", "robot.ros.json",
               "--no-operator", "--json", "--journal", "run.journal"]  # fmt: skip
    robot = PythonRobotConnector(read_program(made / "robot.py").robot())
    wire = open_connector({"discovery_s": 30.0})
    with ExitStack() as closing:
        for connector in (wire, robot):
            connector.start()
            closing.callback(connector.stop)
        put_on_ros(robot, load_profile(made / "robot.ros.json"), wire)
        ran = subprocess.run(
            command, cwd=made, capture_output=True, text=True, timeout=200, check=False, env=dict(os.environ)
        )
    assert ran.returncode == 0, ran.stderr
    result = json.loads(ran.stdout)
    assert (result["outcome"], result["state"]) == ("succeeded", "done")
    assert result["decisions"] >= 1
