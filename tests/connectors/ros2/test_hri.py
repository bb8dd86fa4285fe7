# SPDX-License-Identifier: Apache-2.0
"""Talk over the real rclpy, with the message type that RAI's microphones, speakers and pages have."""

from __future__ import annotations

import importlib.util
import json
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from rai_missions.connectors.contract import Inbox
from rai_missions.connectors.hri.connector import FROM_HUMAN, TO_HUMAN, VOICE_COMMANDS, HRIConnector
from rai_missions.connectors.hri.contract import check_hri_connector
from rai_missions.connectors.hri.message import Audio, HRIMessage
from rai_missions.connectors.hri.parts import parts_of
from rai_missions.connectors.ros2 import open_connector
from rai_missions.connectors.ros2.config import read_options
from rai_missions.errors import ConnectorError
from rai_missions.image import Image

IS_BUILT = importlib.util.find_spec("rai_interfaces") is not None
built = pytest.mark.skipif(not IS_BUILT, reason="rai_interfaces is not built here: make ros-interfaces")


def met(open_ros: Callable[..., Any]) -> tuple[HRIConnector, Inbox[HRIMessage]]:
    """A person's node, and what the robot's node, which it has found, receives of it."""
    robot, person = HRIConnector(open_ros()), HRIConnector(open_ros())
    inbox: Inbox[HRIMessage] = Inbox()
    robot.listen(FROM_HUMAN, inbox)
    robot.connector.serve("/hri/there", "std_srvs/srv/Trigger", lambda _: {})
    found: Inbox[Any] = Inbox()
    person.connector.call("/hri/there", "std_srvs/srv/Trigger", {}, on_reply=found, timeout_s=30.0)
    found.wait(bool, "the nodes met")
    return person, inbox


@built
@pytest.mark.usefixtures("alone")
def test_talk_over_ros_keeps_the_contract() -> None:
    check_hri_connector(lambda: open_connector({"discovery_s": 5.0}))


@built
def test_talk_reaches_another_node(open_ros: Callable[..., Any]) -> None:
    person, inbox = met(open_ros)
    long = HRIMessage("word " * 10_000, name="Anna", communication_id="id")
    person.send(long, FROM_HUMAN)
    assert inbox.wait(bool, "a long message was sent") == [long]


@built
@pytest.mark.usefixtures("alone")
def test_a_picture_file_is_refused_with_what_would_carry_it(open_ros: Callable[..., Any]) -> None:
    picture = HRIMessage("look", (Image("x", 1, 1, "png", b""),))
    with pytest.raises(ConnectorError, match="images/0: a picture in 'png' travels as sensor_msgs/msg/CompressedImage"):
        HRIConnector(open_ros()).send(picture, TO_HUMAN)


@built
def test_pictures_and_sound_arrive_in_parts(open_ros: Callable[..., Any]) -> None:
    person, inbox = met(open_ros)
    views = tuple(Image("view", 640, 480, "rgb8", bytes([shade]) * 640 * 480 * 3) for shade in (10, 200))
    message = HRIMessage("look", views, (Audio(bytes(range(256)) * 4000, 16_000),), name="Anna", communication_id="id")
    assert len(parts_of(message)) == 3
    person.send(message, FROM_HUMAN)
    (received,) = inbox.wait(bool, "a message with pictures and sound was sent")
    assert [each.data for each in received.images] == [each.data for each in views]
    assert (received.text, received.audios, received.name) == ("look", message.audios, "Anna")


@pytest.mark.skipif(IS_BUILT, reason="rai_interfaces is here")
def test_a_profile_whose_messages_no_package_defines_is_refused_by_its_key(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    mission, profile = tmp_path / "mission.json", tmp_path / "robot.json"
    states = {"waiting": {"transitions": [{"after_s": 600, "to": "over"}]}, "over": {"final": "aborted"}}
    mission.write_text(json.dumps({"format": 1, "name": "m", "initial": "waiting", "states": states}))
    profile.write_text(
        json.dumps({"format": 1, "name": "r", "connector": {"kind": "ros2"}, "conversation": {"hri": True}})
    )
    asked = ["run", str(mission), "--robot", str(profile), "--talk", "--no-operator", "--journal", str(tmp_path / "j")]
    assert main(asked) == 2
    assert "the profile, /conversation/hri: no ROS package 'rai_interfaces'" in capsys.readouterr().err


@pytest.mark.parametrize("topic", [FROM_HUMAN, TO_HUMAN, VOICE_COMMANDS, "/robot1/from_human"])
def test_no_part_is_dropped_for_the_next_one(topic: str) -> None:
    quality = read_options({}).quality(topic)
    assert (quality.reliability, quality.durability, quality.depth) == (None, "volatile", 1000)


ERRAND = {
    "format": 1, "name": "errand", "initial": "greeting",
    "states": {
        "greeting": {"call": "greet", "timeout_s": 60, "transitions": [{"on": "succeeded", "to": "waiting"},
                                                                       {"on": "failed", "to": "over"}]},
        "waiting": {"about": "waits at the gate", "transitions": [{"after_s": 600, "to": "over"}]},
        "over": {"final": "aborted"},
    },
}  # fmt: skip
ROVER = {
    "format": 1, "name": "rover", "connector": {"kind": "ros2"},
    "services": {"greet": {"service": "/hri/there", "type": "std_srvs/srv/Trigger"}},
    "conversation": {"hri": True, "may": {"person": ["cancel"]}},
}  # fmt: skip


@pytest.mark.long
@built
def test_a_person_on_the_topics_asks_a_run_and_cancels_it(open_ros: Callable[..., Any], tmp_path: Path) -> None:
    for name, content in (("errand", ERRAND), ("rover", ROVER)):
        (tmp_path / f"{name}.json").write_text(json.dumps(content), encoding="utf-8")
    person, spoken, greeted = HRIConnector(open_ros()), Inbox[HRIMessage](), Inbox[Any]()
    person.listen(TO_HUMAN, spoken)
    person.connector.serve("/hri/there", "std_srvs/srv/Trigger", lambda asked: [greeted(asked), {"success": True}][1])
    command = [Path(sys.executable).with_name("rai-missions"), "run", "errand.json", "--robot", "rover.json", "--talk"]
    run = subprocess.Popen(
        command, cwd=tmp_path, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
    )
    try:
        greeted.wait(lambda _: True, "the robot's node has found the person's")

        def speak(text: str, reply: str) -> None:
            person.send(HRIMessage(text, author="ai", name="operator", communication_id=text), FROM_HUMAN)
            spoken.wait(lambda all_: any(reply in each.text for each in all_), f"{text!r} is answered by {reply!r}")

        speak("what are you doing?", "waits at the gate")
        speak("pause", "may not")
        speak("cancel the mission", "Is that right?")
        speak("yes", "canceled")
        assert run.wait(60.0) == 1
    finally:
        run.kill()
        printed = run.communicate()[0]
    assert "canceled by person operator (topic)" in printed, printed
    assert {each.author for each in spoken.all} == {"ai"} and {each.name for each in spoken.all} == {"rover"}
