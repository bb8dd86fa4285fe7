# SPDX-License-Identifier: Apache-2.0
"""Types by name, and messages from plain data and back: what fits arrives as it was, what does not names its field."""

from __future__ import annotations

import math
import struct
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.field_types import FieldType, field_type
from rai_missions.connectors.ros2.messages import goal_id_from_bytes, goal_id_to_bytes, to_data, to_message
from rai_missions.connectors.ros2.names import find_type
from rai_missions.errors import ConnectorError
from rai_missions.image import Image
from rai_missions.profile import plain
from rai_missions.profile.convert import image_of

BOUNDS = {"boolean": None, "octet": (0, 255), "float": None, "double": None}
INTEGERS = {f"{sign}int{bits}": bits for sign in ("", "u") for bits in (8, 16, 32, 64)}


def values(kind: FieldType) -> st.SearchStrategy[Any]:
    """Plain data that a field takes, as `to_data` gives it back."""
    one = single(kind)
    if not kind.is_list:
        return one
    least, most = (kind.count, kind.count) if kind.count is not None else (0, min(kind.most or 4, 4))
    if kind.name in ("uint8", "octet"):
        return st.binary(min_size=least, max_size=most)
    return st.lists(one, min_size=least, max_size=most)


def single(kind: FieldType) -> st.SearchStrategy[Any]:
    if kind.name in INTEGERS:
        bits = INTEGERS[kind.name]
        if kind.name.startswith("u"):
            return st.integers(0, 2**bits - 1)
        return st.integers(-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    if kind.name in ("float", "double"):
        most = 2.0**127 if kind.name == "float" else None
        return st.floats(most and -most, most, width=32 if kind.name == "float" else 64, allow_nan=False)
    if kind.name == "boolean":
        return st.booleans()
    if kind.name == "octet":
        return st.integers(0, 255)
    if kind.name == "string":
        return st.text(st.characters(codec="ascii", min_codepoint=1), max_size=min(kind.longest or 8, 8))
    return messages(kind.name)


def messages(name: str) -> st.SearchStrategy[dict[str, Any]]:
    results = find_type(name, "msg").get_fields_and_field_types()
    known = {
        field: field_type(reported) for field, reported in results.items() if not field.startswith("structure_needs")
    }
    return st.fixed_dictionaries({field: values(kind) for field, kind in known.items()})


@pytest.mark.parametrize(
    "name",
    [
        "test_msgs/msg/Arrays", "test_msgs/msg/BoundedSequences", "test_msgs/msg/UnboundedSequences",
        "test_msgs/msg/BasicTypes", "test_msgs/msg/Strings", "test_msgs/msg/WStrings", "test_msgs/msg/Nested",
        "test_msgs/msg/Empty", "nav_msgs/msg/Odometry", "sensor_msgs/msg/LaserScan",
        "diagnostic_msgs/msg/DiagnosticArray",
    ],
)  # fmt: skip
@given(data=st.data())
def test_what_goes_in_comes_out(name: str, data: st.DataObject) -> None:
    reported = data.draw(messages(name))
    cls = find_type(name, "msg")
    message = to_message(cls, reported)
    assert to_data(message) == reported
    assert to_message(cls, to_data(message)) == message


@given(st.one_of(st.uuids().map(lambda made: made.hex), st.from_regex(r"[A-Za-z0-9_.:/-]{1,15}", fullmatch=True)))
def test_a_goal_id_is_the_same_on_the_other_side(goal_id: str) -> None:
    assert len(goal_id_to_bytes(goal_id)) == 16
    assert goal_id_from_bytes(goal_id_to_bytes(goal_id)) == goal_id


def test_a_goal_id_that_ros_cannot_carry_is_carried_as_one_that_it_can() -> None:
    assert goal_id_from_bytes(goal_id_to_bytes("a run / driving / 1")) == goal_id_to_bytes("a run / driving / 1").hex()
    assert goal_id_to_bytes("a run / driving / 1") != goal_id_to_bytes("a run / driving / 2")


@pytest.mark.parametrize(
    ("name", "kind", "sentence"),
    [
        ("nav3_msgs/msg/Odometry", "msg", "no ROS package 'nav3_msgs' on this machine; did you mean 'nav_msgs'?"),
        ("my_robot/msg/X", "msg",
         "no ROS package 'my_robot' on this machine; source the workspace that has it, or install it"),
        ("std_msgs/msg/Strin", "msg", "std_msgs has no message type 'Strin'; did you mean 'String'?"),
        ("std_msgs/String", "msg",
         "'std_msgs/String' is no name of a message type; one looks like 'std_msgs/msg/String'"),
        ("std_msgs/msg/String", "srv",
         "'std_msgs/msg/String' is no name of a service type; one looks like 'std_srvs/srv/Trigger'"),
        ("", "msg", "the type of the message is missing; one looks like 'std_msgs/msg/String'"),
        ("std_srvs/action/Trigger", "action", "the package 'std_srvs' has no action types"),
        ("os/msg/../x", "msg", "'os/msg/../x' is no name of a message type; one looks like 'std_msgs/msg/String'"),
    ],
)  # fmt: skip
def test_a_type_that_is_not_here_is_reported_with_what_is(name: str, kind: Any, sentence: str) -> None:
    with pytest.raises(ConnectorError) as caught:
        find_type(name, kind)
    assert str(caught.value) == sentence


@pytest.mark.parametrize(
    ("name", "reported", "sentence"),
    [
        ("std_msgs/msg/String", {"dta": "x"}, "/t/dta: std_msgs/msg/String has no such field; did you mean 'data'?"),
        ("std_msgs/msg/String", {"data": 1}, "/t/data: 1 is given where text belongs"),
        ("std_msgs/msg/String", {"data": "a\0b"}, "/t/data: character 1 is NUL, which no message carries"),
        ("std_msgs/msg/String", {"data": "\ud800"}, "/t/data: character 0 is half a surrogate pair, which is no text"),
        ("std_msgs/msg/String", "x", "/t: 'x' is given where the fields of a message belong"),
        ("std_msgs/msg/Bool", {"data": 1}, "/t/data: 1 is neither true nor false"),
        ("std_msgs/msg/Int32", {"data": True}, "/t/data: true is no whole number, as int32 asks"),
        ("std_msgs/msg/Int32", {"data": 1.5}, "/t/data: 1.5 is no whole number, as int32 asks"),
        ("std_msgs/msg/Int8", {"data": 200}, "/t/data: 200 is outside of int8, which goes from -128 to 127"),
        ("std_msgs/msg/Float32", {"data": 1e300}, "/t/data: 1e+300 is too great for a float"),
        ("std_msgs/msg/Float64", {"data": 10**400}, "/t/data: 1%s… is too great for a double" % ("0" * 58)),
        ("std_msgs/msg/Float64", {"data": "1"}, "/t/data: '1' is no number, as double asks"),
        ("std_msgs/msg/Header", {"stamp": math.nan}, "/t/stamp: nan is no time in seconds"),
        ("sensor_msgs/msg/LaserScan", {"ranges": [1, "x"]}, "/t/ranges/1: 'x' is no number, as float asks"),
        ("sensor_msgs/msg/LaserScan", {"ranges": 3}, "/t/ranges: 3 is given where a list of float belongs"),
        ("sensor_msgs/msg/Imu", {"orientation_covariance": [0.0]},
         "/t/orientation_covariance: 1 items; there are always 9"),
        ("test_msgs/msg/BoundedSequences", {"int8_values": [1, 2, 3, 4]},
         "/t/int8_values: 4 items; there are 3 at the most"),
        ("geometry_msgs/msg/PoseStamped", {"pose": {"position": {"x": None, "w": 1}}},
         "/t/pose/position/w: geometry_msgs/msg/Point has no such field; there is: x, y, z"),
    ],
)  # fmt: skip
def test_a_value_that_does_not_fit_names_its_field(name: str, reported: Any, sentence: str) -> None:
    with pytest.raises(ConnectorError) as caught:
        to_message(find_type(name, "msg"), reported, "/t")
    assert str(caught.value) == sentence


def test_seconds_are_taken_as_a_time_and_what_is_left_out_keeps_its_default() -> None:
    message = to_message(find_type("std_msgs/msg/Header", "msg"), {"stamp": 12.25, "frame_id": None})
    assert to_data(message) == {"stamp": {"sec": 12, "nanosec": 250_000_000}, "frame_id": ""}


def test_whole_floats_are_integers_and_infinite_ranges_are_numbers() -> None:
    assert to_message(find_type("std_msgs/msg/Int32", "msg"), {"data": 3.0}).data == 3
    assert math.isinf(to_message(find_type("std_msgs/msg/Float32", "msg"), {"data": math.inf}).data)


def test_the_greatest_float_is_sent_although_rclpy_thinks_it_too_great() -> None:
    greatest = 3.4028234663852886e38
    message = to_message(find_type("std_msgs/msg/Float32", "msg"), {"data": greatest})
    assert struct.unpack("f", struct.pack("f", message.data)) == (greatest,)


RAW, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
PIXELS = bytes(range(12))


def sent(name: str, reported: Any) -> dict[str, Any]:
    return to_data(to_message(find_type(name, "msg"), reported, "/camera"), "/camera@1.000")


def test_a_picture_arrives_as_a_picture() -> None:
    message = {
        "height": 2,
        "width": 2,
        "encoding": "rgb8",
        "step": 6,
        "data": Image("cam", 2, 2, "rgb8", lambda: PIXELS),
    }
    for reported in (message, message["data"]):
        received = sent(RAW, reported)
        assert (received["data"].ref, received["data"].data, received["step"]) == ("/camera@1.000", PIXELS, 6)
        assert image_of(received, "x") is received["data"], "the profile takes it as it is"


@pytest.mark.parametrize(
    ("encoding", "channels", "row", "rgb"),
    [
        ("bgr8", 3, b"\1\2\3\4\5\6", b"\3\2\1\6\5\4"),
        ("mono8", 1, b"\1\2", b"\1\1\1\2\2\2"),
        ("rgb8", 3, b"\1\2\3\4\5\6", b"\1\2\3\4\5\6"),
    ],
)
def test_pixels_of_any_order_and_padding_become_rgb(encoding: str, channels: int, row: bytes, rgb: bytes) -> None:
    padded = {"height": 2, "width": 2, "encoding": encoding, "step": 2 * channels + 3, "data": (row + b"pad") * 2}
    assert sent(RAW, padded)["data"].data == rgb * 2


def test_depth_and_broken_pictures_stay_bytes() -> None:
    assert sent(RAW, {"height": 1, "width": 2, "encoding": "16UC1", "step": 4, "data": b"abcd"})["data"] == b"abcd"
    assert sent(RAW, {"height": 9, "width": 9, "encoding": "rgb8", "step": 27, "data": b"abcd"})["data"] == b"abcd"


def test_an_encoded_picture_travels_compressed() -> None:
    png = Image("p", 2, 2, "png", b"\x89PNG")
    assert (sent(COMPRESSED, png)["data"].encoding, sent(COMPRESSED, png)["data"].data) == ("png", b"\x89PNG")
    with pytest.raises(ConnectorError, match="/camera: a picture in 'png' travels as sensor_msgs/msg/CompressedImage"):
        sent(RAW, png)


def test_an_enormous_picture_is_no_slower_than_its_bytes() -> None:
    frame = {"height": 2000, "width": 3000, "encoding": "rgb8", "step": 9000, "data": bytes(18_000_000)}
    assert len(sent(RAW, frame)["data"].data) == 18_000_000


@given(st.deferred(lambda: messages("nav_msgs/msg/Odometry")))
def test_what_is_received_can_be_journaled(data: dict[str, Any]) -> None:
    plain(to_data(to_message(find_type("nav_msgs/msg/Odometry", "msg"), data)))
