# SPDX-License-Identifier: Apache-2.0
"""Messages become values of the blackboard, or state why not; nothing a robot sends breaks the engine."""

from __future__ import annotations

import enum
import math
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.journal import decode, encode
from rai_missions.plain_data import at_path
from rai_missions.profile import EventSource, Source, plain
from rai_missions.profile.convert import image_of, pose_message, pose_of

coordinates = st.floats(-1e6, 1e6)
HUGE = [10**305, -(10**400)]
anything = st.recursive(
    st.none()
    | st.booleans()
    | st.integers()
    | st.sampled_from(HUGE)
    | st.floats()
    | st.text(max_size=5)
    | st.binary(max_size=5),
    lambda inner: (
        st.lists(inner, max_size=3)
        | st.dictionaries(
            st.text(max_size=3)
            | st.sampled_from(["data", "header", "stamp", "pose", "position", "orientation", "x", "w", "width"]),
            inner,
            max_size=4,
        )
    ),
    max_leaves=12,
)
SOURCES = [
    Source(topic="/t"),
    Source(topic="/t", type="geometry_msgs/msg/PoseStamped"),
    Source(topic="/t", type="sensor_msgs/msg/Image"),
    Source(topic="/t", type="std_msgs/msg/String", json=True),
    Source(topic="/t", field="data.0"),
]


def written(value: Any) -> Any:
    """A value after it went through the journal."""
    return decode(encode(Step(1, 0.0, Event("x", 0.0, {"it": value})))).event.data["it"]


@given(
    x=coordinates, y=coordinates, z=coordinates, yaw=st.floats(-math.pi, math.pi), frame=st.sampled_from(["", "map"])
)
def test_a_pose_that_is_sent_is_the_pose_that_is_received(x: float, y: float, z: float, yaw: float, frame: str) -> None:
    sent = {"x": x, "y": y, "z": z, "yaw": yaw, "frame": frame}
    received = pose_of(pose_message(sent))
    assert received is not None
    assert received == {**sent, "yaw": received["yaw"]}
    assert math.isclose(math.remainder(received["yaw"] - yaw, math.tau), 0.0, abs_tol=1e-9)


@given(roll=st.floats(-1.5, 1.5), pitch=st.floats(-1.5, 1.5), yaw=st.floats(-3.1, 3.1))
def test_the_heading_of_a_robot_on_a_slope_is_its_yaw(roll: float, pitch: float, yaw: float) -> None:
    (cr, sr), (cp, sp), (cy, sy) = ((math.cos(angle / 2), math.sin(angle / 2)) for angle in (roll, pitch, yaw))
    turn = {
        "w": cr * cp * cy + sr * sp * sy,
        "x": sr * cp * cy - cr * sp * sy,
        "y": cr * sp * cy + sr * cp * sy,
        "z": cr * cp * sy - sr * sp * cy,
    }
    received = pose_of({"position": {"x": 0.0, "y": 0.0}, "orientation": turn})
    assert received is not None
    assert math.isclose(received["yaw"], yaw, abs_tol=1e-6)


@given(anything.filter(lambda message: isinstance(message, dict)))
def test_whatever_is_received_can_be_written_down_or_is_refused(message: dict[str, Any]) -> None:
    for source in SOURCES:
        try:
            value = source.value(message)
        except ConnectorError:
            continue
        assert written(value) == value


@pytest.mark.parametrize(
    ("message", "text"),
    [
        ({"data": "not json"}, "is no JSON: Expecting value"),
        ({"data": "[" * 100_000}, "nested"),
        ({"data": "[" * 70 + "]" * 70}, "nested deeper than 60"),
        ({"data": "1" * 2_000_000}, "2000000 characters; at most 1000000 are read"),
        ({"data": "1" * 5000}, "is no JSON"),
        ({"data": 3}, "3 is given where JSON text belongs"),
        ({}, "None is given where JSON text belongs"),
    ],
)
def test_hostile_json_is_refused(message: dict[str, Any], text: str) -> None:
    with pytest.raises(ConnectorError, match=text):
        Source(topic="/t", type="std_msgs/msg/String", json=True).value(message)


