# SPDX-License-Identifier: Apache-2.0
"""Our own definitions of messages: what Jazzy and RAI have, field by field, and packages that any builder can build."""

from __future__ import annotations

import importlib
import re
import shutil
import subprocess
import xml.etree.ElementTree as ET
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

import pytest

INTERFACES = Path(__file__).parents[2] / "interfaces"
PACKAGES = sorted(path.parent for path in INTERFACES.glob("*/package.xml"))
DEFINITIONS = sorted(path for folder in ("msg", "srv", "action") for path in INTERFACES.glob(f"*/{folder}/*.{folder}"))

ELAPSED = {"total_elapsed_time": "builtin_interfaces/Duration", "error_code": "uint16", "error_msg": "string"}
DRIVE = {"target": "geometry_msgs/Point", "speed": "float", "time_allowance": "builtin_interfaces/Duration"}
POSE = "geometry_msgs/PoseStamped"
ON_THE_WAY = {
    "current_pose": POSE,
    "navigation_time": "builtin_interfaces/Duration",
    "estimated_time_remaining": "builtin_interfaces/Duration",
    "number_of_recoveries": "int16",
    "distance_remaining": "float",
}
ERROR = {"error_code": "uint16", "error_msg": "string"}
UPSTREAM: Mapping[str, tuple[Mapping[str, str], ...]] = {
    "nav2_msgs/action/NavigateToPose": ({"pose": POSE, "behavior_tree": "string"}, ERROR, ON_THE_WAY),
    "nav2_msgs/action/NavigateThroughPoses": (
        {"poses": f"sequence<{POSE}>", "behavior_tree": "string"},
        ERROR,
        {**ON_THE_WAY, "number_of_poses_remaining": "int16"},
    ),
    "nav2_msgs/action/DriveOnHeading": (DRIVE, ELAPSED, {"distance_traveled": "float"}),
    "nav2_msgs/action/BackUp": (DRIVE, ELAPSED, {"distance_traveled": "float"}),
    "nav2_msgs/action/Spin": (
        {"target_yaw": "float", "time_allowance": "builtin_interfaces/Duration"},
        ELAPSED,
        {"angular_distance_traveled": "float"},
    ),
    "nav2_msgs/action/Wait": (
        {"time": "builtin_interfaces/Duration"},
        ELAPSED,
        {"time_left": "builtin_interfaces/Duration"},
    ),
    "nav2_msgs/action/DockRobot": (
        {
            "use_dock_id": "boolean",
            "dock_id": "string",
            "dock_pose": POSE,
            "dock_type": "string",
            "max_staging_time": "float",
            "navigate_to_staging_pose": "boolean",
        },
        {"success": "boolean", "error_code": "uint16", "num_retries": "uint16", "error_msg": "string"},
        {"state": "uint16", "docking_time": "builtin_interfaces/Duration", "num_retries": "uint16"},
    ),
    "nav2_msgs/action/UndockRobot": (
        {"dock_type": "string", "max_undocking_time": "float"},
        {"success": "boolean", "error_code": "uint16", "error_msg": "string"},
        {},
    ),
    "rai_interfaces/msg/HRIMessage": (
        {
            "header": "std_msgs/Header",
            "text": "string",
            "images": "sequence<sensor_msgs/Image>",
            "audios": "sequence<rai_interfaces/AudioMessage>",
            "communication_id": "string",
            "seq_no": "int64",
            "seq_end": "boolean",
        },
    ),
    "rai_interfaces/msg/AudioMessage": ({"audio": "sequence<int16>", "sample_rate": "uint16", "channels": "uint16"},),
    "rai_interfaces/msg/RAIDetectionArray": (
        {
            "header": "std_msgs/Header",
            "detections": "sequence<vision_msgs/Detection2D>",
            "detection_classes": "sequence<string>",
        },
    ),
    "rai_interfaces/srv/RAIGroundingDino": (
        {
            "classes": "string",
            "box_threshold": "double",
            "text_threshold": "double",
            "source_img": "sensor_msgs/Image",
        },
        {"detections": "rai_interfaces/RAIDetectionArray"},
    ),
    "rai_interfaces/srv/RAIGroundedSam": (
        {"detections": "rai_interfaces/RAIDetectionArray", "source_img": "sensor_msgs/Image"},
        {"masks": "sequence<sensor_msgs/Image>"},
    ),
    "rai_interfaces/srv/ManipulatorMoveTo": (
        {"initial_gripper_state": "boolean", "final_gripper_state": "boolean", "target_pose": POSE},
        {"success": "boolean"},
    ),
    "vision_msgs/msg/Point2D": ({"x": "double", "y": "double"},),
    "vision_msgs/msg/Pose2D": ({"position": "vision_msgs/Point2D", "theta": "double"},),
    "vision_msgs/msg/BoundingBox2D": ({"center": "vision_msgs/Pose2D", "size_x": "double", "size_y": "double"},),
    "vision_msgs/msg/ObjectHypothesis": ({"class_id": "string", "score": "double"},),
    "vision_msgs/msg/ObjectHypothesisWithPose": (
        {"hypothesis": "vision_msgs/ObjectHypothesis", "pose": "geometry_msgs/PoseWithCovariance"},
    ),
    "vision_msgs/msg/Detection2D": (
        {
            "header": "std_msgs/Header",
            "results": "sequence<vision_msgs/ObjectHypothesisWithPose>",
            "bbox": "vision_msgs/BoundingBox2D",
            "id": "string",
        },
    ),
    "tf2_msgs/msg/TFMessage": ({"transforms": "sequence<geometry_msgs/TransformStamped>"},),
    "tf2_msgs/msg/TF2Error": ({"error": "uint8", "error_string": "string"},),
    "tf2_msgs/srv/FrameGraph": ({}, {"frame_yaml": "string"}),
    "tf2_msgs/action/LookupTransform": (
        {
            "target_frame": "string",
            "source_frame": "string",
            "source_time": "builtin_interfaces/Time",
            "timeout": "builtin_interfaces/Duration",
            "target_time": "builtin_interfaces/Time",
            "fixed_frame": "string",
            "advanced": "boolean",
        },
        {"transform": "geometry_msgs/TransformStamped", "error": "tf2_msgs/TF2Error"},
        {},
    ),
}
"""Type → its parts (a message; request and response; goal, result and feedback): fields and their types, in order."""
PARTS = {"msg": ("",), "srv": ("Request", "Response"), "action": ("Goal", "Result", "Feedback")}
NO_FIELD = "structure_needs_at_least_one_member"


