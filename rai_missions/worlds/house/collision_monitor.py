# SPDX-License-Identifier: Apache-2.0
"""The last check ahead of the motors: a speed at which the robot would soon touch what its lidar sees is reduced.

Rule: it knows the newest scan and the robot's outline, and no plan and no map. What it reduces, it reduces in the same
proportion, so the robot stays on the arc that was commanded.

Source: nav2_collision_monitor, action type `approach` (`time_before_collision`, `simulation_time_step`).
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.house.rosbot import OUTLINE_M

__all__ = ("CollisionMonitor",)

Points = NDArray[np.float64]
"""(n, 2): x and y in m."""

AHEAD_S = 0.6
"""How long before a touch the speed is reduced: at 0.5 m/s the robot then brakes with less than 1 m/s²."""
STEP_S = 0.05
MARGIN_M = 0.03
"""Beyond the outline: three standard deviations of a range."""
NEAR_M = 0.8
"""What is farther away is out of reach in that time."""


class CollisionMonitor:
    """Knows what is near the robot."""

    def __init__(self) -> None:
        self._points: Points = np.empty((0, 2))
        self._times = np.arange(1, round(AHEAD_S / STEP_S) + 1) * STEP_S

    def see(self, points: Points) -> None:
        """Take in where the beams of a scan end.

        Args:
            points: On the map.
        """
        self._points = points

    def reduced(self, place: tuple[float, float], heading: float, command: tuple[float, float]) -> tuple[float, float]:
        """The command, or what of it leaves `AHEAD_S` until a touch.

        Args:
            place: The place of the robot.
            heading: The heading of the robot.
            command: Speed (m/s) and turn (rad/s).
        """
        if command == (0.0, 0.0):
            return command
        points = self._points - place
        near = points[np.abs(points).max(axis=1, initial=0.0) < NEAR_M]
        if len(near) == 0:
            return command
        share = self._free_s(_turned(near, heading), *command) / AHEAD_S
        return (command[0] * share, command[1] * share) if share < 1 else command

    def _free_s(self, points: Points, speed: float, turn: float) -> float:
        """How long the robot may move so until it touches a point (s), at most `AHEAD_S`."""
        angles = turn * self._times
        if abs(turn) < 1e-6:
            x, y = speed * self._times, np.zeros_like(angles)
        else:
            x, y = speed / turn * np.sin(angles), speed / turn * (1 - np.cos(angles))
        east, north = points[:, 0] - x[:, None], points[:, 1] - y[:, None]
        cos, sin = np.cos(angles)[:, None], np.sin(angles)[:, None]
        outside = _outside(cos * east + sin * north, cos * north - sin * east)
        allowed = np.minimum(MARGIN_M, _outside(points[:, 0], points[:, 1]) - 1e-6)  # who is too near may get away
        touched = np.flatnonzero((outside < allowed).any(axis=1))
        return float(self._times[touched[0]] - STEP_S) if len(touched) else AHEAD_S


def _turned(points: Points, heading: float) -> Points:
    """Points around the robot, x ahead and y to its left."""
    cos, sin = math.cos(heading), math.sin(heading)
    turned: Points = points @ np.array([[cos, -sin], [sin, cos]])
    return turned


def _outside(x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.float64]:
    """How far points are outside of the robot's outline (m); negative inside."""
    far: NDArray[np.float64] = np.maximum(np.abs(x) - OUTLINE_M[0], np.abs(y) - OUTLINE_M[1])
    return far
