# SPDX-License-Identifier: Apache-2.0
"""How certain it is that a thing is there: what several looks from one place agree on.

Rule: certainty is a count, never a detector's own score. After `agreeing` of `looks` looks it is Laplace's rule of
succession, (agreeing + 1) / (looks + 2): how likely it is that the next look agrees.
"""

from __future__ import annotations

import math
import statistics
from collections import deque
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from rai_missions.worlds.perception.projection import MapPoint

__all__ = ("AgreedObject", "Looks", "Sighting")

MOST = 8
"""Looks that count, the newest."""
LIKELY = 0.5
SAME_M = 0.35
"""Two sightings so near each other are of one thing."""


class Sighting(NamedTuple):
    """What one look showed of one thing."""

    name: str
    place: MapPoint
    score: float


class AgreedObject(NamedTuple):
    """One thing, as the looks agree on it."""

    name: str
    place: MapPoint
    """The median of the sightings; its distance is that of the newest."""
    score: float
    """The detector's mean."""
    agreeing: int
    looks: int
    certainty: float


class Looks:
    """The last looks from one place."""

    def __init__(self) -> None:
        self._looks: deque[tuple[Sighting, ...]] = deque(maxlen=MOST)

    def clear(self) -> None:
        """The robot moved, or something else is looked for: earlier looks count no more."""
        self._looks.clear()

    def add(self, sightings: Iterable[Sighting]) -> None:
        self._looks.append(tuple(sightings))

    def __len__(self) -> int:
        return len(self._looks)

    def seen(self) -> list[AgreedObject]:
        """What the newest look shows, with what the others agree on; the most certain first."""
        if not self._looks:
            return []
        return _ordered(self._agreed(sighting) for sighting in self._looks[-1])

    def agreed(self) -> list[AgreedObject]:
        """What the looks agree on so that the next is likelier to show it than not; the most certain first."""
        found: list[AgreedObject] = []
        for sighting in (one for look in reversed(self._looks) for one in look):
            if not any(one.name == sighting.name and _is_same(one.place, sighting.place) for one in found):
                found.append(self._agreed(sighting))
        return _ordered(one for one in found if one.certainty >= LIKELY)

    def _agreed(self, newest: Sighting) -> AgreedObject:
        same = [near for look in self._looks if (near := _nearest(newest, look)) is not None]
        x, y, z = (statistics.median(one.place[axis] for one in same) for axis in range(3))
        score = statistics.fmean(one.score for one in same)
        certainty = (len(same) + 1) / (len(self._looks) + 2)
        place = MapPoint(x, y, z, newest.place.distance_m)
        return AgreedObject(newest.name, place, score, len(same), len(self._looks), certainty)


def _nearest(to: Sighting, look: Sequence[Sighting]) -> Sighting | None:
    near = [one for one in look if one.name == to.name and _is_same(one.place, to.place)]
    return min(near, key=lambda one: math.dist(one.place[:3], to.place[:3]), default=None)


def _is_same(one: MapPoint, other: MapPoint) -> bool:
    return math.dist(one[:3], other[:3]) <= SAME_M


def _ordered(found: Iterable[AgreedObject]) -> list[AgreedObject]:
    return sorted(found, key=lambda one: (-one.certainty, one.place.distance_m, one.name))
