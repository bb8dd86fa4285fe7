# SPDX-License-Identifier: Apache-2.0
"""The desk's topics, under the names that upstream's simulation of an arm gives its camera."""

from __future__ import annotations

from collections.abc import Mapping

__all__ = ("OBJECTS", "SEEN", "TOPICS")

COLOUR, DEPTH, LENS = "color_image5", "depth_image5", "color_camera_info5"
SEEN = COLOUR, DEPTH, LENS
"""Topics that a camera is needed for."""
OBJECTS = "desk/objects"
TOPICS: Mapping[str, str] = {
    COLOUR: "sensor_msgs/msg/Image",
    DEPTH: "sensor_msgs/msg/Image",
    LENS: "sensor_msgs/msg/CameraInfo",
    OBJECTS: "std_msgs/msg/String",
}
"""What is published, without the arm's, and its types."""
