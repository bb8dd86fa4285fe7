# SPDX-License-Identifier: Apache-2.0
"""From a box in a picture to a point on the map: the depth in the box, the lens, and where the camera is.

Source: REP 103 (axes of a robot's body and of an optical frame), REP 118 (depth images), sensor_msgs/msg/CameraInfo.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rai_missions.image import Image
from rai_missions.worlds.perception.detections import Box2D

__all__ = ("Lens", "MapPoint", "Mount", "Robot2D", "depth_of", "lens_of", "locate")

NEAREST_M, FARTHEST_M = 0.1, 20.0
INNER = 0.5
"""The share of a box, around its middle, in which depth is read: the rest shows what is behind."""
NEAR = 0.25
"""The quantile of the depths in a box that counts: the thing, not the wall behind it."""
FEWEST = 4
"""Pixels with a depth that a box must have."""


class Lens(NamedTuple):
    """The camera's intrinsics, in pixels."""

    fx: float
    fy: float
    cx: float
    cy: float


class Mount(NamedTuple):
    """Where the camera is on the robot."""

    x: float = 0.14
    """m ahead of the robot's middle."""
    height: float = 0.2
    """m above the floor."""
    pitch: float = 0.0
    """rad, upwards."""


class Robot2D(NamedTuple):
    """Where the robot is."""

    x: float
    y: float
    yaw: float


class MapPoint(NamedTuple):
    """A point on the map, and how far the camera is from it."""

    x: float
    y: float
    z: float
    distance_m: float


def lens_of(message: Any) -> Lens | None:
    """The lens in a sensor_msgs/msg/CameraInfo; None where it is not calibrated."""
    k = message.get("k") if isinstance(message, Mapping) else None
    try:
        lens = Lens(float(k[0]), float(k[4]), float(k[2]), float(k[5]))  # type: ignore[index]
    except (TypeError, ValueError, IndexError):
        return None
    return lens if all(map(math.isfinite, lens)) and lens.fx > 0 and lens.fy > 0 else None


def depth_of(message: Mapping[str, Any]) -> NDArray[np.float32] | None:
    """Metres a pixel from a sensor_msgs/msg/Image in `16UC1` (mm) or `32FC1` (m); 0 is unknown. None: it is neither."""
    kinds: Mapping[Any, tuple[str, float]] = {"16UC1": ("u2", 0.001), "32FC1": ("f4", 1.0)}
    kind, scale = kinds.get(message.get("encoding"), ("", 0.0))
    data, width, height = message.get("data"), message.get("width"), message.get("height")
    raw = data.data if isinstance(data, Image) else bytes(data) if isinstance(data, bytes | bytearray | list) else b""
    if not kind or not isinstance(width, int) or not isinstance(height, int) or min(width, height) < 1:
        return None
    order = ">" if message.get("is_bigendian") else "<"
    line = int(message.get("step") or 0)
    wide = width * int(kind[1])
    if line < wide or len(raw) < line * height:
        return None
    lines = np.frombuffer(raw, np.uint8, line * height).reshape(height, line)[:, :wide]
    pixels = np.ascontiguousarray(lines).view(f"{order}{kind}").astype(np.float32) * scale
    known: NDArray[np.float32] = np.nan_to_num(pixels, nan=0.0, posinf=0.0, neginf=0.0)
    return known


def locate(box: Box2D, depth: NDArray[np.float32], lens: Lens, mount: Mount, robot: Robot2D) -> MapPoint | None:
    """Where on the map is what a box shows; None where the depth there is unknown.

    Args:
        box: In pixels of the colour picture, which the depth is aligned with.
        depth: Metres a pixel along the optical axis.
        lens: Of the same pixels.
        mount: Where the camera is on the robot.
        robot: Where the robot was when the picture was taken.
    """
    u, v = (box.left + box.right) / 2, (box.top + box.bottom) / 2
    away = _distance(box, depth)
    if away is None:
        return None
    right, down = (u - lens.cx) / lens.fx * away, (v - lens.cy) / lens.fy * away
    ahead = away * math.cos(mount.pitch) + down * math.sin(mount.pitch)
    up = away * math.sin(mount.pitch) - down * math.cos(mount.pitch)
    forward, cos, sin = ahead + mount.x, math.cos(robot.yaw), math.sin(robot.yaw)
    x, y = robot.x + cos * forward + sin * right, robot.y + sin * forward - cos * right
    return MapPoint(x, y, mount.height + up, math.hypot(away, right, down))


def _distance(box: Box2D, depth: NDArray[np.float32]) -> float | None:
    height, width = depth.shape
    u, v = (box.left + box.right) / 2, (box.top + box.bottom) / 2
    wide, high = (box.right - box.left) * INNER / 2, (box.bottom - box.top) * INNER / 2
    left, right = max(0, math.floor(u - wide)), min(width, math.ceil(u + wide) + 1)
    top, bottom = max(0, math.floor(v - high)), min(height, math.ceil(v + high) + 1)
    inner = depth[top:bottom, left:right]
    known = inner[(inner > NEAREST_M) & (inner < FARTHEST_M)]
    return float(np.quantile(known, NEAR)) if known.size >= FEWEST else None
