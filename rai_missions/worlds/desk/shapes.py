# SPDX-License-Identifier: Apache-2.0
"""The outer shape of each kind of thing: corners for its silhouette, and how far a point is from its surface.

Rule: shapes are knowledge about a kind, as a maker's drawing is; they carry nothing of where a thing is.
"""

from __future__ import annotations

from functools import cache

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.desk.catalogue import CARROT, CORN, CORN_HUSK, KINDS, Profile, carrot_leaves
from rai_missions.worlds.meshes import icosphere

__all__ = ("corners", "outside_m")

Points = NDArray[np.float64]
SIDES = 16


@cache
def corners(kind: str) -> Points:
    """Points whose convex hull is the thing, in its own frame, m."""
    half = np.array(KINDS[kind].size) / 2
    if kind in ("apple", "tomato"):
        return icosphere(2)[0] * half
    if kind == "carrot":
        return np.concatenate([_spun(CARROT), carrot_leaves().points])
    if kind == "corn":
        return np.concatenate([_spun(CORN), _spun(CORN_HUSK)])
    signs = np.stack(np.meshgrid((-1, 1), (-1, 1), (-1, 1), indexing="ij"), -1).reshape(-1, 3)
    return signs * half


def outside_m(kind: str, points: Points, camera: Points) -> Points | None:
    """How far points that a camera sees are outside of a thing's surface, m; None where it is hollow.

    Args:
        kind: Of `KINDS`.
        points: In the thing's own frame, m; as many axes as there are before the last one.
        camera: Where the camera is in that frame: of a cube, it sees the faces that look its way.
    """
    half = np.array(KINDS[kind].size) / 2
    if KINDS[kind].is_container:
        return None
    if kind == "cube":
        outside: Points = np.max(points * np.sign(camera) - half, axis=-1)
        return outside
    if kind in ("apple", "tomato"):
        away: Points = (np.linalg.norm(points / half, axis=-1) - 1) * half.mean()
        return away
    profile = np.array(CARROT if kind == "carrot" else (*CORN[:5], *CORN_HUSK[1:]))
    radii: Points = np.hypot(points[..., 1], points[..., 2]) - np.interp(points[..., 0], profile[:, 0], profile[:, 1])
    return radii


def _spun(profile: Profile) -> Points:
    turns = np.arange(SIDES) * 2 * np.pi / SIDES
    return np.array([(x, radius * np.cos(turn), radius * np.sin(turn)) for x, radius in profile for turn in turns])
