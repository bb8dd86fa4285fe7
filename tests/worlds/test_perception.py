# SPDX-License-Identifier: Apache-2.0
"""Objects from a camera: boxes become points on the map, looks are counted, and nothing else is reported."""

from __future__ import annotations

import itertools
import json
import math
from collections.abc import Mapping
from functools import partial
from typing import Any

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.connectors.connector import Message
from rai_missions.connectors.local import LocalConnector
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.worlds import messages
from rai_missions.worlds.perception.__main__ import read_config
from rai_missions.worlds.perception.detections import (
    CLASSIFY,
    Box2D,
    ObjectDetection,
    array_message,
    classes_of,
    detections_of,
)
from rai_missions.worlds.perception.finder import FinderConfig, ObjectFinder
from rai_missions.worlds.perception.looks import Looks, Sighting
from rai_missions.worlds.perception.projection import Lens, MapPoint, Mount, Robot2D, depth_of, lens_of, locate

LENS = Lens(80.0, 80.0, 64.0, 48.0)
WIDTH, HEIGHT = 128, 96
metres = st.floats(-8, 8, allow_nan=False)
sizes = st.floats(1, 50)
boxes = st.builds(lambda x, y, w, h: Box2D(x, y, x + w, y + h), metres, metres, sizes, sizes)
detections = st.builds(ObjectDetection, st.sampled_from(["cup", "red cup", "ball"]), st.floats(0, 1), boxes)


@given(
    robot=st.builds(Robot2D, metres, metres, st.floats(-math.pi, math.pi)),
    pitch=st.floats(-0.3, 0.3), away=st.floats(0.5, 6), u=st.floats(20, 108), v=st.floats(20, 76),
)  # fmt: skip
def test_a_point_that_the_camera_sees_is_put_where_it_is(
    robot: Robot2D, pitch: float, away: float, u: float, v: float
) -> None:
    mount = Mount(0.14, 0.2, pitch)
    depth = np.full((HEIGHT, WIDTH), away, np.float32)
    point = locate(Box2D(u - 3, v - 3, u + 3, v + 3), depth, LENS, mount, robot)
    assert point is not None
    assert _pixel(point, mount, robot) == pytest.approx((u, v, away), abs=1e-3)


def _pixel(point: MapPoint, mount: Mount, robot: Robot2D) -> tuple[float, float, float]:
    """Where a point of the map is in the picture, and how deep: the other way round, by rotation matrices."""
    yaw, pitch = robot.yaw, mount.pitch
    base = np.array([[math.cos(yaw), -math.sin(yaw), 0], [math.sin(yaw), math.cos(yaw), 0], [0, 0, 1]])
    camera = np.array([robot.x, robot.y, 0]) + base @ [mount.x, 0, mount.height]
    tilt = np.array([[math.cos(pitch), 0, -math.sin(pitch)], [0, 1, 0], [math.sin(pitch), 0, math.cos(pitch)]])
    forward, left, up = (base @ tilt).T @ (np.array(point[:3]) - camera)
    return LENS.cx - LENS.fx * left / forward, LENS.cy - LENS.fy * up / forward, forward


@given(st.lists(detections, max_size=5))
def test_detections_are_read_as_they_were_written(given_: list[ObjectDetection]) -> None:
    message = array_message(given_, ["cup"], messages.header(1.0, "camera"))
    for read, written in zip(detections_of(json.loads(json.dumps(message))), given_, strict=True):
        assert read.name == written.name and read.score == written.score
        assert read.box == pytest.approx(written.box, abs=1e-9)


@pytest.mark.parametrize(
    "broken",
    [
        None, [], {"detections": None}, {"detections": 3}, {"detections": [3]}, {"detections": [{"results": []}]},
        {"detections": [{"results": [{"hypothesis": {"class_id": "", "score": 1}}], "bbox": {}}]},
        array_message([ObjectDetection("cup", math.nan, Box2D(0, 0, 1, 1))], [], {}),
        array_message([ObjectDetection("cup", 0.5, Box2D(3, 3, 3, 9))], [], {}),
        array_message([ObjectDetection("cup", 10**400, Box2D(3, 3, 4, 9))], [], {}),
    ],
)  # fmt: skip
def test_what_is_no_detection_is_left_out(broken: Any) -> None:
    assert detections_of(broken) == []


def test_names_are_separated_by_commas_as_upstream_sends_them() -> None:
    assert classes_of("cup , red ball,,") == ["cup", "red ball"]


@pytest.mark.parametrize(
    ("encoding", "kind", "scale"), [("16UC1", "<u2", 1000), ("32FC1", "<f4", 1), ("32FC1", ">f4", 1)]
)
def test_depth_is_read_in_metres_with_its_padding(encoding: str, kind: str, scale: int) -> None:
    raw = np.zeros((2, 4), kind)
    raw[:, :3] = np.array([[1.5, 2, 0], [3, 0.25, 4]]) * scale
    message = {
        "encoding": encoding, "width": 3, "height": 2, "step": raw.strides[0], "is_bigendian": kind[0] == ">",
        "data": raw.tobytes(),
    }  # fmt: skip
    depth = depth_of(message)
    assert depth is not None and depth.ravel().tolist() == pytest.approx([1.5, 2, 0, 3, 0.25, 4])
    assert depth_of({**message, "encoding": "rgb8"}) is None and depth_of({**message, "data": b"12"}) is None


