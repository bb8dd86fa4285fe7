# SPDX-License-Identifier: Apache-2.0
"""The pose of a thing out of its outlines: it is found again, and poses that are compared are tried at once."""

from __future__ import annotations

import sys
from types import FrameType

import numpy as np
import pytest
from numpy.typing import NDArray

from rai_missions.worlds.camera import Sight
from rai_missions.worlds.desk.catalogue import KINDS
from rai_missions.worlds.desk.posture import about_z
from rai_missions.worlds.desk.shapes import corners
from rai_missions.worlds.desk.silhouette import WAYS, ContourInFrame, Fit, fit, project

pytestmark = pytest.mark.sim
PLACE = (0.45, 0.1)
SIZE = (480, 640)


def sight(*position: float) -> Sight:
    """A camera that looks at the middle of the desk."""
    back = np.array(position) - (0.45, 0.0, 0.0)
    back /= np.linalg.norm(back)
    right = np.cross((0.0, 1.0, 0.0), back)
    right /= np.linalg.norm(right)
    return Sight(np.array(position), np.stack([right, np.cross(back, right), back], 1), 600.0)


def contour(kind: str, yaw: float, seen_from: Sight) -> ContourInFrame:
    """A thing's outline without noise, and the points of its surface that are its corners."""
    points: NDArray[np.float64] = corners(kind) @ about_z(yaw).T + (*PLACE, KINDS[kind].size[2] / 2)
    pixels, depth = project(points, seen_from, SIZE)
    nearest = points[np.argsort(depth)[: max(4, len(points) // 3)]]
    top_m = float(np.quantile(points[:, 2], 0.97))
    return ContourInFrame(seen_from, SIZE, np.max(pixels @ WAYS, axis=0), np.ones(WAYS.shape[1], bool), nearest, top_m)


def found(kind: str, yaw: float) -> tuple[Fit, float]:
    """A fit, and how many times an outline was held against shapes for it, a camera."""
    outlines = [contour(kind, yaw, sight(0.25, -0.5, 0.7)), contour(kind, yaw, sight(0.7, 0.3, 0.8))]
    projections = 0

    def count(frame: FrameType, event: str, _: object) -> None:
        nonlocal projections
        projections += event == "call" and frame.f_code is project.__code__

    sys.setprofile(count)
    try:
        return fit(kind, outlines), projections / len(outlines)
    finally:
        sys.setprofile(None)


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_a_thing_is_found_where_its_outlines_are(kind: str) -> None:
    one, _ = found(kind, 0.3)
    assert np.hypot(one.x - PLACE[0], one.y - PLACE[1]) < 0.003
    turns = KINDS[kind].turns
    assert turns == 0 or abs(np.sin((one.yaw - 0.3) * turns / 2)) < 0.05 * turns


@pytest.mark.parametrize("kind", sorted(KINDS))
def test_poses_that_are_compared_are_tried_at_once(kind: str) -> None:
    starts = 2 if kind == "cube" or KINDS[kind].turns == 1 else 1
    assert found(kind, 0.3)[1] <= starts * (1 + 8) + 4  # the yaws and eight rounds each; the choice, and how good it is
