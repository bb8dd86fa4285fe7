# SPDX-License-Identifier: Apache-2.0
"""The living of one orchard, moved in its simulation, and what workers carry out of the alleys."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

from rai_missions.worlds.orchard.attendant import Attendant
from rai_missions.worlds.orchard.layout import Layout
from rai_missions.worlds.orchard.obstacles import Obstacle, Walker

__all__ = ("Walkers",)

AUDIBLE_M = 15.0
"""How far the horn carries."""
MEADOW_M = 40.0
"""Where what is carried away is laid, off the orchard's corner."""


class Walkers:
    """Steps all that lives, and puts the bodies where they are.

    Args:
        model: The compiled orchard.
        data: Its state.
        layout: The plan of the orchard.
        obstacles: What is in the alleys, in the order of the bodies; of these the living walk.
        bodies: The obstacles' bodies in the model.
    """

    def __init__(
        self, model: Any, data: Any, layout: Layout, obstacles: Sequence[Obstacle], bodies: Sequence[int]
    ) -> None:
        self._model, self._data, self._bodies = model, data, bodies
        self._walkers = {
            number: Walker(one, layout) if one.attends is None else Attendant(one, layout, obstacles[one.attends])
            for number, one in enumerate(obstacles)
            if one.living
        }
        self._idle: set[int] = set()
        """The workers who have fetched what they attended to."""

    def step(self, at: float, period_s: float, tractor: tuple[float, float]) -> bool:
        """Let all live on for a period; whether something was carried away.

        Args:
            at: Simulated seconds.
            period_s: How long.
            tractor: Where it is.
        """
        was_carried = False
        for number, walker in self._walkers.items():
            if walker.step(at, period_s, tractor):
                self._put(number, walker)
            if isinstance(walker, Attendant) and walker.has_fetched and number not in self._idle:
                self._idle.add(number)
                self._carry_away(walker.obstacle.attends or 0)
                was_carried = True
        return was_carried

    def signal(self, tractor: tuple[float, float]) -> None:
        """The tractor sounds its horn and flashes its lights, for all who are near."""
        for walker in self._walkers.values():
            if math.dist((walker.x, walker.y), tractor) < AUDIBLE_M:
                walker.signal(tractor[0])

    def _put(self, number: int, walker: Walker) -> None:
        mocap, half = self._model.body_mocapid[self._bodies[number]], walker.heading / 2
        self._data.mocap_pos[mocap] = walker.x, walker.y, 0.0
        self._data.mocap_quat[mocap] = math.cos(half), 0.0, 0.0, math.sin(half)

    def _carry_away(self, number: int) -> None:
        """Lay a thing at the edge of the meadow."""
        joint = self._model.body_jntadr[self._bodies[number]]
        first, dof = self._model.jnt_qposadr[joint], self._model.jnt_dofadr[joint]
        self._data.qpos[first : first + 2] = -MEADOW_M, -MEADOW_M - 3.0 * number
        self._data.qvel[dof : dof + 6] = 0.0
