# SPDX-License-Identifier: Apache-2.0
"""Rays from a sensor on the robot into the geometry of the house."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = ("Rays",)

GEOM_GROUPS = 6
"""The groups of geometries that MuJoCo has."""


class Rays:
    """Rays in fixed directions of a sensor, which pass through the robot itself.

    Args:
        model: The compiled house.
        data: Its state.
        directions: (n, 3), unit vectors of the sensor.
        groups: The geoms that they meet, by their group.
        reach_m: How far they go.
    """

    def __init__(
        self, model: Any, data: Any, directions: NDArray[np.float64], groups: Collection[int], reach_m: float
    ) -> None:
        self._model, self._data, self._directions, self._reach_m = model, data, directions, reach_m
        self._robot = model.body("rosbot").id
        self._groups = np.array([group in groups for group in range(GEOM_GROUPS)], np.uint8)
        self._hit = np.zeros(len(directions), np.int32)
        self._far = np.zeros(len(directions))

    def cast(self, place: NDArray[np.float64], turned: NDArray[np.float64]) -> NDArray[np.float64]:
        """Metres along each ray, -1 where it meets nothing; the next call overwrites them.

        Args:
            place: The place of the sensor, (3,).
            turned: Its rotation, (9,).
        """
        rays = (self._directions @ turned.reshape(3, 3).T).ravel()
        mujoco.mj_multiRay(
            self._model,
            self._data,
            place,
            rays,
            self._groups,
            1,
            self._robot,
            self._hit,
            self._far,
            None,
            len(self._directions),
            self._reach_m,
        )
        return self._far
