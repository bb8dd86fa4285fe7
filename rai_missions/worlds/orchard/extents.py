# SPDX-License-Identifier: Apache-2.0
"""How far the obstacles reach, from their geoms: what beams and tyres meet, not what is painted over it."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import mujoco
import numpy as np

__all__ = ("Extents",)

EXTENT: Mapping[Any, Callable[[Any, Any], float]] = {
    mujoco.mjtGeom.mjGEOM_SPHERE: lambda size, axes: size[0],
    mujoco.mjtGeom.mjGEOM_CAPSULE: lambda size, axes: size[0] + size[1] * abs(axes[2]),
    mujoco.mjtGeom.mjGEOM_CYLINDER: lambda size, axes: size[1] * abs(axes[2]) + size[0] * math.hypot(axes[0], axes[1]),
    mujoco.mjtGeom.mjGEOM_BOX: lambda size, axes: float(np.abs(axes) @ size),
    mujoco.mjtGeom.mjGEOM_ELLIPSOID: lambda size, axes: float(np.linalg.norm(axes * size)),
}
"""How far a geom reaches along a direction, given the direction in its own axes."""
UP = np.array([0.0, 0.0, 1.0])
WHEELS_M, WIDTH_M, CLEARANCE_M = 0.55, 1.15, 0.42
"""Half of what is free between the wheels, half of what the tractor needs, and how high a thing between the wheels may
be: each with 4 to 8 cm to spare for how exactly it follows its way."""


class Extents:
    """Reaches of each obstacle.

    Args:
        model: The compiled orchard.
        data: Its state.
        bodies: The obstacles' bodies.
    """

    def __init__(self, model: Any, data: Any, bodies: Sequence[int]) -> None:
        self._model, self._data = model, data
        self._sensed = [np.flatnonzero((model.geom_bodyid == body) & (model.geom_group == 3)) for body in bodies]
        self._hard = [geoms[model.geom_contype[geoms] > 0] for geoms in self._sensed]
        self._hard = [
            np.append(
                hard, [g for g in range(model.ngeom) if self._is_bridge(g, body) and model.geom_contype[g] > 0]
            ).astype(int)
            for hard, body in zip(self._hard, bodies, strict=True)
        ]

    def _is_bridge(self, geom: int, body: int) -> bool:
        """Whether it belongs to what lies over an obstacle to protect it."""
        name = self._model.body(int(self._model.geom_bodyid[geom])).name
        return bool(name == f"{self._model.body(body).name}_bridge")

    def reach(self, number: int, along: tuple[float, float]) -> tuple[float, float]:
        """From where to where an obstacle extends along a direction, m."""
        return self._reach(self._sensed[number], np.array([*along, 0.0]))

    def top_m(self, number: int) -> float:
        """How high an obstacle is, soft parts included."""
        return max(0.0, self._reach(self._sensed[number], UP)[1])

    def solid_m(self, number: int, x: float, y: float, heading: float) -> float:
        """How high what is hard reaches where a tractor that drives straight on would meet it; 0 where it would not.

        Args:
            number: The obstacle.
            x, y, heading: Where the tractor is.
        """
        left = np.array([-math.sin(heading), math.cos(heading), 0.0])
        middle, highest = float(left[0] * x + left[1] * y), 0.0
        for geom in self._hard[number]:
            right_m, left_m = (value - middle for value in self._reach([geom], left))
            top = float(self._reach([geom], UP)[1])
            is_aside = right_m > WIDTH_M or left_m < -WIDTH_M
            is_between = right_m > -WHEELS_M and left_m < WHEELS_M and top < CLEARANCE_M
            highest = max(highest, 0.0 if is_aside or is_between else top)
        return float(highest)

    def around_m(self, number: int, x: float, y: float, heading: float) -> float:
        """`solid_m` of an obstacle and whatever lies in it or under it, seen or not: a radar looks through."""
        along = (math.cos(heading), math.sin(heading))
        near, far = self.reach(number, along)
        side = (-math.sin(heading), math.cos(heading))
        right, left = self.reach(number, side)
        found = [number]
        for other in range(len(self._sensed)):
            (begins, ends), (from_, to) = self.reach(other, along), self.reach(other, side)
            if other != number and begins < far and ends > near and from_ < left and to > right:
                found.append(other)
        return max(self.solid_m(each, x, y, heading) for each in found)

    def _reach(self, geoms: Any, way: Any) -> tuple[float, float]:
        near, far = math.inf, -math.inf
        for geom in geoms:
            axes = way @ self._data.geom_xmat[geom].reshape(3, 3)
            middle = float(way @ self._data.geom_xpos[geom])
            extent = EXTENT[mujoco.mjtGeom(int(self._model.geom_type[geom]))](self._model.geom_size[geom], axes)
            near, far = min(near, middle - extent), max(far, middle + extent)
        return near, far
