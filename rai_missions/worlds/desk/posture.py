# SPDX-License-Identifier: Apache-2.0
"""How a thing lies: its yaw, and how far it leans, from its axes.

Rule: a cube on any of its faces lies straight, and so does a round thing however it rolled.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.desk.catalogue import KINDS

__all__ = ("about_z", "lean_of", "yaw_of")

UPRIGHT = 0.7
"""Above it the height that an axis gains is that of an axis which points up or down."""
TAPER_RAD = 0.12
"""A carrot that lies on the desk leans so much: its tip is thinner."""


def about_z(angle: float) -> NDArray[np.float64]:
    """The turn by an angle (rad) about the vertical: the axes of what lies straight, as columns."""
    cos, sin = math.cos(angle), math.sin(angle)
    return np.array([[cos, -sin, 0.0], [sin, cos, 0.0], [0.0, 0.0, 1.0]])


def yaw_of(axes: NDArray[np.float64]) -> float:
    """The yaw of a thing, rad.

    Args:
        axes: Its own axes as columns, in the world.
    """
    x = axes[:, 0] if abs(axes[2, 0]) < UPRIGHT else axes[:, 1]
    return math.atan2(x[1], x[0])


def lean_of(kind: str, axes: NDArray[np.float64]) -> float:
    """How far a thing leans from how it lies by itself, rad, 0 to π/2; containers to π."""
    if KINDS[kind].turns == 0:
        return 0.0
    if KINDS[kind].is_container:
        return math.acos(_cosine(axes[2, 2]))
    if kind == "cube":
        return math.acos(_cosine(np.abs(axes[2]).max()))
    return max(0.0, math.asin(_cosine(abs(axes[2, 0]))) - TAPER_RAD)


def _cosine(value: float) -> float:
    return min(1.0, max(-1.0, float(value)))
