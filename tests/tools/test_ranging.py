# SPDX-License-Identifier: Apache-2.0
"""The distance that is reported is the scene's, whatever the camera, the encoding and what is missing; else unknown."""

from __future__ import annotations

import contextlib
import json
import math
import random
import re
import struct
from array import array
from typing import Any, NamedTuple

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from rai_missions.errors import ConnectorError, UsageError
from rai_missions.tools.detections import detections_of
from rai_missions.tools.ranging import PinholeCamera, camera_of, cloud_points, depth_points, ranged
from rai_missions.tools.transforms import Transform
from tests.tools.conftest import PATIENCE_S, RepeatingPublisher, ToolRig
from tests.tools.test_transforms import stamped, turn

Box = tuple[int, int, int, int]
INFO = {"width": 64, "height": 48, "k": [60.0, 0, 31.5, 0, 60.0, 23.5, 0, 0, 1]}
CAMERA = camera_of(INFO)


class Scene(NamedTuple):
    """A flat object that faces the camera, before a wall that is farther away."""

    box: Box
    depth_m: float
    wall_m: float = 40.0

    def depth(self, column: int, row: int) -> float:
        left, top, right, bottom = self.box
        return self.depth_m if left <= column < right and top <= row < bottom else self.wall_m

    def distance_m(self) -> float:
        """To the middle of the object, by hand."""
        left, top, right, bottom = self.box
        u, v = (left + right - 1) / 2, (top + bottom - 1) / 2
        return self.depth_m * math.hypot((u - 31.5) / 60, (v - 23.5) / 60, 1)


@st.composite
def scenes(draw: st.DrawFn) -> Scene:
    width, height = draw(st.integers(8, 40)), draw(st.integers(8, 30))
    left, top = draw(st.integers(0, 64 - width)), draw(st.integers(0, 48 - height))
    return Scene((left, top, left + width, top + height), draw(st.integers(2, 180)) / 10)


def depth_image(
    scene: Scene, encoding: str, *, holes: float = 0.0, big: bool = False, pad: int = 0, seed: int = 0
) -> Any:
    """A sensor_msgs/msg/Image; `holes` is the share of pixels that measured nothing."""
    chance = random.Random(seed)
    code = "H" if encoding == "16UC1" else "f"
    data = b""
    for row in range(48):
        values: list[Any] = []
        for column in range(64):
            depth_m: float = scene.depth(column, row)
            if chance.random() < holes:
                depth_m = 0.0 if code == "H" else chance.choice([math.nan, math.inf, 0.0, -1.0])
            values.append(round(depth_m * 1000) if code == "H" else depth_m)
        data += struct.pack(f"{'>' if big else '<'}64{code}", *values) + b"\xff" * pad
    step = 64 * struct.calcsize(code) + pad
    return {"width": 64, "height": 48, "encoding": encoding, "step": step, "is_bigendian": int(big), "data": data}


def cloud(points: list[tuple[float, float, float]], width: int, height: int, *, big: bool = False) -> Any:
    """A sensor_msgs/msg/PointCloud2 with a colour between the numbers, as cameras have it."""
    data = b"".join(struct.pack(f"{'>' if big else '<'}ffIf", x, y, 0xFFFFFFFF, z) for x, y, z in points)
    names = (("x", 0, 7), ("y", 4, 7), ("rgb", 8, 6), ("z", 12, 7))
    fields = [{"name": name, "offset": at, "datatype": kind, "count": 1} for name, at, kind in names]
    return {
        "width": width, "height": height, "fields": fields, "point_step": 16, "row_step": 16 * width,
        "is_bigendian": big, "data": data,
    }  # fmt: skip


def scene_cloud(scene: Scene, *, holes: float = 0.0, seed: int = 0) -> list[tuple[float, float, float]]:
    chance = random.Random(seed)
    nothing = (math.nan, math.nan, math.nan)
    return [
        nothing if chance.random() < holes else CAMERA.ray(column, row, scene.depth(column, row))
        for row in range(48)
        for column in range(64)
    ]


# ── Laws ────────────────────────────────────────────────────────────────────────────────────────────────────────


