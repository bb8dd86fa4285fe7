# SPDX-License-Identifier: Apache-2.0
"""A new mission's ROS profile carries a run over real ROS 2: its robot, simulated, is there behind the same names."""

from __future__ import annotations

import json
import os
import re
import subprocess
import sys
from collections.abc import Callable, Iterator, Mapping
from concurrent.futures import Future
from contextlib import ExitStack
from pathlib import Path
from typing import Any, NamedTuple

import pytest

from rai_missions.cli.main import main
from rai_missions.connectors.connector import Answer, Connector, Data, Message, Report
from rai_missions.connectors.python_robot.connector import PythonRobotConnector
from rai_missions.connectors.python_robot.robot import EVENTS, FACTS
from rai_missions.profile import Robot, load_profile, read_program
from rai_missions.profile.sources import Source
from tests.ros2 import QUICK_DISCOVERY, load_quietly, lock_free_domain, on_ros

FIBONACCI = "test_msgs/action/Fibonacci"


TEXT = re.compile(r"""\{["'](?:place|grip|bed|litres)["']: (?:\{[^}]*\}|[^{}])*\}""")
"""A goal or request that the types installed here cannot carry."""


class Example(NamedTuple):
    """A template, with types that are installed here for those that a person's own robot brings along."""

    template: str
    substitutes: Mapping[str, Mapping[str, Any]]
    """Action or service → what differs in its entry; the types installed here carry an integer, and no text."""
    goals: Mapping[str, Callable[[Data], Data]]
    """Action → the goal of the robot in Python, for one that has arrived over ROS."""


def in_turn(field: str, *values: str) -> Callable[[Data], Data]:
    """Fills a field of text that the type installed here lacks, a value a goal; the last one from then on."""
    left = list(values)
    return lambda _: {field: left.pop(0) if len(left) > 1 else left[0]}


def examples() -> list[Example]:
    """For one run each, since a field's values are taken in turn."""
    bare: Mapping[str, Any] = {"type": FIBONACCI}
    number, radio = {**bare, "goal": {"order": {"from": "to_m"}}}, {"type": "std_srvs/srv/Trigger"}
    parts = in_turn("grip", "top", "top", "top", "side")
    places = in_turn("place", "gate", "hall", "yard", "dock")
    beds = in_turn("bed", "herbs", "tomatoes", "beans", "door")
    return [
        Example(
            "delivery",
            {"drive": number, "go_around": bare, "hand_over": bare},
            {"drive": lambda goal: {"to_m": goal["order"]}},
        ),
        Example("patrol", {"go_to": bare, "look": bare, "radio": radio}, {"go_to": places}),
        Example("pick_and_place", {"pick": bare, "place": bare}, {"pick": parts}),
        Example("python", {"go_to": bare, "pour": bare}, {"go_to": beds, "pour": lambda _: {"litres": 1.0}}),
    ]


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


def served_by(robot: Connector, name: str) -> Answer:
    """Answers a request as the robot in Python does; the reply's fields are those of a type with `success`."""

    def answer(request: Data) -> Future[Data]:
        replied: Future[Data] = Future()
        robot.call(
            name, "", request, on_reply=lambda reply: replied.set_result({"success": reply.outcome == "succeeded"})
        )
        return replied

    return answer


def put_on_ros(robot: Connector, profile: Robot, wire: Connector, goals: Mapping[str, Callable[[Data], Data]]) -> None:
    """Have everything that a profile names there, and behind it a robot in Python."""

    def publish(source: Source, message: Callable[[Message], Data]) -> Callable[[Message], None]:
        return lambda received: wire.publish(source.topic or "", source.type, message(received))

    for name, action in profile.actions.items():
        wire.offer(action.action or "", action.type, PassedOn(robot, name, goals.get(name, lambda _: {})))
    for name, service in profile.services.items():
        wire.serve(service.service or "", service.type, served_by(robot, name))
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
@pytest.mark.parametrize("example", examples(), ids=lambda example: example.template)
def test_the_ros_profile_of_a_new_mission_carries_a_run(example: Example, tmp_path: Path, domain: None) -> None:
    load_quietly()
    from rai_missions.connectors.ros2 import open_connector

    made = tmp_path / "first_try"
    assert main(["new", str(made), "--template", example.template]) == 0
    written = json.loads((made / "robot.ros.json").read_text(encoding="utf-8"))
    for name, substitute in example.substitutes.items():
        entry = written["actions"].get(name) or written["services"][name]
        assert entry["type"].startswith("my_robot_interfaces/")
        entry |= substitute
    (made / "robot.ros.json").write_text(json.dumps(written), encoding="utf-8")
    mission = made / ("mission.py" if example.template == "python" else "mission.json")
    text = TEXT.sub("{}", mission.read_text(encoding="utf-8"))
    mission.write_text(re.sub(r'(max_age_s"?[:=] ?)\d+', r"\g<1>60", text), encoding="utf-8")  # facts of a busy machine
    command = [sys.executable, "-m", "rai_missions.cli.main", "run", mission.name, "--robot", "robot.ros.json",
               "--no-operator", "--json", "--journal", "run.journal"]  # fmt: skip
    robot = PythonRobotConnector(read_program(made / "robot.py").robot())
    wire = open_connector({"discovery_s": 30.0})
    with ExitStack() as closing:
        for connector in (wire, robot):
            connector.start()
            closing.callback(connector.stop)
        put_on_ros(robot, load_profile(made / "robot.ros.json"), wire, example.goals)
        ran = subprocess.run(
            command, cwd=made, capture_output=True, text=True, timeout=200, check=False, env=dict(os.environ)
        )
    assert ran.returncode == 0, ran.stdout + ran.stderr
    result = json.loads(ran.stdout)
    assert (result["outcome"], result["state"]) == ("succeeded", "done")
    assert result["decisions"] >= 1