def test_a_box_without_depth_has_no_place_and_a_camera_without_calibration_no_lens() -> None:
    empty = np.zeros((HEIGHT, WIDTH), np.float32)
    assert locate(Box2D(10, 10, 30, 30), empty, LENS, Mount(), Robot2D(0, 0, 0)) is None
    assert lens_of({"k": [0.0] * 9}) is None and lens_of({}) is None
    assert lens_of({"k": [80, 0, 64, 0, 80, 48, 0, 0, 1]}) == LENS


@given(agreeing=st.integers(1, 8), more=st.integers(0, 7), order=st.randoms(use_true_random=False))
def test_certainty_counts_agreeing_looks_in_any_order_and_is_never_whole(agreeing: int, more: int, order: Any) -> None:
    count = min(8 - agreeing, more)
    earlier = [True] * (agreeing - 1) + [False] * count
    order.shuffle(earlier)
    looks = Looks()
    for has in (*earlier, True):
        looks.add([Sighting("cup", MapPoint(1, 1, 0.7, 1.5), 0.6)] if has else [])
    [seen] = looks.seen()
    assert (seen.agreeing, seen.looks) == (agreeing, agreeing + count)
    assert seen.certainty == (agreeing + 1) / (agreeing + count + 2) < 1


def test_two_things_of_one_kind_are_two_and_what_the_newest_look_lacks_is_not_seen() -> None:
    looks = Looks()
    near, far = MapPoint(1, 1, 0.7, 1.5), MapPoint(2, 1, 0.7, 2.0)
    for places in ((near, far), (near,)):
        looks.add(Sighting("cup", place, 0.6) for place in places)
    assert [(one.place[:2], one.agreeing) for one in looks.seen()] == [((1, 1), 2)]
    looks.add([])
    assert looks.seen() == []


def _keep(facts: list[Any], message: Message) -> None:
    facts.append(json.loads(message.data["data"]))


class Scene:
    """A robot with a camera on a connector, and a detector that answers as upstream's do."""

    def __init__(self) -> None:
        self.at = 0.0
        self.connector = LocalConnector(now=lambda: self.at)
        self.connector.start()
        self.asked: list[Mapping[str, Any]] = []
        self.answer: Any = [ObjectDetection("cup", 0.7, Box2D(60, 44, 68, 52))]
        self.facts: dict[str, list[Any]] = {"/sighting": [], "/seen": []}
        for topic, facts in self.facts.items():
            self.connector.subscribe(topic, "", partial(_keep, facts))
        self.connector.serve(CLASSIFY[0][0], CLASSIFY[1], self.classify)
        config = FinderConfig(rooms={"kitchen": (0, -5, 9, 5)}, furniture={"table": (1.5, -1, 2.5, 1)})
        self.closes = ObjectFinder(config).open(self.connector)

    def classify(self, request: Mapping[str, Any]) -> dict[str, Any]:
        self.asked.append(request)
        if isinstance(self.answer, Exception):
            raise self.answer
        return {"detections": array_message(self.answer, [], request["source_img"]["header"])}

    def look_for(self, names: str) -> None:
        self.connector.publish("/look_for", "std_msgs/msg/String", {"data": names})

    def live(self, looks: int = 1, yaw_step: float = 0.0, depth_late_s: float = 0.0) -> None:
        """Half a second a look: poses, the lens, a depth and a picture."""
        for _ in range(looks):
            for _ in range(3):
                self.at += 0.2
                turn = yaw_step * self.at
                self.connector.publish("/amcl_pose", "", messages.pose_stamped(0.0, 0.0, turn, self.at))
            header = messages.header(self.at, "camera")
            k = [LENS.fx, 0, LENS.cx, 0, LENS.fy, LENS.cy, 0, 0, 1]
            self.connector.publish("/camera/color/camera_info", "", {"header": header, "k": k})
            depth = np.full((HEIGHT, WIDTH), 1800, "<u2").tobytes()
            size = {"width": WIDTH, "height": HEIGHT}
            late = messages.header(self.at - depth_late_s, "camera")
            picture = {"header": header, **size, "encoding": "rgb8", "step": WIDTH * 3, "data": b""}
            self.connector.publish(
                "/camera/depth/image_raw",
                "",
                {"header": late, **size, "encoding": "16UC1", "step": WIDTH * 2, "data": depth},
            )
            self.connector.publish("/camera/color/image_raw", "", picture)