@given(
    scenes(), st.sampled_from(["16UC1", "32FC1"]), st.booleans(), st.sampled_from([0, 2, 8]), st.floats(0, 0.9),
    st.integers(0, 99),
)  # fmt: skip
def test_a_depth_image_notifies_the_distance_of_the_scene(
    scene: Scene, encoding: str, big: bool, pad: int, holes: float, seed: int
) -> None:
    image = depth_image(scene, encoding, big=big, pad=pad, holes=holes, seed=seed)
    found = ranged(*depth_points(image, CAMERA, scene.box))
    if found.distance_m is None:
        assert found.measurements < 20, found.why
    else:
        assert found.distance_m == pytest.approx(scene.distance_m(), rel=0.1)
        assert found.position is not None and found.position[2] == pytest.approx(scene.depth_m, rel=1e-3)


@given(scenes(), st.floats(0, 0.5), st.integers(0, 99), st.booleans())
def test_a_point_cloud_with_rows_and_one_without_report_the_same(
    scene: Scene, holes: float, seed: int, big: bool
) -> None:
    points = scene_cloud(scene, holes=holes, seed=seed)
    rows = ranged(*cloud_points(cloud(points, 64, 48, big=big), None, scene.box))
    loose = points[:]
    random.Random(seed).shuffle(loose)
    flat = ranged(*cloud_points(cloud(loose, len(loose), 1, big=big), CAMERA, scene.box))
    for found in (rows, flat):
        if found.distance_m is None:
            assert found.measurements < 20, found.why
        else:
            assert found.distance_m == pytest.approx(scene.distance_m(), rel=0.05)


@given(scenes(), st.floats(-3, 3), st.tuples(*[st.floats(-2, 2)] * 3))
def test_a_cloud_in_another_frame_is_seen_where_it_lies(
    scene: Scene, angle: float, way: tuple[float, float, float]
) -> None:
    """The lidar that made the cloud is turned and moved against the camera."""
    to_camera = Transform(way, turn((0.3, 1, 0.2), angle))
    away = to_camera.inverse()
    moved = [away.point(point) for point in scene_cloud(scene)]
    found = ranged(*cloud_points(cloud(moved, len(moved), 1), CAMERA, scene.box, to_camera))
    assert found.distance_m == pytest.approx(scene.distance_m(), rel=0.05)


@given(scenes(), st.floats(0.98, 1.0), st.integers(0, 9))
def test_too_few_measurements_are_no_distance(scene: Scene, holes: float, seed: int) -> None:
    image = depth_image(scene, "32FC1", holes=holes, seed=seed)
    samples, looked_at = depth_points(image, CAMERA, scene.box)
    found = ranged(samples, looked_at)
    assert (found.distance_m is None) == (len(samples) < 10 or len(samples) < 0.02 * looked_at)
    if found.distance_m is None:
        assert found.why.startswith(f"only {len(samples)} valid measurements; ")


@given(scenes(), st.integers(1, 19))
def test_what_is_before_a_small_part_of_an_object_does_not_count(scene: Scene, share: int) -> None:
    """A fence of lines of depth 0.1 m before less than half of the object: the median stays with the object."""
    image = depth_image(scene, "32FC1")
    values = array("f", image["data"])
    for row in range(48):
        for column in range(64):
            if (column * 7 + row * 13) % 40 < share:
                values[row * 64 + column] = 0.1
    samples, looked_at = depth_points({**image, "data": values.tobytes()}, CAMERA, scene.box)
    assume(sum(point[2] < 0.15 for _, _, point in samples) < 0.45 * len(samples))  # in a small box it may be most
    found = ranged(samples, looked_at)
    assert found.distance_m == pytest.approx(scene.distance_m(), rel=0.08)


def test_a_depth_image_of_another_size_is_scaled() -> None:
    scene = Scene((16, 12, 48, 36), 4.0)
    large = PinholeCamera(640, 480, 600.0, 600.0, 319.5, 239.5)
    found = ranged(*depth_points(depth_image(scene, "16UC1"), large, (160, 120, 480, 360)))
    assert found.distance_m == pytest.approx(4.0, rel=0.05)
    assert found.position == pytest.approx((0, 0, 4.0), abs=0.1)


@pytest.mark.parametrize("box", [(-50, -50, -10, -10), (100, 100, 120, 120), (70, 0, 90, 10)])
def test_a_box_outside_of_the_picture_is_unknown(box: Box) -> None:
    assert ranged(*depth_points(depth_image(Scene(box, 1.0), "16UC1"), CAMERA, box)).distance_m is None


# ── What is wrong ───────────────────────────────────────────────────────────────────────────────────────────────