@pytest.mark.parametrize(
    ("source", "message", "value"),
    [
        (Source(topic="/t", type="sensor_msgs/msg/BatteryState", field="percentage"), {"percentage": 0.5}, 0.5),
        (Source(topic="/t", type="sensor_msgs/msg/BatteryState", field="percentage"), {"percentage": math.nan}, None),
        (Source(topic="/t", type="sensor_msgs/msg/BatteryState", field="percentage"), {"voltage": 12.0}, None),
        (Source(topic="/t", type="std_msgs/msg/Bool"), {"data": True}, True),
        (
            Source(topic="/t", type="std_msgs/msg/String", json=True),
            {"data": '{"height_m": 0.2, "far": Infinity}'},
            {"height_m": 0.2, "far": None},
        ),
        (Source(topic="/t", type="std_msgs/msg/String", json=True, field="text"), {"text": "[1]"}, [1]),
        (
            Source(topic="/t", type="sensor_msgs/msg/LaserScan", field="ranges"),
            {"ranges": (1.0, math.inf)},
            [1.0, None],
        ),
        (Source(topic="/t", field="ranges.1"), {"ranges": [1.0, 2.0]}, 2.0),
        (Source(topic="/t"), {"a": {"b": (1, 2)}}, {"a": {"b": [1, 2]}}),
        (
            Source.model_validate({"topic": "/t", "field": "pose.pose", "as": "pose"}),
            {
                "header": {"frame_id": "odom"},
                "pose": {"pose": {"position": {"x": 1, "y": 2}, "orientation": {"w": 1.0}}},
            },
            {"x": 1.0, "y": 2.0, "z": 0.0, "yaw": 0.0, "frame": "odom"},
        ),
        (
            Source(topic="/t", type="nav_msgs/msg/Odometry"),
            {
                "header": {"frame_id": "odom"},
                "pose": {"pose": {"position": {"x": 1, "y": math.nan}, "orientation": {}}},
            },
            None,
        ),
    ],
)
def test_a_source_reports_which_part_of_a_message_counts(source: Source, message: dict[str, Any], value: Any) -> None:
    assert source.value(message) == value


def test_numbers_of_numpy_become_plain() -> None:
    numpy = pytest.importorskip("numpy")
    assert plain({"a": numpy.float32(0.5), "b": numpy.arange(3)}) == {"a": 0.5, "b": [0, 1, 2]}


def test_an_integer_beyond_all_floating_point_numbers_is_no_number_to_reckon_with() -> None:
    assert plain({"a": [10**400, -(10**5000), 10**300]}) == {"a": [None, None, 10**300]}


def test_a_number_that_is_not_finite_is_none_at_its_place() -> None:
    scan = [0.5, math.inf, 1.5, -math.inf, math.nan, True, 2]
    assert plain({"ranges": scan}) == {"ranges": [0.5, None, 1.5, None, None, True, 2]}


def test_words_of_enumerations_and_of_numpy_become_text() -> None:
    numpy = pytest.importorskip("numpy")
    way = enum.Enum("Way", {"LEFT": "left"}, type=str)
    made = plain({way.LEFT: [way.LEFT, numpy.str_("right")]})
    assert made == {"left": ["left", "right"]}
    assert {type(text) for text in (*made, *made["left"])} == {str}


@pytest.mark.parametrize("given", [b"x", [b"x"]])
def test_bytes_are_no_plain_data(given: Any) -> None:
    with pytest.raises(ConnectorError, match=r"b'x' \(bytes\) is no plain data; name the 'field' that is meant"):
        plain(given)


@pytest.mark.parametrize("unheld", [b"x", bytearray(b"x"), memoryview(b"x")])
def test_a_field_of_bytes_is_left_out_of_what_a_journal_holds(unheld: Any) -> None:
    message = {"data": unheld, "size": 3, "goals": [{"id": {"uuid": unheld}, "stamp": 2}]}
    assert plain(message) == {"size": 3, "goals": [{"id": {}, "stamp": 2}]}


