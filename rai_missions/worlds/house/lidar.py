# SPDX-License-Identifier: Apache-2.0
"""The lidar on top: how far it is to the nearest thing, all around."""

from __future__ import annotations

from typing import Any

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = ("BEAMS", "NEAREST_M", "REACH_M", "Lidar")

BEAMS = 360
NEAREST_M, REACH_M = 0.12, 12.0
NOISE_M = 0.01
"""Standard deviation of a range."""


class Lidar:
    """Beams in a plane, one a degree, from -π counter-clockwise.

    Args:
        model: The compiled house.
        data: Its state.
        seed: Of the noise.
    """

    def __init__(self, model: Any, data: Any, seed: int) -> None:
        self._model, self._data = model, data
        self._site, self._body = model.site("laser").id, model.body("rosbot").id
        self._rng = np.random.default_rng(seed)
        self.angles = np.linspace(-np.pi, np.pi, BEAMS, endpoint=False)
        self._ahead = np.stack([np.cos(self.angles), np.sin(self.angles), np.zeros(BEAMS)], 1)
        self._groups = np.array([0, 1, 0, 0, 0, 0], np.uint8)
        self._hit = np.zeros(BEAMS, np.int32)
        self._far = np.zeros(BEAMS)

    @property
    def place(self) -> tuple[float, float]:
        """Where it is."""
        x, y, _ = self._data.site_xpos[self._site]
        return float(x), float(y)

    def scan(self) -> NDArray[np.float64]:
        """Metres along each beam; infinite where nothing is within reach."""
        turned = (self._ahead @ self._data.site_xmat[self._site].reshape(3, 3).T).ravel()
        mujoco.mj_multiRay(
            self._model, self._data, self._data.site_xpos[self._site], turned, self._groups, 1, self._body,
            self._hit, self._far, None, BEAMS, REACH_M,
        )  # fmt: skip
        noisy = np.where(self._far < 0, np.inf, self._far + self._rng.normal(0, NOISE_M, BEAMS))
        return np.where(noisy > REACH_M, np.inf, np.maximum(noisy, NEAREST_M))
