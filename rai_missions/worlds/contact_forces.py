# SPDX-License-Identifier: Apache-2.0
"""Forces between two sets of geoms, for the judges of the worlds."""

from __future__ import annotations

from typing import Any, NamedTuple

import mujoco
import numpy as np
from numpy.typing import NDArray

__all__ = ("Touch", "struck", "touches")

STRUCK_N = 140.0
"""What is pressed with more is harmed: what ISO/TS 15066, table A.2, permits on a hand, the strictest but the face."""


class Touch(NamedTuple):
    """What one body presses on another with, over all their contacts; of what is fixed, each geom is a body."""

    ours: int
    """A geom of the first body, in the first set."""
    theirs: int
    """A geom of the second body, in the second set."""
    newton: float
    """The sum of the forces along the contacts' normals, as vectors, N."""


def struck(newton: float) -> str:
    """What a body took harm from, in words, where it was pressed with so many newtons; empty: it took none."""
    return f"struck something with {newton:.0f} N" if newton > STRUCK_N else ""


def touches(model: Any, data: Any, ours: NDArray[np.bool_], theirs: NDArray[np.bool_]) -> list[Touch]:
    """What bodies of one set of geoms press on bodies of another set with, at this instant.

    Args:
        model: Compiled.
        data: Its state.
        ours: For each geom of the model, whether it is of the first set.
        theirs: The same of the second set.
    """
    pairs = data.contact.geom
    if len(pairs) == 0:
        return []
    first, second = pairs[:, 0], pairs[:, 1]
    found: dict[tuple[int, int], Touch] = {}
    sums: dict[tuple[int, int], NDArray[np.float64]] = {}
    force = np.zeros(6)
    for index in np.flatnonzero((ours[first] & theirs[second]) | (ours[second] & theirs[first])):
        mujoco.mj_contactForce(model, data, int(index), force)
        a, b = (int(geom) for geom in pairs[index])
        is_first = ours[a] and theirs[b]
        mine, other = (a, b) if is_first else (b, a)
        bodies = int(model.geom_bodyid[mine]), int(model.geom_bodyid[other]) or -other
        normal = data.contact.frame[index, :3] if is_first else -data.contact.frame[index, :3]
        sums[bodies] = sums.get(bodies, 0.0) + force[0] * normal
        found.setdefault(bodies, Touch(mine, other, 0.0))
    return [each._replace(newton=float(np.linalg.norm(sums[bodies]))) for bodies, each in found.items()]
