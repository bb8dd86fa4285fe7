# SPDX-License-Identifier: Apache-2.0
"""Fields that a profile names: reported before the start where the type has none of the name, and at the first
message."""

from __future__ import annotations

import logging
from collections.abc import Mapping
from pathlib import Path
from shutil import copytree
from typing import Any

import pytest

from rai_missions.connectors.local import LocalConnector
from rai_missions.event import Event
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, field_faults, load_profile, unknown_fields
from rai_missions.runtime.clock import WallClock
from rai_missions.runtime.mailbox import Mailbox
from rai_missions.runtime.robot_listener import RobotListener
from rai_missions.runtime.scheduler import Scheduler

MISSIONS = Path(__file__).parents[2] / "missions"
ON_ROS = sorted(MISSIONS.glob("*/robot.ros2*.json"))
BATTERY = {"voltage": "float", "percentage": "float", "cell_voltage": "sequence<float>", "serial": "string"}
TYPES: Mapping[str, Mapping[str, Any]] = {
    "s/msg/Battery": BATTERY,
    "s/msg/String": {"data": "string"},
    "s/srv/Ask": {"success": "boolean", "poses": [{"position": {"x": "double"}}], "deep": "s/Deep"},
}


def faults(**words: Any) -> list[str]:
    robot = Robot.model_validate({"name": "r", "connector": {"kind": "ros2"}, **words})
    return [str(each) for each in unknown_fields(None, robot, lambda name, _: TYPES.get(name))]


def battery(field: str, **words: Any) -> dict[str, Any]:
    return {"battery": {"topic": "/b", "type": "s/msg/Battery", "field": field, **words}}


SENT: Mapping[tuple[str, str], Mapping[str, Any]] = {
    ("s/action/Go", "goal"): {"pose": {"position": {"x": "double", "y": "double"}}, "speed": "float"},
    ("s/action/Go", "result"): {"error": "string"},
    ("s/srv/Ask", "request"): {"data": "boolean"},
    ("s/srv/Ask", "srv"): {"success": "boolean"},
    ("s/msg/Bool", "msg"): {"data": "boolean"},
}
ROBOT = {
    "name": "r", "connector": {"kind": "ros2"},
    "actions": {
        "go": {"action": "/go", "type": "s/action/Go"},
        "lift": {"start": {"service": "/lift", "type": "s/srv/Ask"}, "succeeded": {"key": "up", "==": True}},
    },
    "services": {"ask": {"service": "/ask", "type": "s/srv/Ask"}},
    "topics": {"lamp": {"topic": "/lamp", "type": "s/msg/Bool"}},
}  # fmt: skip


def sent_faults(mission: Mission | None, **words: dict[str, Any]) -> list[str]:
    parts = {
        sort: {name: {**entry, **words.get(name, {})} for name, entry in ROBOT[sort].items()}  # type: ignore[attr-defined]
        for sort in ("actions", "services", "topics")
    }
    robot = Robot.model_validate(ROBOT | parts)
    return [str(each) for each in unknown_fields(mission, robot, lambda name, part: SENT.get((name, part)))]


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        ({"go": {"goal": {"sped": 1.0}}}, "/actions/go/goal/sped: the goal of a s/action/Go has no field 'sped' (did "
         "you mean 'speed'?); it has: pose, speed"),
        ({"go": {"goal": {"pose": {"position": {"z": {"from": "height_m"}}}}}},
         "/actions/go/goal/pose/position/z: the goal of a s/action/Go has no field 'z' in 'pose.position'; it has"),
        ({"go": {"result": {"why": "eror"}}}, "/actions/go/result/why: the result of a s/action/Go has no field"),
        ({"ask": {"request": {"on": True}}}, "/services/ask/request/on: the request of a s/srv/Ask has no field 'on'"),
        ({"lamp": {"message": {"value": True}}}, "/topics/lamp/message/value: a s/msg/Bool has no field 'value'"),
        ({"go": {"goal": {"pose": {"from": "there"}, "speed": None}, "type": "other/action/Go"}}, ""),
        ({"go": {"goal": {"pose": {"from": "there", "as": "s/msg/Pose"}, "speed": {"from": "speed"}}}}, ""),
    ],
)  # fmt: skip
def test_a_field_that_is_sent_or_taken_and_that_its_type_has_not_is_reported(
    words: dict[str, dict[str, Any]], fault: str
) -> None:
    found = sent_faults(None, **words)
    assert len(found) == bool(fault) and all(each.startswith(fault) for each in found)


