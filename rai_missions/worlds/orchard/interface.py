# SPDX-License-Identifier: Apache-2.0
"""The tractor's topics and services: names, types and message shapes of the upstream demo, and of our adapters.

The services and the words of `current_state` are those of RobotecAI/rai-agriculture-demo
(`VehicleControllerComponent.cpp`); the topics other than the camera's are adapters that the demo lacks.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from rai_missions.event import Image
from rai_missions.worlds.orchard.autonomy import Word
from rai_missions.worlds.orchard.tractor import Pose

__all__ = ("STATE_MESSAGES", "TOPICS", "TRIGGER", "header", "image", "text", "trigger")

TRIGGER = "std_srvs/srv/Trigger"
STATE_MESSAGES: Mapping[Word, str] = {
    "STOPPED": "STOPPED: the vehicle has stopped",
    "DRIVING": "DRIVING: the vehicle is performing a mission",
    "REVERSING": "REVERSING: the vehicle is reversing to skip the current mission",
    "CHANGING_PATH": "CHANGING_PATH: the vehicle finished/aborted the current mission and will start the next one",
    "FINISHED": "FINISHED: the vehicle has stopped after finishing/aborting the last mission",
}
TOPICS: Mapping[str, str] = {
    "alleys_driven": "std_msgs/msg/Int32",
    "at_home": "std_msgs/msg/Bool",
    "battery": "sensor_msgs/msg/BatteryState",
    "camera_image_color": "sensor_msgs/msg/Image",
    "crossing": "std_msgs/msg/String",
    "obstacle": "std_msgs/msg/String",
    "passed": "std_msgs/msg/Bool",
    "pose": "geometry_msgs/msg/PoseStamped",
    "state": "std_msgs/msg/String",
    "touched_living": "std_msgs/msg/Bool",
}
"""What is published below the tractor's name, and its types."""


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
        "step": picture.width * 3,
        "data": picture,
    }


def pose_stamped(pose: Pose, at: float) -> dict[str, Any]:
    """A geometry_msgs/msg/PoseStamped in the frame `map`."""
    half = pose.heading / 2
    return {
        "header": header(at, "map"),
        "pose": {
            "position": {"x": pose.x, "y": pose.y, "z": 0.0},
            "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
        },
    }


def battery_state(percentage: float, voltage: float, at: float) -> dict[str, Any]:
    """A sensor_msgs/msg/BatteryState; `percentage` goes from 0 to 1."""
    return {
        "header": header(at, "base"),
        "percentage": percentage,
        "voltage": voltage,
        "power_supply_status": 2,
        "present": True,
    }
