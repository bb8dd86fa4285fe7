# SPDX-License-Identifier: Apache-2.0
"""A run over the real rclpy, recorded: its messages in CDR, decoded by a program that knows nothing of us."""

from __future__ import annotations

import threading
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import yaml  # type: ignore[import-untyped, unused-ignore]

from rai_missions.agents.mission import RunConfig, prepare
from rai_missions.engine.step import Step
from rai_missions.recording import journal_of
from rai_missions.replay.replay import replay
from tests.connectors.ros2.conftest import open_ros, ros
from tests.recording.kept import LAMP, kept, robot
from tests.ros2 import on_ros

pytestmark = on_ros
pytest.importorskip("mcap")
__all__ = ("open_ros", "ros")

PATIENCE_S = 30.0
OF_A_BAG = {
    "history", "depth", "reliability", "durability", "deadline", "lifespan", "liveliness", "liveliness_lease_duration",
    "avoid_ros_namespace_conventions",
}  # fmt: skip
ROBOT = robot("ros2")


def decoded(path: Path, topic: str) -> list[Any]:
    from mcap.reader import make_reader
    from mcap_ros2.decoder import DecoderFactory

    with path.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        return [message for _, _, _, message in reader.iter_decoded_messages(topics=[topic])]


def profile_of(path: Path) -> str:
    from mcap.reader import make_reader

    with path.open("rb") as file:
        return str(make_reader(file).get_header().profile)


def robots_channels(path: Path) -> dict[str, dict[str, str]]:
    """Topic → metadata, of those that `mcap filter` leaves where the mission's own are taken out."""
    from mcap.reader import make_reader

    with path.open("rb") as file:
        summary = make_reader(file).get_summary()
        assert summary is not None
        left = [each for each in summary.channels.values() if not each.topic.startswith("/rai_missions/")]
        assert {each.message_encoding for each in left} == {"cdr"}, "bags of ROS 2 hold one encoding alone"
        return {each.topic: each.metadata for each in left}


def test_a_quality_is_written_as_bags_write_it(open_ros: Callable[..., Any]) -> None:
    from rclpy.qos import QoSProfile, qos_profile_sensor_data

    from rai_missions.connectors.ros2.offers import offered_quality

    text = offered_quality([qos_profile_sensor_data, QoSProfile(depth=3)])
    best_effort, usual = yaml.safe_load(text)
    assert (best_effort["reliability"], best_effort["depth"], best_effort["history"]) == ("best_effort", 5, "keep_last")
    assert usual["avoid_ros_namespace_conventions"] is False and usual["depth"] == 3
    assert offered_quality([]) == ""


def battery(share: float) -> dict[str, Any]:
    return {"header": {"frame_id": "base"}, "percentage": share, "cell_voltage": [3.5, 3.25], "location": "back"}


def image(shade: int) -> dict[str, Any]:
    pixels = bytes([shade]) * 12
    return {"header": {"frame_id": "eye"}, "width": 2, "height": 2, "encoding": "rgb8", "step": 6, "data": pixels}