@pytest.mark.parametrize(
    "message",
    [{}, {"pose": 3}, {"position": {"x": "1", "y": 0}, "orientation": {}}, {"position": {"x": 1}, "orientation": {}}],
)
def test_what_is_no_pose_is_refused(message: dict[str, Any]) -> None:
    with pytest.raises(ConnectorError, match="pose"):
        pose_of(message)


@pytest.mark.parametrize(
    ("encoding", "raw", "rgb"),
    [
        ("rgb8", bytes(range(12)), bytes(range(12))),
        ("bgr8", bytes(range(12)), bytes([2, 1, 0, 5, 4, 3, 8, 7, 6, 11, 10, 9])),
        ("mono8", bytes([7, 8, 9, 1]), bytes([7, 7, 7, 8, 8, 8, 9, 9, 9, 1, 1, 1])),
    ],
)
def test_a_picture_is_read_from_its_bytes(encoding: str, raw: bytes, rgb: bytes) -> None:
    step = len(raw) // 2
    padded = raw[:step] + b"??" + raw[step:] + b"??"
    for data, row in ((raw, step), (list(raw), step), (padded, step + 2)):
        image = image_of({"width": 2, "height": 2, "encoding": encoding, "step": row, "data": data}, "camera@1")
        assert (image.ref, image.width, image.height, image.encoding, image.data) == ("camera@1", 2, 2, "rgb8", rgb)


def test_a_picture_that_is_one_already_is_taken_as_it_is() -> None:
    image = Image("camera@1", 2, 2, "rgb8", lambda: pytest.fail("no one asked for the bytes"))
    source = Source(topic="/camera", type="sensor_msgs/msg/Image")
    assert source.value({"width": 2, "data": image}) is image


def test_a_picture_is_named_by_where_and_when_it_was_received() -> None:
    source = Source(topic="/camera", type="sensor_msgs/msg/CompressedImage")
    image = source.value({"format": "rgb8; jpeg compressed bgr8", "data": b"\xff\xd8"}, at=1.5)
    assert (image.ref, image.encoding, image.data) == ("/camera@1.500", "jpeg", b"\xff\xd8")


@pytest.mark.parametrize(
    "message",
    [
        {"data": "text"}, {"data": b"", "width": 2, "height": 2, "encoding": "rgb8"}, {"data": [300]},
        {"data": bytes(12), "width": 2, "height": 2, "encoding": "32FC1"},
        {"data": bytes(12), "width": 2, "height": 2, "encoding": "rgb8", "step": 3},
        {"data": bytes(12), "width": -2, "height": 2, "encoding": "rgb8"},
    ],
)  # fmt: skip
def test_what_is_no_picture_is_refused(message: dict[str, Any]) -> None:
    with pytest.raises(ConnectorError, match="picture"):
        image_of(message, "camera@1")


def test_an_event_happens_when_its_condition_becomes_true() -> None:
    source = EventSource(topic="/state", type="std_msgs/msg/String", when={"key": "data", "==": "WAITING"})
    reported = ["DRIVING", "WAITING", "WAITING", "DRIVING", "WAITING"]
    before, happened = None, []
    for word in reported:
        now = source.fires({"data": word})
        happened.append(source.happens(before, now))
        before = now
    assert happened == [False, True, False, False, True]


def test_an_event_without_a_condition_happens_with_each_message() -> None:
    source = EventSource(topic="/button")
    assert source.happens(True, source.fires({})) is True


def test_a_condition_on_a_field_that_is_not_there_is_unknown() -> None:
    source = EventSource(topic="/state", when={"key": "event.word", "==": "x"})
    assert source.fires({"data": "x"}) is None
    assert source.fires({"event": {"word": "x"}}) is True


def test_an_event_brings_the_fields_that_are_named() -> None:
    source = EventSource(topic="/t", json=True, fields={"height": "size.h"})
    assert source.payload({"data": '{"size": {"h": 2}}'}) == {"height": 2}
    assert EventSource(topic="/t").payload({"a": 1, "raw": b"x"}) == {"a": 1}
    with pytest.raises(ConnectorError, match="object with fields"):
        source.payload({"data": "[]"})


def test_a_path_that_leads_nowhere_is_none() -> None:
    assert at_path({"a": [1]}, "a.1") is None
    assert at_path({"a": "text"}, "a.b") is None