GOOD = depth_image(Scene((0, 0, 9, 9), 1.0), "16UC1")


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"encoding": "rgb8"}, "a depth image is in 16UC1, mono16, 32FC1, not in 'rgb8'"),
        ({"data": b"short"}, "needs more than its 5 bytes"),
        ({"width": 10**6, "height": 10**6}, "a depth image of 1000000 × 1000000 pixels"),
        ({"step": 4}, "needs more than"),
        ({"data": "text"}, "is given where bytes belong"),
    ],
)
def test_what_is_no_depth_image_is_reported(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ConnectorError, match=message):
        depth_points({**GOOD, **change}, CAMERA, (0, 0, 9, 9))


@pytest.mark.parametrize(
    ("change", "message"),
    [
        ({"fields": []}, "a point cloud without numbers x, y and z"),
        ({"data": b"short"}, "a point cloud needs more than its 5 bytes"),
        ({"width": 10**9}, "a point cloud of 1000000000 × 1 points"),
    ],
)
def test_what_is_no_cloud_is_reported(change: dict[str, Any], message: str) -> None:
    with pytest.raises(ConnectorError, match=message):
        cloud_points({**cloud([(0, 0, 1)], 1, 1), **change}, CAMERA, (0, 0, 64, 48))
    with pytest.raises(ConnectorError, match="state its camera_info topic"):
        cloud_points(cloud([(0, 0, 1)], 1, 1), None, (0, 0, 64, 48))


@pytest.mark.parametrize("info", [{}, {**INFO, "k": [0.0] * 9}, {**INFO, "k": [1]}, {**INFO, "width": 0}])
def test_a_camera_that_is_not_calibrated_is_refused(info: Any) -> None:
    with pytest.raises(ConnectorError):
        camera_of(info)


VISION = {
    "bbox": {"center": {"position": {"x": 20.0, "y": 10.0}, "theta": 0.0}, "size_x": 8.0, "size_y": 4.0},
    "results": [
        {"hypothesis": {"class_id": "dog", "score": 0.2}}, {"hypothesis": {"class_id": "person", "score": 0.7}},
    ],
}  # fmt: skip


@pytest.mark.parametrize(
    "message",
    [
        {"detections": [VISION]},
        {"data": json.dumps({"detections": [VISION]})},
        {"detections": [{"name": "person", "score": 0.7, "box": [16, 8, 24, 12]}]},
        [{"label": "person", "confidence": 0.7, "x_min": 16, "y_min": 8, "x_max": 24, "y_max": 12}],
    ],
)
def test_detections_are_read_as_detectors_write_them(message: Any) -> None:
    assert detections_of(message) == [("person", 0.7, (16.0, 8.0, 24.0, 12.0))]


@pytest.mark.parametrize(
    "message",
    [
        {},
        {"data": "no JSON"},
        {"detections": [{"name": "x"}]},
        {"detections": [{"box": [5, 0, 1, 1]}]},
        {"detections": [7]},
        {"detections": [{"name": "x", "score": 10**400, "box": [0, 0, 1, 1]}]},
        {"detections": [{"name": "x", "score": float("nan"), "box": [0, 0, 1, 1]}]},
        {"detections": [{"name": "x", "box": [0, 0, 1, 10**400]}]},
    ],
)
def test_what_is_no_detection_is_reported(message: Any) -> None:
    with pytest.raises(ConnectorError):
        detections_of(message)


# ── The tool ────────────────────────────────────────────────────────────────────────────────────────────────────

SCENE = Scene((16, 12, 48, 36), 4.0)
SEEN = {
    "detections": [{"name": "person", "score": 0.9, "box": [16, 12, 48, 36]}, {"name": "dog", "box": [70, 0, 80, 9]}]
}


def sends(tried: ToolRig, topic: str, message: Any, at: float, frame: str = "camera") -> RepeatingPublisher:
    header = {"stamp": at, "frame_id": frame}
    return RepeatingPublisher(tried.connector, topic, "", lambda: {"header": header, **message})


