# SPDX-License-Identifier: Apache-2.0
"""What the depth camera shows below the plane of the lidar: where the floor is free, and where something is on it.

Rule: rays of the depth image are cast into the geometry, so nothing is rendered. Points are computed as a robot
computes them: from the depth with its noise, the mount of the camera, and a robot that is level.

Source: pointcloud_to_laserscan (`min_height`, `max_height`) and the obstacle layer of nav2_costmap_2d
(`min_obstacle_height`, `obstacle_max_range`) do the same with a cloud.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.frame_history import DEPTH_NOISE, NEAREST_M
from rai_missions.worlds.house.rays import Rays
from rai_missions.worlds.house.rosbot import BODY_M, CAMERA_AT, CAMERA_FOVY_DEG, CAMERA_PITCH, LIDAR_AT

__all__ = ("LowPoints", "LowScan")

COLUMNS, ROWS = 36, 12
"""Pixels of the image that are read."""
SHAPE = 4 / 3
"""How much wider than high the image is."""
REACH_M = 2.5
FLOOR_M, LOW_M = 0.08, 0.3
"""What is lower than the first is floor, or the dock; what is higher than the second does not count."""


class LowPoints(NamedTuple):
    """Points on the floor's plane, (n, 2), in m: x ahead of the lidar, y to its left."""

    floor: NDArray[np.float64]
    """Where the floor is seen."""
    low: NDArray[np.float64]
    """Where something is on it."""


class LowScan:
    """The lower half of the depth image of one robot.

    Args:
        model: The compiled house.
        data: Its state.
        seed: The seed of the noise.
    """

    def __init__(self, model: Any, data: Any, seed: int) -> None:
        self._data, self._body = data, model.body("rosbot").id
        self._rng = np.random.default_rng(seed)
        up = math.tan(math.radians(CAMERA_FOVY_DEG) / 2)
        right, upwards = np.meshgrid(
            np.linspace(-up * SHAPE, up * SHAPE, COLUMNS), np.linspace(-up, -math.tan(CAMERA_PITCH), ROWS)
        )
        cos, sin = math.cos(CAMERA_PITCH), math.sin(CAMERA_PITCH)
        ahead = np.stack([cos - sin * upwards, -right, sin + cos * upwards], -1).reshape(-1, 3)
        self._ahead = ahead / np.linalg.norm(ahead, axis=1, keepdims=True)
        self._rays = Rays(model, data, self._ahead, (0, 1, 4), REACH_M)

    def look(self) -> LowPoints:
        """The points of this instant."""
        turned = self._data.xmat[self._body]
        camera = self._data.xpos[self._body] + turned.reshape(3, 3) @ (CAMERA_AT[0], 0.0, CAMERA_AT[1])
        far = self._rays.cast(camera, turned)
        far = far * self._rng.normal(1, DEPTH_NOISE, len(far))
        points = self._ahead * far[:, None] + (CAMERA_AT[0] - LIDAR_AT[0], 0.0, CAMERA_AT[1] + BODY_M)
        known = (far > NEAREST_M) & (far < REACH_M)
        is_floor = points[:, 2] < FLOOR_M
        return LowPoints(points[known & is_floor, :2], points[known & ~is_floor & (points[:, 2] < LOW_M), :2])
