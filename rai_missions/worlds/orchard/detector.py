# SPDX-License-Identifier: Apache-2.0
"""Turns what the robot senses into facts about the nearest obstacle in the alley ahead: what, how far, how high, alive?

Rule: distance and height are measured (`sight.py`), so what cannot be seen, the detector does not know. Its errors come
from the seed, and what it states about its own doubt comes from its errors and its looks alone.
"""

from __future__ import annotations

import math
import random
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.camera import Moment
from rai_missions.worlds.options import check_numbers
from rai_missions.worlds.orchard.kinds import KINDS, LIVING
from rai_missions.worlds.orchard.obstacles import Obstacle
from rai_missions.worlds.orchard.sight import RANGE_M, ObstacleMeasures, ObstacleSight
from rai_missions.worlds.orchard.tractor import NOSE_M, TractorPose

__all__ = ("ObstacleDetector", "ObstacleErrors")

FLOOR_M = 0.01
"""Standard deviation of the height of what is hard, where there is hardly any."""
SIGMAS = 4.0
"""The upper bound of a height is passed by the true one in 1 of 30,000 cases."""
LIVING_SHARE = 0.15
"""What seemed alive in more than this share of the looks is reported as alive."""


@dataclass(frozen=True)
class ObstacleErrors:
    """How a detector errs."""

    noise: float = 0.02
    """Standard deviation of distance and height, as a share of them, from look to look."""
    miss: float = 0.0
    """How often an obstacle that is there is not reported, 0 to 1."""
    misclassify: float = 0.0
    """How often an obstacle is taken for something else, 0 to 1; decided again each time that one comes into sight."""
    confuse: float = 0.0
    """How often a look takes an obstacle for what its kind looks like, 0 to 1; decided again in each look."""
    false_alarm: float = 0.0
    """How often something is reported where nothing is, 0 to 1, a look."""

    @classmethod
    def of(cls, options: Mapping[str, Any] | ObstacleErrors | None) -> ObstacleErrors:
        """From plain data; a `UsageError` names what does not exist or is out of range."""
        if isinstance(options, ObstacleErrors):
            return options
        check_numbers("detector", options or {}, {field.name: 1.0 for field in fields(cls)} | {"noise": 100.0})
        return cls(**(options or {}))


@dataclass
class ObstacleLooks:
    """What was made of one obstacle since it came into sight."""

    taken_for: str
    kinds: Counter[str] = field(default_factory=Counter)
    solid_m: list[float] = field(default_factory=list)

    @property
    def kind(self) -> str:
        """What it seemed to be most often; of equals, what it seemed to be first."""
        return self.kinds.most_common(1)[0][0]

    @property
    def sure(self) -> float:
        """The share of looks that agree, less one look: 0 at the first."""
        return max(0.0, (self.kinds[self.kind] - 1) / self.kinds.total())

    @property
    def living(self) -> bool:
        return sum(self.kinds[kind] for kind in LIVING) / self.kinds.total() > LIVING_SHARE

    def solid_max_m(self, noise: float) -> float:
        """The upper bound of the height of what is hard: `SIGMAS` standard deviations of the mean above it.

        A look is h (1 + noise g) + FLOOR_M g', with g and g' standard normal, so the standard deviation of the mean m
        of n looks is at most (noise h + FLOOR_M) / sqrt(n), and h < (m + k FLOOR_M) / (1 - k noise) with
        k = SIGMAS / sqrt(n). Too few looks for that give infinity.
        """
        k = SIGMAS / math.sqrt(len(self.solid_m))
        mean = sum(self.solid_m) / len(self.solid_m)
        return (max(0.0, mean) + k * FLOOR_M) / (1 - k * noise) if k * noise < 1 else math.inf


