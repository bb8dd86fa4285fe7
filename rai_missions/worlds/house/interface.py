# SPDX-License-Identifier: Apache-2.0
"""The robot's topics, services and actions, under the names that ROSbot XL and Nav2 give them."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds import messages
from rai_missions.worlds.house.layout import FURNITURE, ROOMS, NamedPose
from rai_missions.worlds.house.lidar import BEAMS, NEAREST_M, REACH_M
from rai_missions.worlds.house.rosbot import BODY_M, CAMERA_AT, CAMERA_PITCH, RobotPose
from rai_missions.worlds.house.speech import FROM_HUMAN, HRI_MESSAGE
from rai_missions.worlds.perception.finder import FinderConfig
from rai_missions.worlds.perception.projection import Mount

__all__ = ("ASK_FOR_HELP", "CMD_VEL", "FINDER", "SEEN", "TOPICS", "laser_scan", "located", "odometry")

CAMERA = "camera/color/image_raw"
DEPTH, LENS = "camera/depth/image_raw", "camera/color/camera_info"
SEEN = CAMERA, DEPTH, LENS
"""Topics that a camera is needed for."""
CMD_VEL = "/cmd_vel", "geometry_msgs/msg/Twist"
ASK_FOR_HELP = "/ask_for_help", "std_msgs/msg/String"
"""What the robot asks aloud where its way is blocked; people near it may clear the way."""
TOPICS: Mapping[str, str] = {
    "amcl_pose": "geometry_msgs/msg/PoseWithCovarianceStamped",
    "battery": "sensor_msgs/msg/BatteryState",
    CAMERA: "sensor_msgs/msg/Image",
    DEPTH: "sensor_msgs/msg/Image",
    LENS: "sensor_msgs/msg/CameraInfo",
    FROM_HUMAN: HRI_MESSAGE,
    "odom": "nav_msgs/msg/Odometry",
    "scan": "sensor_msgs/msg/LaserScan",
}
"""What is published, and its types."""
FINDER = FinderConfig(
    mount=Mount(CAMERA_AT[0], CAMERA_AT[1] + BODY_M, CAMERA_PITCH),
    rooms={name: box[:4] for name, box in ROOMS.items()},
    furniture={name: box[:4] for name, box in FURNITURE.items()},
)
"""The names that the object finder uses here."""
TURN = 2 * math.pi / BEAMS


def laser_scan(ranges: NDArray[np.float64], at: float, scan_s: float) -> dict[str, Any]:
    """A sensor_msgs/msg/LaserScan; infinite is farther than it reaches (REP 117)."""
    return {
        "header": messages.header(at, "laser"),
        "angle_min": -math.pi,
        "angle_max": math.pi - TURN,
        "angle_increment": TURN,
        "time_increment": 0.0,
        "scan_time": scan_s,
        "range_min": NEAREST_M,
        "range_max": REACH_M,
        "ranges": [round(range_m, 4) for range_m in ranges.tolist()],
    }


def located(pose: RobotPose, at: float) -> dict[str, Any]:
    """A geometry_msgs/msg/PoseWithCovarianceStamped in the frame `map`, certain of itself."""
    return {"header": messages.header(at, "map"), "pose": {"pose": messages.pose(*pose[:3])}}


def odometry(pose: RobotPose, start: NamedPose, at: float) -> dict[str, Any]:
    """A nav_msgs/msg/Odometry, from where it set out."""
    dx, dy = pose.x - start.x, pose.y - start.y
    cos, sin = math.cos(start.heading), math.sin(start.heading)
    turned = messages.pose(cos * dx + sin * dy, cos * dy - sin * dx, pose.heading - start.heading)
    twist = {"linear": {"x": pose.speed, "y": 0.0, "z": 0.0}, "angular": {"x": 0.0, "y": 0.0, "z": pose.turn}}
    return {
        "header": messages.header(at, "odom"),
        "child_frame_id": "base_link",
        "pose": {"pose": turned},
        "twist": {"twist": twist},
    }
