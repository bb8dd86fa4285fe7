# SPDX-License-Identifier: Apache-2.0
"""The lidar on top: how far it is to the nearest thing, all around."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.house.rays import Rays

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
        seed: The seed of the noise.
    """

    def __init__(self, model: Any, data: Any, seed: int) -> None:
        self._data, self._site = data, model.site("laser").id
        self._rng = np.random.default_rng(seed)
        self.angles = np.linspace(-np.pi, np.pi, BEAMS, endpoint=False)
        ahead = np.stack([np.cos(self.angles), np.sin(self.angles), np.zeros(BEAMS)], 1)
        self._rays = Rays(model, data, ahead, (1,), REACH_M)

    @property
    def place(self) -> tuple[float, float]:
        """Where it is."""
        x, y, _ = self._data.site_xpos[self._site]
        return float(x), float(y)

    def scan(self) -> NDArray[np.float64]:
        """Metres along each beam; infinite where nothing is within reach."""
        far = self._rays.cast(self._data.site_xpos[self._site], self._data.site_xmat[self._site])
        noisy = np.where(far < 0, np.inf, far + self._rng.normal(0, NOISE_M, BEAMS))
        return np.where(noisy > REACH_M, np.inf, np.maximum(noisy, NEAREST_M))
