# SPDX-License-Identifier: Apache-2.0
"""Messages of common ROS packages as the worlds send them, in plain data."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from rai_missions.image import Image

__all__ = (
    "TRIGGER",
    "battery_state",
    "camera_info",
    "header",
    "image",
    "pose",
    "pose_stamped",
    "stamp",
    "text",
    "trigger",
)

TRIGGER = "std_srvs/srv/Trigger"
PIXEL_BYTES: Mapping[str, int] = {"rgb8": 3, "16UC1": 2, "mono8": 1}


def trigger(success: bool, message: str) -> dict[str, Any]:
    """A reply of std_srvs/srv/Trigger."""
    return {"success": success, "message": message}


def text(facts: Mapping[str, Any]) -> dict[str, Any]:
    """Facts as JSON in a std_msgs/msg/String."""
    return {"data": json.dumps(facts)}


def stamp(seconds: float) -> dict[str, int]:
    """A builtin_interfaces/msg/Time (or Duration)."""
    whole, nanoseconds = divmod(round(seconds * 1e9), 10**9)
    return {"sec": whole, "nanosec": nanoseconds}


def header(at: float, frame: str) -> dict[str, Any]:
    return {"stamp": stamp(at), "frame_id": frame}


def image(picture: Image, at: float) -> dict[str, Any]:
    """A sensor_msgs/msg/Image whose bytes are rendered when they are asked for."""
    return {
        "header": header(at, "camera"),
        "height": picture.height,
        "width": picture.width,
        "encoding": picture.encoding,
        "is_bigendian": 0,
        "step": picture.width * PIXEL_BYTES[picture.encoding],
        "data": picture,
    }


def pose(x: float, y: float, heading: float) -> dict[str, Any]:
    """A geometry_msgs/msg/Pose on the ground."""
    half = heading / 2
    return {
        "position": {"x": x, "y": y, "z": 0.0},
        "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
    }


def pose_stamped(x: float, y: float, heading: float, at: float) -> dict[str, Any]:
    """A geometry_msgs/msg/PoseStamped in the frame `map`."""
    return {"header": header(at, "map"), "pose": pose(x, y, heading)}


def battery_state(percentage: float, voltage: float, at: float, *, charging: bool) -> dict[str, Any]:
    """A sensor_msgs/msg/BatteryState; `percentage` goes from 0 to 1."""
    return {
        "header": header(at, "base"),
        "percentage": percentage,
        "voltage": voltage,
        "power_supply_status": 1 if charging else 2,
        "present": True,
    }


def camera_info(width: int, height: int, fovy_deg: float, at: float) -> dict[str, Any]:
    """A sensor_msgs/msg/CameraInfo of a camera without distortion; depth is aligned with it."""
    focal = height / 2 / math.tan(math.radians(fovy_deg) / 2)
    k = [focal, 0.0, width / 2, 0.0, focal, height / 2, 0.0, 0.0, 1.0]
    return {
        "header": header(at, "camera"),
        "height": height,
        "width": width,
        "distortion_model": "plumb_bob",
        "d": [0.0] * 5,
        "k": k,
        "r": [1.0, 0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0],
        "p": [*k[:3], 0.0, *k[3:6], 0.0, *k[6:], 0.0],
    }