def test_messages_of_ros_are_kept_as_they_came_and_decoded_by_others(
    tmp_path: Path, open_ros: Callable[..., Any]
) -> None:
    from rclpy.serialization import deserialize_message, serialize_message

    from rai_missions.connectors.ros2.messages import to_message
    from rai_missions.connectors.ros2.names import find_type

    robot, path, seen = open_ros(), tmp_path / "run.mcap", threading.Condition()
    entered: list[str] = []
    shots: list[Any] = []

    def see(step: Step) -> None:
        with seen:
            entered.extend(step.entered)
            shots.extend(value for key, value in step.writes if key == "camera")
            seen.notify_all()

    def wait_for(is_so: Callable[[], bool], topic: str, type_name: str, message: dict[str, Any]) -> None:
        robot.publish(topic, type_name, message)
        with seen:
            assert seen.wait_for(is_so, PATIENCE_S)

    with prepare(
        RunConfig(LAMP.model_copy(update={"ready_s": PATIENCE_S}), ROBOT, record=path, on_step=see)
    ) as prepared:
        thread = threading.Thread(target=prepared.runner.run)
        thread.start()
        wait_for(lambda: "on" in entered, "/battery", "sensor_msgs/msg/BatteryState", battery(0.9))
        wait_for(lambda: len(shots) > 0, "/camera", "sensor_msgs/msg/Image", image(7))
        wait_for(lambda: "off" in entered, "/battery", "sensor_msgs/msg/BatteryState", battery(0.125))
        thread.join(PATIENCE_S)

    found = kept(path)
    kinds = {"/battery": "sensor_msgs/msg/BatteryState", "/camera": "sensor_msgs/msg/Image"}
    sent = {"/battery": [battery(0.9), battery(0.125)], "/camera": [image(7)]}
    for topic, kind in kinds.items():
        cls = find_type(kind, "msg")
        # not byte by byte: what is where CDR only fills up is anybody's
        expected = [serialize_message(to_message(cls, each)) for each in sent[topic]]
        assert list(map(len, found.messages[topic])) == list(map(len, expected))
        received, reported = (
            [deserialize_message(each, cls) for each in some] for some in (found.messages[topic], expected)
        )
        assert received == reported
        assert {(name, encoding) for name, encoding, _ in found.schemas[topic]} == {(kind, "ros2msg")}
    assert [round(each.percentage, 3) for each in decoded(path, "/battery")] == [0.9, 0.125]
    assert (decoded(path, "/battery")[0].header.frame_id, decoded(path, "/battery")[0].location) == ("base", "back")
    assert bytes(decoded(path, "/camera")[0].data) == bytes([7]) * 12
    assert profile_of(path) == "ros2"
    offered = {
        topic: yaml.safe_load(reported["offered_qos_profiles"]) for topic, reported in robots_channels(path).items()
    }
    assert set(offered) == {"/battery", "/camera"}, "all that are no topics of the mission's own are in CDR"
    for (one,) in offered.values():
        assert (one["reliability"], one["durability"], one["liveliness"]) == ("reliable", "volatile", "automatic")
        assert set(one) == OF_A_BAG and one["deadline"] == {"sec": 9223372036, "nsec": 854775807}
    with journal_of(path) as replayed:
        again = replay(replayed.path)
        assert again.holds and again.outcome == "aborted"


@pytest.mark.parametrize(
    "type_name",
    ["std_msgs/msg/Empty", "geometry_msgs/msg/PoseStamped", "nav_msgs/msg/OccupancyGrid", "test_msgs/msg/Nested",
     "visualization_msgs/msg/MarkerArray", "test_msgs/msg/BoundedSequences", "diagnostic_msgs/msg/DiagnosticArray"],
)  # fmt: skip
def test_a_definition_is_all_that_others_need_to_read_a_message(type_name: str) -> None:
    from mcap_ros2._dynamic import generate_dynamic
    from rclpy.serialization import serialize_message

    from rai_missions.connectors.ros2.msg_definitions import definition_of
    from rai_missions.connectors.ros2.names import find_type

    decoders = generate_dynamic(type_name, definition_of(type_name))
    message = find_type(type_name, "msg")()
    read = decoders[type_name](serialize_message(message))
    for name in message.get_fields_and_field_types():
        if name != "structure_needs_at_least_one_member":
            assert hasattr(read, name)


def test_a_type_without_its_definition_is_kept_as_plain_data(
    tmp_path: Path, open_ros: Callable[..., Any], monkeypatch: pytest.MonkeyPatch
) -> None:
    from rai_missions.errors import ConnectorError
    from rai_missions.recording import RecordedConnector, Recording

    sender, receiver, received = open_ros(), open_ros(), threading.Event()

    def nowhere(type_name: str) -> str:
        raise ConnectorError("not on this machine")

    monkeypatch.setattr(receiver, "definition", nowhere)
    made = Recording.create(tmp_path / "run.mcap", mission=LAMP, about={}, now=lambda: 0.0)
    RecordedConnector(receiver, made).subscribe("/speech", "std_msgs/msg/String", lambda message: received.set())
    sender.publish("/speech", "std_msgs/msg/String", {"data": "hello"})
    assert received.wait(PATIENCE_S)
    made.close()
    assert kept(tmp_path / "run.mcap").messages["/speech"] == [{"data": "hello"}]