def type_name(path: Path) -> str:
    return f"{path.parents[1].name}/{path.parent.name}/{path.stem}"


def built(name: str) -> Any:
    """The class of a type; the test is skipped where it is not built."""
    package, kind, last = name.split("/")
    try:
        module = importlib.import_module(f"{package}.{kind}")
    except ModuleNotFoundError:
        pytest.skip(f"{package} is not built here: make ros-interfaces")
    return getattr(module, last)


def test_every_definition_of_anothers_package_is_held_against_its_owners() -> None:
    ours = {type_name(path) for path in DEFINITIONS if path.parents[1].name != "rai_missions_msgs"}
    assert ours == UPSTREAM.keys()


@pytest.mark.parametrize("name", sorted(UPSTREAM))
def test_a_built_type_has_its_owners_fields_in_their_order(name: str) -> None:
    found = built(name)
    for part, fields in zip(PARTS[name.split("/")[1]], UPSTREAM[name], strict=True):
        reported = (getattr(found, part) if part else found).get_fields_and_field_types()
        assert [pair for pair in reported.items() if pair[0] != NO_FIELD] == list(fields.items()), (name, part)


@pytest.mark.parametrize("name", [type_name(path) for path in DEFINITIONS])
def test_every_definition_is_found_by_its_name(name: str) -> None:
    built(name)
    from rai_missions.connectors.ros2.names import find_type

    kind = name.split("/")[1]
    assert find_type(name, kind).__name__ == name.split("/")[2]  # type: ignore[arg-type]


def named_packages(path: Path) -> Iterator[str]:
    for line in path.read_text(encoding="utf-8").splitlines():
        if found := re.match(r"([a-z][a-z0-9_]*)/\w+(\[\S*\])?\s", line):
            yield found[1]


@pytest.mark.parametrize("package", PACKAGES, ids=lambda path: path.name)
def test_a_package_depends_on_what_its_definitions_name(package: Path) -> None:
    manifest = ET.parse(package / "package.xml").getroot()
    assert manifest.findtext("name") == package.name
    declared = {found.text for found in manifest.findall("depend")}
    used = {name for path in DEFINITIONS if package in path.parents for name in named_packages(path)}
    assert used - {package.name} <= declared
    recipe = (package / "CMakeLists.txt").read_text(encoding="utf-8")
    assert all(f"find_package({name} REQUIRED)" in recipe for name in declared)
    assert re.search(rf"DEPENDENCIES {' '.join(sorted(map(str, declared)))}\)", recipe)


def test_colcon_at_the_root_finds_no_part_of_anothers_package() -> None:
    ignored = {package.name for package in PACKAGES if (package / "COLCON_IGNORE").exists()}
    assert ignored == {package.name for package in PACKAGES} - {"rai_missions_msgs"}
    colcon = shutil.which("colcon")
    if colcon is None:
        pytest.skip("no colcon here: pip install colcon-core colcon-ros colcon-recursive-crawl")
    listed = subprocess.run(
        [colcon, "--log-base", "/dev/null", "list", "--names-only", "--base-paths", str(INTERFACES.parent)],
        capture_output=True,
        text=True,
        check=True,
        timeout=60,
    )
    assert {name for name in listed.stdout.split() if name.endswith("_msgs")} == {"rai_missions_msgs"}
