# SPDX-License-Identifier: Apache-2.0
"""The people of one house, moved in its simulation."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rai_missions.worlds.house.people import Resident
from rai_missions.worlds.house.scene import person_name

__all__ = ("Residents",)


class Residents:
    """Steps everyone, and puts their bodies where they are.

    Args:
        model: The compiled house.
        data: Its state.
        walkers: The people, in the order of their bodies.
    """

    def __init__(self, model: Any, data: Any, walkers: Sequence[Resident]) -> None:
        self._data, self.walkers = data, tuple(walkers)
        self._mocap = [model.body_mocapid[model.body(person_name(number)).id] for number in range(len(walkers))]
        for number in range(len(walkers)):
            self._put(number)

    def step(
        self, at: float, period_s: float, robot: tuple[float, float], blocked: Sequence[tuple[float, float]]
    ) -> None:
        """Let everyone live on for a period; see `Resident.step`."""
        for number, walker in enumerate(self.walkers):
            others = [(other.x, other.y) for other in self.walkers if other is not walker]
            if walker.step(at, period_s, robot, (*blocked, *others)):
                self._put(number)

    def _put(self, number: int) -> None:
        walker, half = self.walkers[number], self.walkers[number].heading / 2
        self._data.mocap_pos[self._mocap[number], :2] = walker.x, walker.y
        self._data.mocap_quat[self._mocap[number]] = math.cos(half), 0.0, 0.0, math.sin(half)
