# SPDX-License-Identifier: Apache-2.0
"""What can be seen of the obstacles ahead, measured: in pixels of depth and segmentation, or from their bodies.

Rule: a thing is measured where the tractor's width would meet it. How high it is hard there is a radar's measure in
both: it looks through blades and film.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import NamedTuple, Protocol

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.camera import Camera, Frame, Moment, Sight
from rai_missions.worlds.orchard.extents import Extents
from rai_missions.worlds.orchard.tractor import NOSE_M, TractorPose

__all__ = ("RANGE_M", "GeometrySight", "ObstacleMeasures", "ObstacleSight", "PixelSight")

RANGE_M, HALF_WIDTH_M, FEWEST_PIXELS = 10.0, 1.7, 12
MOVED_M = 0.01
PEEKS_OUT = 0.75
"""From its bodies: what is hidden in something higher is seen from this share of that height on."""


class ObstacleMeasures(NamedTuple):
    """Measures of an obstacle that is in sight."""

    distance_m: float
    """From the tractor's nose."""
    height_m: float
    solid_m: float
    """How high it is hard, where wheels or body would meet it."""


Measured = dict[int, ObstacleMeasures]
"""By the obstacle's number."""


class ObstacleSight(Protocol):
    """Measures what is in sight."""

    def seen(self, moment: Moment | None, places: NDArray[np.float64], pose: TractorPose) -> Measured:
        """The obstacles in the tractor's way."""


class PixelSight:
    """Measures in the camera's depth and segmentation; nothing is rendered while nothing has moved.

    Args:
        camera: The front camera.
        bodies: The obstacles' bodies in the model.
        extents: Of the same obstacles, for the radar.
    """

    def __init__(self, camera: Camera, bodies: Sequence[int], extents: Extents) -> None:
        self._camera, self._bodies, self._extents = camera, bodies, extents
        self._last: tuple[NDArray[np.float64], dict[int, tuple[float, float]]] | None = None

    def seen(self, moment: Moment | None, places: NDArray[np.float64], pose: TractorPose) -> Measured:
        assert moment is not None
        measured = self._measured(moment, places, pose)
        return {n: ObstacleMeasures(*what, self._extents.around_m(n, *pose[:3])) for n, what in measured.items()}

    def _measured(
        self, moment: Moment, places: NDArray[np.float64], pose: TractorPose
    ) -> dict[int, tuple[float, float]]:
        key = np.append(places.ravel(), pose[:3])
        if self._last is not None and np.allclose(self._last[0], key, rtol=0, atol=MOVED_M):
            return self._last[1]
        frame, view = self._camera.frame(moment)
        found = {n: what for n in range(len(self._bodies)) if (what := self._extent(n, frame, view, pose)) is not None}
        self._last = key, found
        return found

    def _extent(self, number: int, frame: Frame, view: Sight, pose: TractorPose) -> tuple[float, float] | None:
        rows, columns = np.nonzero(frame.body == self._bodies[number])
        if len(rows) < FEWEST_PIXELS:
            return None
        height, width = frame.body.shape
        depth = frame.depth_m[rows, columns]
        right, up = (columns + 0.5 - width / 2) / view.focal_px, (height / 2 - rows - 0.5) / view.focal_px
        points = view.position + (np.stack([right * depth, up * depth, -depth], 1) @ view.axes.T)
        ahead = (points[:, 0] - pose.x) * math.cos(pose.heading) + (points[:, 1] - pose.y) * math.sin(pose.heading)
        aside = (points[:, 1] - pose.y) * math.cos(pose.heading) - (points[:, 0] - pose.x) * math.sin(pose.heading)
        in_way = np.abs(aside) < HALF_WIDTH_M
        if np.count_nonzero(in_way) < FEWEST_PIXELS:
            return None
        distance = float(np.percentile(ahead[in_way], 3)) - NOSE_M
        return (distance, float(np.percentile(points[in_way, 2], 99))) if distance < RANGE_M else None


class GeometrySight:
    """Measures from the bodies themselves: without a camera, in microseconds.

    Args:
        extents: Of the obstacles.
        count: How many there are.
    """

    def __init__(self, extents: Extents, count: int) -> None:
        self._extents, self._count = extents, count

    def seen(self, moment: Moment | None, places: NDArray[np.float64], pose: TractorPose) -> Measured:
        inside = [n for n in range(self._count) if self._is_in_way(n, pose)]
        seen = [n for n in inside if not any(self._hides(other, n, pose) for other in inside if other != n)]
        return {
            n: ObstacleMeasures(
                self._extents.reach(n, _ahead(pose))[0] - _along(pose),
                self._extents.top_m(n),
                self._extents.around_m(n, *pose[:3]),
            )
            for n in seen
        }

    def _is_in_way(self, number: int, pose: TractorPose) -> bool:
        near, far = self._extents.reach(number, _ahead(pose))
        right, left = self._extents.reach(number, (-math.sin(pose.heading), math.cos(pose.heading)))
        middle = pose.y * math.cos(pose.heading) - pose.x * math.sin(pose.heading)
        is_ahead = far > _along(pose) and near - _along(pose) < RANGE_M
        return is_ahead and right - middle < HALF_WIDTH_M and left - middle > -HALF_WIDTH_M

    def _hides(self, cover: int, number: int, pose: TractorPose) -> bool:
        """Whether one obstacle lies inside another that is higher."""
        ours, theirs = (self._extents.reach(n, _ahead(pose)) for n in (number, cover))
        is_inside = theirs[0] <= ours[0] + 0.3 and ours[1] - 0.3 <= theirs[1]
        return is_inside and self._extents.top_m(number) < PEEKS_OUT * self._extents.top_m(cover)


def _ahead(pose: TractorPose) -> tuple[float, float]:
    return math.cos(pose.heading), math.sin(pose.heading)


def _along(pose: TractorPose) -> float:
    """Where the tractor's nose is, along its way."""
    return pose.x * math.cos(pose.heading) + pose.y * math.sin(pose.heading) + NOSE_M
