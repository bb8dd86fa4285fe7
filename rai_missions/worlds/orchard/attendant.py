# SPDX-License-Identifier: Apache-2.0
"""A worker at the trees, who carries away what lies in the alley once he is asked, or when he finds the time.

Rule: he does not walk in front of a tractor that is near. The carrying is not simulated: what he has reached lies at
the edge of the meadow a moment later.
"""

from __future__ import annotations

import math
from typing import Literal

from rai_missions.worlds.orchard.layout import Layout
from rai_missions.worlds.orchard.obstacles import Obstacle, Walker

__all__ = ("Attendant",)

WALKS_MPS, SAFE_M = 1.5, 4.0
Phase = Literal["waits", "goes", "comes", "done"]


class Attendant(Walker):
    """The worker who attends to an obstacle.

    Args:
        obstacle: He himself; `attends` has the number of the thing.
        layout: The orchard.
        thing: What he attends to.
    """

    def __init__(self, obstacle: Obstacle, layout: Layout, thing: Obstacle) -> None:
        super().__init__(obstacle, layout)
        self._thing = thing.place_m(layout)
        self._stand = (self.x, self.y)
        self._phase: Phase = "waits"

    @property
    def has_fetched(self) -> bool:
        """Whether what he attends to is no longer in the alley."""
        return self._phase in ("comes", "done")

    def signal(self, tractor_x: float) -> None:
        self._signals += 1
        if self._signals >= self.obstacle.heeds_after and self._phase == "waits":
            self._phase = "goes"

    def step(self, at: float, period_s: float, tractor: tuple[float, float]) -> bool:
        if self._has_waited(at, tractor) and self._phase == "waits":
            self._phase = "goes"
        if self._phase not in ("goes", "comes"):
            return False
        if self._phase == "goes" and math.dist(tractor, self._thing) < SAFE_M:
            return False
        goal = self._thing if self._phase == "goes" else self._stand
        dx, dy = goal[0] - self.x, goal[1] - self.y
        away, step = math.hypot(dx, dy), WALKS_MPS * period_s
        if away <= step:
            self.x, self.y = goal
            self._phase = "comes" if self._phase == "goes" else "done"
        else:
            self.heading = math.atan2(dy, dx)
            self.x, self.y = self.x + dx / away * step, self.y + dy / away * step
        return True
