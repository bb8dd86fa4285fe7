# SPDX-License-Identifier: Apache-2.0
"""The tractor's topics and services: names, types and words of the upstream demo, and of our adapters.

The services and the words of `current_state` are those of RobotecAI/rai-agriculture-demo
(`VehicleControllerComponent.cpp`); the topics other than the camera's are adapters that the demo lacks.
"""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.worlds.orchard.autonomy import Word

__all__ = ("STATE_MESSAGES", "TOPICS")

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