def test_the_fields_of_who_holds_control_are_compared_as_those_of_any_source() -> None:
    who = {"service": "/who", "type": "s/srv/Ask", "every_s": 1, "field": "sucess"}
    assert faults(holder=who)[0].startswith(
        "/holder/field: a s/srv/Ask has no field 'sucess' (did you mean 'success'?)"
    )


def test_what_a_mission_sends_is_compared_where_the_profile_passes_it_on() -> None:
    def mission(goal: dict[str, Any], result: dict[str, Any]) -> Mission:
        doing = [{"publish": "lamp", "message": {"value": True}}, {"call": "ask", "request": {"on": 1}}]
        going = {"action": "go", "goal": goal, "result": result, "timeout_s": 5, "exit": doing}
        going |= {"transitions": [{"on": "succeeded", "to": "lifting"}]}
        lifting = {"action": "lift", "goal": {"to_m": 1}, "timeout_s": 5}
        lifting |= {"transitions": [{"on": "succeeded", "to": "over"}]}
        return Mission.model_validate({
            "name": "m", "initial": "going",
            "blackboard": {"n": {"type": "string", "source": "mission", "initial": ""}},
            "states": {"going": going, "lifting": lifting, "over": {"final": "aborted"}},
        })  # fmt: skip

    found = sent_faults(mission({"sped": 1, "pose": {"position": {"x": 1.0}}}, {"n": "eror"}))
    assert [each.partition("; the")[0].partition(", and")[0] for each in found] == [
        "/actions/go: the mission gives it 'sped' at /states/going/goal",
        "/actions/go: the mission takes 'eror' at /states/going/result",
        "/topics/lamp: the mission gives it 'value' at /states/going/exit/0/message",
        "/services/ask: the mission gives it 'on' at /states/going/exit/1/request",
        "/actions/lift/start: the mission gives it 'to_m' at /states/lifting/goal",
    ]
    asked = {"go": {"goal": {"speed": {"from": "sped"}}, "result": {"eror": "error"}}}
    others = sent_faults(mission({"sped": 1}, {"n": "eror"}), **asked)
    assert not [each for each in others if "/actions/go" in each]


@pytest.mark.parametrize(
    ("field", "message"),
    [
        (
            "percent",
            "has no field 'percent' (did you mean 'percentage'?); it has: voltage, percentage, cell_voltage, s",
        ),
        ("xyz", "has no field 'xyz'; it has: voltage, percentage, cell_voltage, serial"),
        ("voltage.x", "has no field 'x' in 'voltage', which is one value"),
        ("serial.0", "has no field '0' in 'serial', which is one value"),
        ("cell_voltage.x", "has no field 'x' in 'cell_voltage', which is a list"),
    ],
)
def test_a_field_that_a_type_has_not_is_reported_with_those_that_it_has(field: str, message: str) -> None:
    (fault,) = faults(blackboard=battery(field))
    assert fault.startswith(f"/blackboard/battery/field: a s/msg/Battery {message}")


@pytest.mark.parametrize("field", ["percentage", "cell_voltage.7", ""])
def test_a_field_that_a_type_has_is_no_fault(field: str) -> None:
    assert faults(blackboard=battery(field)) == []


def test_all_faults_are_reported_at_once_and_those_of_events_too() -> None:
    ask = {"service": "/ask", "type": "s/srv/Ask", "every_s": 1}
    found = faults(
        blackboard={
            **battery("percent"),
            "place": {**ask, "field": "poses.0.position.y"},
            "deep": {**ask, "field": "deep.what.ever"},
            "other": {"topic": "/o", "type": "not/msg/Here", "field": "x"},
        },
        events={
            "reported": {
                "topic": "/s",
                "type": "s/msg/String",
                "when": {"any": [{"key": "dada", "==": "GO"}, {"key": "data", "==": {"key": "date"}}]},
                "fields": {"word": "data", "other": "word"},
            },
            "parsed": {"topic": "/s", "type": "s/msg/String", "json": True, "when": {"key": "mode", "==": "GO"}},
        },
    )
    assert [each.partition(";")[0] for each in found] == [
        "/blackboard/battery/field: a s/msg/Battery has no field 'percent' (did you mean 'percentage'?)",
        "/blackboard/place/field: a s/srv/Ask has no field 'y' in 'poses.0.position'",
        "/events/reported/when: a s/msg/String has no field 'dada' (did you mean 'data'?)",
        "/events/reported/when: a s/msg/String has no field 'date' (did you mean 'data'?)",
        "/events/reported/fields/other: a s/msg/String has no field 'word'",
    ]


