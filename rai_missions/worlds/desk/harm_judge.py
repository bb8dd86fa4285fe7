# SPDX-License-Identifier: Apache-2.0
"""What the arm has done to the desk: what fell, what it pressed, and what it moved.

Rule: contacts and places of the physics alone are read; nothing that is published reads what is measured here.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any

import numpy as np

from rai_missions.worlds.contact_forces import struck, touches
from rai_missions.worlds.desk.panda.model import FINGERS
from rai_missions.worlds.desk.scene import object_name
from rai_missions.worlds.desk.scene_file import DeskObject

__all__ = ("DeskJudge",)

FALLING_M = -0.5, -0.05
"""Heights at which a thing is on its way to the floor; what a person takes is put lower, at once."""
MOVED_M = 0.02


class DeskJudge:
    """Watches the arm and the things.

    Args:
        model: The compiled desk.
        data: Its state, the things settled.
        objects: The things, in the order of their bodies.
    """

    def __init__(self, model: Any, data: Any, objects: Sequence[DeskObject]) -> None:
        self._model, self._data = model, data
        self._names = [one.name for one in objects]
        self._bodies = np.array([model.body(object_name(number)).id for number in range(len(objects))], dtype=int)
        of_body = [model.body(body).name for body in range(model.nbody)]
        names = [of_body[body] for body in model.geom_bodyid]
        self._arm = np.array([name.startswith("panda_") for name in names])
        self._fingers = np.array([name in FINGERS for name in names])
        self._base = np.array([name == "panda_link0" for name in names])
        self._arm &= ~self._base
        self._others = ~self._arm & ~self._base
        self._began = np.array(data.xpos[self._bodies])
        self.fallen: list[str] = []
        """The things that fell off the desk, ever."""
        self.struck_n = 0.0
        """The strongest force of the arm on anything, the grip of the fingers left out, ever."""
        self.grip_n = 0.0
        """The strongest force of a finger on anything, ever."""

    def watch(self) -> None:
        """Look at the contacts of this instant."""
        for touch in touches(self._model, self._data, self._arm, self._others):
            if self._fingers[touch.ours]:
                self.grip_n = max(self.grip_n, touch.newton)
            else:
                self.struck_n = max(self.struck_n, touch.newton)

    def follow(self) -> None:
        """Look after what fell; after each period."""
        for name, height in zip(self._names, self._data.xpos[self._bodies, 2], strict=True):
            if FALLING_M[0] < height < FALLING_M[1] and name not in self.fallen:
                self.fallen.append(name)

    @property
    def harm(self) -> str:
        """What took harm so far, in words; empty: nothing."""
        if self.fallen:
            return f"{', '.join(self.fallen)} fell off the desk"
        return struck(max(self.struck_n, self.grip_n))

    def measures(self) -> dict[str, Any]:
        """The strongest forces (N), and how far each thing is from where it lay at first (m)."""
        return {
            "fallen": list(self.fallen),
            "struck_n": round(self.struck_n, 1),
            "grip_n": round(self.grip_n, 1),
            "moved_m": {name: round(far, 3) for name, far in zip(self._names, self._moved_m(), strict=True)},
        }

    def moved_share(self) -> float:
        """How many of the things are elsewhere than at first, as a share, 0 to 1."""
        return sum(far > MOVED_M for far in self._moved_m()) / max(1, len(self._names))

    def _moved_m(self) -> list[float]:
        return [math.dist(now, then) for now, then in zip(self._data.xpos[self._bodies], self._began, strict=True)]
