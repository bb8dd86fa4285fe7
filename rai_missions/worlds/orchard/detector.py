# SPDX-License-Identifier: Apache-2.0
"""Turns what the camera sees into facts about the nearest obstacle in the alley ahead: what, how far, how high, alive?

Rule: distance and height are measured in pixels of depth and segmentation, so what the camera cannot see, the detector
does not know. Its errors come from the seed.
"""

from __future__ import annotations

import math
import random
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rai_missions.errors import UsageError
from rai_missions.worlds.camera import Camera, Frame, Moment, Sight
from rai_missions.worlds.orchard.bodies import FIGURES, LIVING
from rai_missions.worlds.orchard.obstacles import Obstacle
from rai_missions.worlds.orchard.tractor import NOSE_M, TractorPose

__all__ = ("Detector", "Errors")

RANGE_M, HALF_WIDTH_M, FEWEST_PIXELS = 10.0, 1.7, 12
MOVED_M = 0.01


@dataclass(frozen=True)
class Errors:
    """How a detector errs."""

    noise: float = 0.02
    """Standard deviation of distance and height, as a share of them."""
    miss: float = 0.0
    """How often an obstacle that is there is not reported, 0 to 1."""
    misclassify: float = 0.0
    """How often an obstacle is taken for something else, 0 to 1; decided again each time that one comes into sight."""
    false_alarm: float = 0.0
    """How often something is reported where nothing is, 0 to 1, a look."""

    @classmethod
    def of(cls, options: Mapping[str, Any] | Errors | None) -> Errors:
        """From plain data; a `UsageError` names what does not exist."""
        if isinstance(options, Errors):
            return options
        known = [field.name for field in fields(cls)]
        unknown = sorted(set(options or {}) - set(known))
        if unknown:
            raise UsageError(f"detector: no option {unknown[0]!r}; there are: {', '.join(known)}")
        return cls(**(options or {}))


class Detector:
    """Looks through the camera when something may be near.

    Args:
        camera: The front camera.
        bodies: The obstacles' bodies in the model.
        obstacles: What they are.
        errors: How it errs.
        seed: Where its errors come from.
    """

    def __init__(
        self, camera: Camera, bodies: Sequence[int], obstacles: Sequence[Obstacle], errors: Errors, seed: int
    ) -> None:
        self._camera, self._bodies, self._obstacles, self._errors = camera, bodies, obstacles, errors
        self._random = random.Random(f"detector {seed}")
        self._taken_for: dict[int, str] = {}
        self._last: tuple[NDArray[np.float64], dict[int, tuple[float, float]]] | None = None

    def look(self, moment: Moment, places: NDArray[np.float64], pose: TractorPose) -> dict[str, Any] | None:
        """The nearest obstacle in the tractor's way, as it seems; None: the way looks free.

        Args:
            moment: What there is to see.
            places: Where the obstacles are (for a cheap look whether any may be in sight), a row each.
            pose: Where the tractor is.
        """
        seen = self._measured(moment, places, pose) if self._may_see(places, pose) else {}
        for number in set(self._taken_for) - set(seen):
            del self._taken_for[number]
        if not seen:
            return self._imagined()
        number = min(seen, key=lambda n: seen[n][0])
        kind = self._taken_for.setdefault(number, self._kind(number))
        if self._random.random() < self._errors.miss:
            return None
        return self._fact(kind, *seen[number])

    def _may_see(self, places: NDArray[np.float64], pose: TractorPose) -> bool:
        if len(places) == 0:
            return False
        dx, dy = places[:, 0] - pose.x, places[:, 1] - pose.y
        ahead = dx * math.cos(pose.heading) + dy * math.sin(pose.heading) - NOSE_M
        aside = np.abs(dy * math.cos(pose.heading) - dx * math.sin(pose.heading))
        return bool(np.any((ahead > -2) & (ahead < RANGE_M + 1) & (aside < 2.5)))

    def _measured(
        self, moment: Moment, places: NDArray[np.float64], pose: TractorPose
    ) -> dict[int, tuple[float, float]]:
        """Distance and height of what is in sight; nothing is rendered while nothing has moved."""
        key = np.append(places.ravel(), pose[:3])
        if self._last is not None and np.allclose(self._last[0], key, rtol=0, atol=MOVED_M):
            return self._last[1]
        frame, sight = self._camera.frame(moment)
        found = {n: what for n in range(len(self._bodies)) if (what := self._extent(n, frame, sight, pose)) is not None}
        self._last = key, found
        return found

    def _extent(self, number: int, frame: Frame, sight: Sight, pose: TractorPose) -> tuple[float, float] | None:
        rows, columns = np.nonzero(frame.body == self._bodies[number])
        if len(rows) < FEWEST_PIXELS:
            return None
        height, width = frame.body.shape
        depth = frame.depth_m[rows, columns]
        right, up = (columns + 0.5 - width / 2) / sight.focal_px, (height / 2 - rows - 0.5) / sight.focal_px
        points = sight.position + (np.stack([right * depth, up * depth, -depth], 1) @ sight.axes.T)
        ahead = (points[:, 0] - pose.x) * math.cos(pose.heading) + (points[:, 1] - pose.y) * math.sin(pose.heading)
        aside = (points[:, 1] - pose.y) * math.cos(pose.heading) - (points[:, 0] - pose.x) * math.sin(pose.heading)
        in_way = np.abs(aside) < HALF_WIDTH_M
        if np.count_nonzero(in_way) < FEWEST_PIXELS:
            return None
        distance = float(np.percentile(ahead[in_way], 3)) - NOSE_M
        return (distance, float(np.percentile(points[in_way, 2], 99))) if distance < RANGE_M else None

    def _kind(self, number: int) -> str:
        kind = self._obstacles[number].kind
        if self._random.random() < self._errors.misclassify:
            return self._random.choice([other for other in FIGURES if other != kind])
        return kind

    def _fact(self, kind: str, distance_m: float, height_m: float) -> dict[str, Any]:
        def blurred(value: float) -> float:
            return round(max(0.0, value * (1 + self._random.gauss(0, self._errors.noise))), 3)

        return {
            "kind": kind,
            "distance_m": blurred(distance_m),
            "height_m": blurred(height_m),
            "living": kind in LIVING,
        }

    def _imagined(self) -> dict[str, Any] | None:
        if self._errors.false_alarm and self._random.random() < self._errors.false_alarm:
            return self._fact(
                self._random.choice(list(FIGURES)), self._random.uniform(3, 8), self._random.uniform(0.1, 1)
            )
        return None
