# SPDX-License-Identifier: Apache-2.0
"""Footprints on the desk: convex outlines with rounded corners, and the distance between two.

A box is four corners with a radius of 0, a ball is one point with its radius. Metres.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from functools import lru_cache
from typing import NamedTuple

__all__ = ("Footprint", "Point", "box", "disc", "gap", "overhang", "past_an_end", "turned")

Point = tuple[float, float]
SAME_M = 1e-9
"""Metres below which two distances are the same."""


class Footprint(NamedTuple):
    """What a thing covers of the plane below it."""

    corners: tuple[Point, ...]
    """Of the convex core, in order; one for a disc."""
    radius: float = 0.0
    """How far the outline is from the core."""

    @property
    def centre(self) -> Point:
        """The middle of its corners."""
        count = len(self.corners)
        return sum(x for x, _ in self.corners) / count, sum(y for _, y in self.corners) / count

    def turned(self, yaw: float) -> Footprint:
        """The footprint turned about the origin, counter-clockwise by `yaw` radians."""
        return Footprint(tuple(turned(corner, yaw) for corner in self.corners), self.radius)

    def extent(self, axis: int) -> tuple[float, float]:
        """From where to where it reaches along x (0) or y (1)."""
        along = [corner[axis] for corner in self.corners]
        return min(along) - self.radius, max(along) + self.radius


def turned(point: Point, yaw: float) -> Point:
    """A point turned about the origin, counter-clockwise by `yaw` radians."""
    cos, sin = math.cos(yaw), math.sin(yaw)
    return point[0] * cos - point[1] * sin, point[0] * sin + point[1] * cos


def box(x: float, y: float, size: tuple[float, float], yaw: float = 0.0) -> Footprint:
    """The footprint of a box about its centre, `size` along its own axes."""
    half_x, half_y = size[0] / 2, size[1] / 2
    corners = ((half_x, half_y), (-half_x, half_y), (-half_x, -half_y), (half_x, -half_y))
    return Footprint(tuple((x + u, y + v) for u, v in (turned(corner, yaw) for corner in corners)))


def disc(x: float, y: float, radius: float) -> Footprint:
    """The footprint of a round thing."""
    return Footprint(((x, y),), radius)


@lru_cache(maxsize=8192)
def gap(one: Footprint, other: Footprint) -> float:
    """The free distance between two footprints in metres; negative where they overlap, by how much at least."""
    return _distance(one.corners, other.corners) - one.radius - other.radius


def overhang(inner: Footprint, outer: Footprint) -> float:
    """How far the first reaches beyond the second, a box, in metres; negative where it is inside by that much."""
    return max(
        (corner[0] - start[0]) * normal[0] + (corner[1] - start[1]) * normal[1] + inner.radius
        for start, normal in _normals(outer.corners)
        for corner in inner.corners
    )


def past_an_end(middle: Footprint, one: Footprint, other: Footprint) -> float:
    """How far the first reaches past an end of the line between two others, or its centre lies off it, in metres.

    At most 0 where it lies between the two, on the line, with room on both sides.
    """
    start, end = one.centre, other.centre
    line = (end[0] - start[0], end[1] - start[1])
    if math.hypot(*line) < SAME_M:
        return math.inf
    yaw = -math.atan2(line[1], line[0])
    before, along, after = (each.turned(yaw).extent(0) for each in (one, middle, other))
    off = abs(middle.turned(yaw).centre[1] - turned(start, yaw)[1])
    return max(before[1] - along[0], along[1] - after[0], off)


def _edges(corners: Sequence[Point]) -> Iterator[tuple[Point, Point]]:
    return zip(corners, (*corners[1:], corners[0]), strict=True)


def _normals(corners: Sequence[Point]) -> Iterator[tuple[Point, Point]]:
    """Each edge's start, and the unit vector that points out of a counter-clockwise outline there."""
    for start, end in _edges(corners):
        length = math.dist(start, end)
        if length > 0:
            yield start, ((end[1] - start[1]) / length, (start[0] - end[0]) / length)


def _distance(one: Sequence[Point], other: Sequence[Point]) -> float:
    """Between two convex cores; negative where they overlap: the least depth over all edges (separating axes).

    The nearest points of two that are apart are a corner and the foot of its perpendicular on an edge, or two corners.
    """
    found, is_foot = -math.inf, False
    for corners, others in ((one, other), (other, one)):
        for (start, end), (_, normal) in zip(_edges(corners), _normals(corners), strict=False):
            aways = [(x - start[0]) * normal[0] + (y - start[1]) * normal[1] for x, y in others]
            away = min(aways)
            if away < found - SAME_M:
                continue
            feet = any(
                _is_along(point, start, end) for point, each in zip(others, aways, strict=True) if each <= away + SAME_M
            )
            is_foot = feet or (is_foot and away <= found + SAME_M)
            found = max(found, away)
    if (found >= 0 and not is_foot) or found == -math.inf:
        return min(math.dist(p, q) for p in one for q in other)
    return found


def _is_along(point: Point, start: Point, end: Point) -> bool:
    """Whether the foot of a point's perpendicular on a line is between its two ends."""
    along = (end[0] - start[0], end[1] - start[1])
    share = (point[0] - start[0]) * along[0] + (point[1] - start[1]) * along[1]
    return 0 <= share <= along[0] ** 2 + along[1] ** 2