def test_a_finder_asks_while_something_is_looked_for_and_counts_what_agrees() -> None:
    scene = Scene()
    scene.live(2)
    assert scene.asked == [], "nothing is looked for"
    scene.look_for("cup, ball")
    scene.live(3)
    assert [one["classes"] for one in scene.asked] == ["cup, ball"] * 3
    sighting = scene.facts["/sighting"][-1]
    assert {name: sighting[name] for name in ("object", "agreeing", "looks", "certainty", "room", "on")} == {
        "object": "cup",
        "agreeing": 3,
        "looks": 3,
        "certainty": 0.8,
        "room": "kitchen",
        "on": "floor",
    }
    assert (sighting["x"], sighting["y"], sighting["distance_m"]) == pytest.approx((1.94, 0.0, 1.8), abs=0.02)
    scene.look_for("")
    scene.live(2)
    assert len(scene.asked) == 3


def test_what_was_seen_before_is_not_reported_again() -> None:
    scene = Scene()
    scene.look_for("cup")
    scene.live(3)
    scene.answer = []
    scene.live(4)
    assert len(scene.facts["/sighting"]) == 3
    counts = [(one["looks"], one["count"]) for one in scene.facts["/seen"]]
    assert counts == [(1, 1), (2, 1), (3, 1), (4, 1), (5, 1), (6, 1), (7, 0)], "three of six agree, not three of seven"


def test_one_look_of_several_is_a_sighting_and_no_agreement() -> None:
    scene = Scene()
    scene.answer = []
    scene.look_for("cup")
    scene.live(3)
    scene.answer = [ObjectDetection("cup", 0.7, Box2D(60, 44, 68, 52))]
    scene.live(1)
    assert scene.facts["/sighting"][-1]["certainty"] == 0.33
    assert (
        scene.facts["/seen"][-1]["objects"] == [] and scene.facts["/seen"][-1]["text"] == "nothing that is looked for"
    )


def test_a_look_while_the_robot_turns_counts_for_nothing() -> None:
    scene = Scene()
    scene.look_for("cup")
    scene.live(3, yaw_step=0.5)
    assert scene.asked == [] and scene.facts["/seen"] == []
    scene.live(2)
    assert [one["looks"] for one in scene.facts["/seen"]] == [1, 2], "they count from when it is still"


def test_a_picture_and_a_depth_of_two_moments_are_not_put_together() -> None:
    scene = Scene()
    scene.look_for("cup")
    scene.live(3, depth_late_s=0.1)
    assert scene.asked == []


def test_names_that_were_not_asked_for_and_what_is_out_of_range_are_no_sightings() -> None:
    scene = Scene()
    scene.answer = [ObjectDetection("gold", 0.9, Box2D(60, 44, 68, 52))]
    scene.look_for("cup")
    scene.live(2)
    assert scene.facts["/sighting"] == []


def test_a_detector_that_fails_is_no_look_and_is_named_once(caplog: pytest.LogCaptureFixture) -> None:
    scene = Scene()
    scene.answer = ConnectorError("the detector is down")
    scene.look_for("cup")
    scene.live(5)
    assert len(scene.asked) == 2, "it is left alone for a while"
    assert scene.facts == {"/sighting": [], "/seen": []}
    named = "the detector /grounding_dino_classify gives no answer: ConnectorError: the detector is down"
    assert [record.getMessage() for record in caplog.records].count(named) == 1
    scene.answer = []
    scene.live(4)
    assert [one["looks"] for one in scene.facts["/seen"]] == [1]


def test_a_closed_finder_asks_no_more() -> None:
    scene = Scene()
    scene.look_for("cup")
    for close in scene.closes:
        close()
    scene.live(2)
    assert scene.asked == []


def test_a_flood_of_names_is_cut() -> None:
    scene = Scene()
    scene.look_for(", ".join([*(f"thing {n}" for n in range(50)), "x" * 500]))
    scene.live(1)
    assert len(classes_of(scene.asked[0]["classes"])) == 20


@pytest.mark.parametrize(
    ("content", "why"),
    [
        ('{"camra": "/c"}', "no field 'camra'; did you mean 'camera'?"),
        ('{"mount": {"hight": 1}}', "mount takes x, height, pitch"),
        ("[]", "give an object with the fields camera"),
        ("{", "is no JSON: Expecting property name"),
        ('{"detector": 5}', "detector takes text, not 5"),
        ('{"range_m": "far"}', "range_m takes a number, not 'far'"),
        ('{"range_m": true}', "range_m takes a number, not true"),
        ('{"rooms": ["hall"]}', 'rooms takes an object, not ["hall"]'),
    ],
)
def test_a_configuration_that_is_wrong_is_reported(tmp_path: Any, content: str, why: str) -> None:
    file = tmp_path / "robot.json"
    file.write_text(content)
    with pytest.raises(UsageError) as error:
        read_config(str(file))
    assert why in str(error.value)


def test_a_configuration_names_a_robots_topics(tmp_path: Any) -> None:
    file = tmp_path / "robot.json"
    file.write_text('{"camera": "/rgb", "mount": {"height": 0.5}, "detector": "/detection"}')
    config = read_config(str(file))
    assert (config.camera, config.mount.height, config.detector) == ("/rgb", 0.5, "/detection")
    assert list(itertools.islice(config.rooms, 1)) == []
