# SPDX-License-Identifier: Apache-2.0
"""Boxes that stand on the desk, as the arm plans around them: seen from above, rectangles that overlap or do not."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.worlds.desk.catalogue import KINDS, WALL_M

__all__ = ("SeenThing", "Slab", "overlap", "slabs", "things")


class Slab(NamedTuple):
    """An upright box."""

    x: float
    y: float
    yaw: float
    half_x: float
    half_y: float
    """Half of its extents along its own axes, m."""
    bottom: float
    top: float

    @property
    def radius(self) -> float:
        """The radius of the circle around it, seen from above."""
        return math.hypot(self.half_x, self.half_y)

    def half_along(self, angle: float) -> float:
        """Half of its extent along a direction, seen from above, m."""
        turn = angle - self.yaw
        return self.half_x * abs(math.cos(turn)) + self.half_y * abs(math.sin(turn))


class SeenThing(NamedTuple):
    """A thing as the camera measured it."""

    name: str
    kind: str
    x: float
    y: float
    z: float
    """Of its centre."""
    yaw: float
    size: tuple[float, float, float]

    @property
    def slab(self) -> Slab:
        half = self.size[2] / 2
        return Slab(self.x, self.y, self.yaw, self.size[0] / 2, self.size[1] / 2, self.z - half, self.z + half)

    @property
    def turns(self) -> int:
        """How many turns about z make it look the same in a full one; 0: all do."""
        return KINDS[self.kind].turns if self.kind in KINDS else 1

    @property
    def is_container(self) -> bool:
        return self.kind in KINDS and KINDS[self.kind].is_container


def things(fact: Iterable[Mapping[str, Any]]) -> list[SeenThing]:
    """The things of the fact `objects`."""
    return [_thing(one) for one in fact]


def slabs(seen: Iterable[SeenThing]) -> list[Slab]:
    """What stands, as boxes: a container is its walls, for things go into it."""
    found: list[Slab] = []
    for one in seen:
        found += _walls(one) if one.is_container else [one.slab]
    return found


def overlap(one: Slab, other: Slab, gap: float = 0.0) -> bool:
    """Whether two rectangles, seen from above, are nearer to each other than a gap (by separating axes)."""
    if math.hypot(other.x - one.x, other.y - one.y) > one.radius + other.radius + gap:
        return False
    for angle in (one.yaw, one.yaw + math.pi / 2, other.yaw, other.yaw + math.pi / 2):
        axis = math.cos(angle), math.sin(angle)
        apart = abs((other.x - one.x) * axis[0] + (other.y - one.y) * axis[1])
        if apart > one.half_along(angle) + other.half_along(angle) + gap:
            return False
    return True


def _thing(one: Mapping[str, Any]) -> SeenThing:
    x, y, z, yaw = (float(one[key]) for key in ("x", "y", "z", "yaw"))
    long, broad, high = map(float, one["size"])
    return SeenThing(str(one["name"]), str(one["type"]), x, y, z, yaw, (long, broad, high))


def _walls(one: SeenThing) -> list[Slab]:
    slab, half = one.slab, WALL_M / 2
    cos, sin = math.cos(slab.yaw), math.sin(slab.yaw)
    sides = [(side * (slab.half_x - half), 0.0, half, slab.half_y) for side in (-1, 1)]
    sides += [(0.0, side * (slab.half_y - half), slab.half_x, half) for side in (-1, 1)]
    return [
        Slab(slab.x + cos * x - sin * y, slab.y + sin * x + cos * y, slab.yaw, half_x, half_y, slab.bottom, slab.top)
        for x, y, half_x, half_y in sides
    ]