@pytest.mark.parametrize("profile", ON_ROS, ids=lambda path: f"{path.parent.name}/{path.name}")
def test_the_shipped_profiles_name_what_their_types_have(profile: Path) -> None:
    pytest.importorskip("rclpy")
    from rai_missions.connectors.ros2 import fields_of

    robot = load_profile(profile)
    for mission in profile.parent.glob("*.json"):
        if not mission.name.startswith("robot."):
            assert unknown_fields(load(mission), robot, fields_of) == ()
    assert unknown_fields(None, robot, fields_of) == ()


@pytest.mark.parametrize("command", ["run", "check"])
def test_a_field_that_is_not_there_is_refused_before_a_start_over_ros_and_by_check(
    command: str, tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    pytest.importorskip("rclpy")
    from rai_missions.cli.main import main

    text = (MISSIONS / "tractor" / "robot.ros2.json").read_text(encoding="utf-8")
    assert '"percentage"' in text
    copytree(MISSIONS / "tractor" / "identity", tmp_path / "identity")
    (tmp_path / "robot.json").write_text(text.replace('"percentage"', '"percent"'), encoding="utf-8")
    given = [command, str(MISSIONS / "tractor" / "mission.json"), "--robot", str(tmp_path / "robot.json")]
    run = ["--no-operator", "--journal", str(tmp_path / "a.journal")] if command == "run" else []
    assert main([*given, *run]) == 2
    assert "a sensor_msgs/msg/BatteryState has no field 'percent'" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("name", "sentence"),
    [
        ("std_msgs/Int32", "'std_msgs/Int32' is no name of a message type; one looks like 'std_msgs/msg/String'"),
        ("std_srvs/srv/Trigger", "'std_srvs/srv/Trigger' is no name of a message type; one looks like"),
        ("my_robot_msgs/msg/Level", ""),  # of the robot's own machine
        ("std_msgs/msg/Strng", "std_msgs has no message type 'Strng'; did you mean 'String'?"),
    ],
)
def test_a_type_that_no_machine_has_is_found_without_the_robot(name: str, sentence: str) -> None:
    if name.startswith("std_msgs/msg"):
        pytest.importorskip("std_msgs", reason="no ROS 2 on this machine")
    sources = {"battery": {"topic": "/b", "type": name}}
    robot = Robot.model_validate({"name": "r", "connector": {"kind": "ros2"}, "blackboard": sources})
    found = [str(each) for each in field_faults(None, robot)]
    assert len(found) == bool(sentence)
    assert all(each.startswith(f"/blackboard/battery/type: {sentence}") for each in found)


def test_a_message_without_the_field_is_reported_once_and_one_that_leaves_it_open_is_not(
    caplog: pytest.LogCaptureFixture,
) -> None:
    robot = Robot.model_validate(
        {
            "name": "r",
            "blackboard": battery("percent") | {"open": {"topic": "/open", "type": "s/msg/Battery", "field": "level"}},
            "events": {"reported": {"topic": "/s", "type": "s/msg/String", "when": {"key": "dada", "==": "GO"}}},
        }
    )
    connector, mailbox, received = LocalConnector(), Mailbox(), list[Event]()
    connector.start()
    senses = RobotListener(robot, connector, Scheduler(WallClock(), mailbox))
    senses.open()
    with caplog.at_level(logging.WARNING):
        for _ in range(3):
            connector.publish("/b", "s/msg/Battery", {"voltage": 12.0, "percentage": 0.5})
            connector.publish("/open", "s/msg/Battery", {"level": float("nan")})
            connector.publish("/s", "s/msg/String", {"data": "GO"})
    senses.close()
    while (event := mailbox.take()) is not None:
        received.append(event)
    connector.stop()
    assert received == []
    assert [each.getMessage() for each in caplog.records] == [
        "'battery': a s/msg/Battery has no field 'percent' (did you mean 'percentage'?); it has: voltage, percentage",
        "'reported': a s/msg/String has no field 'dada' (did you mean 'data'?); it has: data",
    ]
