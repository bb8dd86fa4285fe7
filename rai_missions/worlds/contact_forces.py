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
    """One contact."""

    ours: int
    """The geom of the first set."""
    theirs: int
    """The geom of the second set."""
    newton: float
    """Along the contact's normal, N."""


def struck(newton: float) -> str:
    """What a body took harm from, in words, where it was pressed with so many newtons; empty: it took none."""
    return f"struck something with {newton:.0f} N" if newton > STRUCK_N else ""


def touches(model: Any, data: Any, ours: NDArray[np.bool_], theirs: NDArray[np.bool_]) -> list[Touch]:
    """The contacts between two sets of geoms at this instant.

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
    found, force = [], np.zeros(6)
    for index in np.flatnonzero((ours[first] & theirs[second]) | (ours[second] & theirs[first])):
        mujoco.mj_contactForce(model, data, int(index), force)
        a, b = (int(geom) for geom in pairs[index])
        found.append(Touch(*((a, b) if ours[a] and theirs[b] else (b, a)), float(force[0])))
    return found
