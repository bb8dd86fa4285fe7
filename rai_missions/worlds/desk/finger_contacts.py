# SPDX-License-Identifier: Apache-2.0
"""What both fingers touch, by the contacts of the simulation: read each period, so without the rest of the truth."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from rai_missions.worlds.desk.scene import object_name
from rai_missions.worlds.desk.scene_file import DeskObject

__all__ = ("TOUCHING_M", "FingerContacts")

TOUCHING_M = 0.0005
"""A contact that is farther away touches nothing."""


class FingerContacts:
    """The bodies of one model.

    Args:
        model: Compiled.
        objects: The things, in the order of their bodies.
    """

    def __init__(self, model: Any, objects: Sequence[DeskObject]) -> None:
        self._names = [one.name for one in objects]
        of_body = np.full(model.nbody, -1)
        for number in range(len(objects)):
            of_body[model.body(object_name(number)).id] = number
        fingers = [body for body in range(model.nbody) if "finger" in model.body(body).name and of_body[body] < 0]
        marks = np.zeros(model.nbody, dtype=int)
        marks[fingers] = [1 << place for place in range(len(fingers))]
        self._thing, self._finger = of_body[model.geom_bodyid], marks[model.geom_bodyid]

    def held(self, data: Any) -> str:
        """The first thing that two fingers touch; else empty."""
        contacts = data.contact
        pairs = contacts.geom
        if len(pairs) == 0:
            return ""
        fingers = self._finger[pairs]
        touched: dict[int, int] = {}
        for at in np.flatnonzero(fingers.any(axis=1)):
            thing = int(self._thing[pairs[at]].max())
            if thing >= 0 and contacts.dist[at] <= TOUCHING_M:
                touched[thing] = touched.get(thing, 0) | int(fingers[at].sum())
        both = [thing for thing, found in touched.items() if found.bit_count() > 1]
        return self._names[min(both)] if both else ""