class ObstacleDetector:
    """Reports the nearest obstacle, look by look.

    Args:
        sight: Measures what can be seen.
        obstacles: What there is.
        errors: How it errs.
        seed: Where its errors come from.
    """

    def __init__(self, sight: ObstacleSight, obstacles: Sequence[Obstacle], errors: ObstacleErrors, seed: int) -> None:
        self._sight, self._obstacles, self._errors = sight, obstacles, errors
        self._random = random.Random(f"detector {seed}")
        self._looks: dict[int, ObstacleLooks] = {}

    def look_by(self, sight: ObstacleSight) -> None:
        """Measure in another way from now on; what was made of earlier looks stays."""
        self._sight = sight

    def look(self, moment: Moment | None, places: NDArray[np.float64], pose: TractorPose) -> dict[str, Any] | None:
        """The nearest obstacle in the tractor's way, as it seems; None: the way looks free.

        Args:
            moment: What there is to see; None where no camera looks.
            places: Where the obstacles are (for a cheap look whether any may be in sight), a row each.
            pose: Where the tractor is.
        """
        seen = self._sight.seen(moment, places, pose) if self._may_see(places, pose) else {}
        for number in set(self._looks) - set(seen):
            del self._looks[number]
        if not seen:
            return self._imagined()
        number = min(seen, key=lambda n: seen[n].distance_m)
        looks = self._looks.setdefault(number, ObstacleLooks(self._kind(number)))
        if self._random.random() < self._errors.miss:
            return None
        self._note(looks, seen[number], [self._obstacles[n].kind for n in seen if n != number])
        return self._fact(looks, seen[number])

    def _note(self, looks: ObstacleLooks, seen: ObstacleMeasures, others: list[str]) -> None:
        kind, errors = looks.taken_for, self._errors
        if errors.confuse and self._random.random() < errors.confuse:
            kind = KINDS[kind].looks_like
        alive = next((other for other in others if other in LIVING), kind)
        looks.kinds[alive if kind not in LIVING else kind] += 1
        noise = 1 + self._random.gauss(0, errors.noise)
        looks.solid_m.append(seen.solid_m * noise + self._random.gauss(0, FLOOR_M))

    def _may_see(self, places: NDArray[np.float64], pose: TractorPose) -> bool:
        if len(places) == 0:
            return False
        dx, dy = places[:, 0] - pose.x, places[:, 1] - pose.y
        ahead = dx * math.cos(pose.heading) + dy * math.sin(pose.heading) - NOSE_M
        aside = np.abs(dy * math.cos(pose.heading) - dx * math.sin(pose.heading))
        return bool(np.any((ahead > -2) & (ahead < RANGE_M + 1) & (aside < 2.5)))

    def _kind(self, number: int) -> str:
        kind = self._obstacles[number].kind
        if self._random.random() < self._errors.misclassify:
            return self._random.choice([other for other in KINDS if other != kind])
        return kind

    def _fact(self, looks: ObstacleLooks, seen: ObstacleMeasures) -> dict[str, Any]:
        def blurred(value: float) -> float:
            return round(max(0.0, value * (1 + self._random.gauss(0, self._errors.noise))), 3)

        bound = looks.solid_max_m(self._errors.noise)
        return {
            "kind": looks.kind,
            "distance_m": blurred(seen.distance_m),
            "height_m": blurred(seen.height_m),
            "living": looks.living,
            "solid_m": round(max(0.0, sum(looks.solid_m) / len(looks.solid_m)), 3),
            "solid_max_m": round(min(bound, 9.999), 3),
            "sure": round(looks.sure, 3),
        }

    def _imagined(self) -> dict[str, Any] | None:
        if not self._errors.false_alarm or self._random.random() >= self._errors.false_alarm:
            return None
        high = self._random.uniform(0.1, 1)
        looks = ObstacleLooks(self._random.choice(list(KINDS)))
        self._note(looks, ObstacleMeasures(0.0, high, high), [])
        return self._fact(looks, ObstacleMeasures(self._random.uniform(3, 8), high, high))