def test_the_tool_reports_each_object_and_what_is_unknown(local: ToolRig) -> None:
    box, now = local.box(), local.now()
    with (
        sends(local, "/seen", SEEN, now),
        sends(local, "/info", INFO, now),
        sends(local, "/depth", depth_image(SCENE, "16UC1"), now),
    ):
        ask = box.measuring.get_distance_to_objects
        wanted = {"depth_topic": "/depth", "camera_info_topic": "/info", "timeout_s": PATIENCE_S, "max_age_s": None}
        reported = ask("/seen", **wanted)
        dogs = ask("/seen", names=["dog"], **wanted)
    person, dog = reported.data["objects"]
    assert (person["name"], person["distance_m"]) == ("person", pytest.approx(4.0, rel=0.05))
    assert (dog["distance_m"], dog["why"]) == (None, "only 0 valid measurements; 10 are needed")
    assert [each["name"] for each in dogs.data["objects"]] == ["dog"]


def test_a_lidars_cloud_is_brought_to_the_camera_by_its_transform(local: ToolRig) -> None:
    box, now = local.box(), local.now()
    to_camera = Transform((0.2, -0.1, 0.3), turn((0, 1, 0), 0.4))
    points = [to_camera.inverse().point(point) for point in scene_cloud(SCENE)]
    static = {"transforms": [stamped("camera", "lidar", to_camera, 0.0)]}
    with (
        sends(local, "/seen", SEEN, now),
        sends(local, "/info", INFO, now),
        sends(local, "/cloud", cloud(points, len(points), 1), now, "lidar"),
        sends(local, "/tf_static", static, now),
    ):
        reported = box.measuring.get_distance_to_objects(
            "/seen", cloud_topic="/cloud", camera_info_topic="/info", timeout_s=PATIENCE_S, max_age_s=None
        )
    box.stop()
    assert reported.data["objects"][0]["distance_m"] == pytest.approx(4.0, rel=0.05)


@pytest.mark.parametrize(
    ("late_s", "old_s", "why"),
    [(0.0, 5.0, r"what was received on /seen is 5\.\d+ s old"), (1.0, 0.0, r"/seen and /depth are 1\.00 s apart")],
)
def test_what_does_not_fit_in_time_is_unknown(local: ToolRig, late_s: float, old_s: float, why: str) -> None:
    now = local.now()
    with (
        sends(local, "/seen", SEEN, now - old_s),
        sends(local, "/info", INFO, now),
        sends(local, "/depth", depth_image(SCENE, "16UC1"), now - old_s - late_s),
    ):
        reported = local.box().measuring.get_distance_to_objects(
            "/seen", depth_topic="/depth", camera_info_topic="/info", timeout_s=0.5, max_age_s=2.0 if old_s else None
        )
    assert reported.data["objects"] == []
    assert re.search(why, reported.words), reported.words


def test_distances_are_measured_over_any_connector(tried: ToolRig) -> None:
    """The messages travel as the robot's own types where it has types."""
    look = {"detections_topic": "/far/seen", "depth_topic": "/far/depth", "camera_info_topic": "/far/info"}
    kinds = {
        "/far/seen": "std_msgs/msg/String",
        "/far/depth": "sensor_msgs/msg/Image",
        "/far/info": "sensor_msgs/msg/CameraInfo",
    }
    now, depth = tried.now(), depth_image(SCENE, "16UC1")
    if "actions" not in tried.connector.modes:
        depth = {**depth, "data": list(depth["data"])}  # JSON has no bytes
    header = {"stamp": {"sec": int(now), "nanosec": 0}, "frame_id": "camera"}
    bodies = {
        "/far/seen": {"data": json.dumps(SEEN)}, "/far/depth": {**depth, "header": header},
        "/far/info": {**INFO, "header": header},
    }  # fmt: skip
    with contextlib.ExitStack() as sayings:
        for topic, body in bodies.items():
            sayings.enter_context(RepeatingPublisher(tried.connector, topic, kinds[topic], lambda body=body: body))  # type: ignore[misc]
        reported = tried.box().measuring.get_distance_to_objects(
            **look, timeout_s=PATIENCE_S, max_age_s=None, max_apart_s=60.0
        )
    assert reported.data["objects"][0]["distance_m"] == pytest.approx(4.0, rel=0.05)


def test_what_is_missing_is_named(local: ToolRig) -> None:
    ask = local.box().measuring.get_distance_to_objects
    assert (
        ask("/seen", cloud_topic="/cloud", timeout_s=0).words
        == "The distances are unknown: nothing was received on /seen."
    )
    with pytest.raises(UsageError, match="state one of depth_topic and cloud_topic"):
        ask("/seen")
    with pytest.raises(UsageError, match="needs its camera_info_topic"):
        ask("/seen", depth_topic="/depth")
