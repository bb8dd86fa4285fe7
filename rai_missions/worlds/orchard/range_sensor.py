# SPDX-License-Identifier: Apache-2.0
"""The range sensor on the nose: parallel beams over the width of the tractor, near the ground to chest height."""

from __future__ import annotations

import math
from typing import Any

import mujoco
import numpy as np

from rai_missions.worlds.orchard.tractor import NOSE_M

__all__ = ("Beams",)

HALF_WIDTH_M, ACROSS = 1.25, 13
HEIGHTS_M = (0.03, 0.09, 0.3, 0.55, 0.9, 1.3)
"""Closer together than anything that must be seen is wide."""
REACH_M = 12.0


class Beams:
    """Sees whatever can be touched, alive or not; it cannot determine what it is.

    Args:
        model: The compiled orchard.
        data: Its state.
    """

    def __init__(self, model: Any, data: Any) -> None:
        self._model, self._data = model, data
        self._body = model.body("tractor").id
        self._everything = np.array([0, 0, 0, 1, 1, 0], np.uint8)
        self._but_trees = np.array([0, 0, 0, 1, 0, 0], np.uint8)
        self._hit = np.array([-1], np.int32)

    def ahead_m(self, x: float, y: float, heading: float, *, trees: bool) -> float | None:
        """From the nose to the nearest thing ahead in the tractor's own width, if there is one within 12 m.

        Args:
            x, y, heading: Where the tractor is.
            trees: Whether trunks count; when it turns among them, the map has them.
        """
        groups = self._everything if trees else self._but_trees
        ahead = np.array([math.cos(heading), math.sin(heading), 0.0])
        nearest = REACH_M
        for across in np.linspace(-HALF_WIDTH_M, HALF_WIDTH_M, ACROSS):
            start = np.array(
                [x + ahead[0] * NOSE_M - ahead[1] * across, y + ahead[1] * NOSE_M + ahead[0] * across, 0.0]
            )
            for start[2] in HEIGHTS_M:
                found = mujoco.mj_ray(self._model, self._data, start, ahead, groups, 1, self._body, self._hit)
                nearest = found if 0 <= found < nearest else nearest
        return float(nearest) if nearest < REACH_M else None
