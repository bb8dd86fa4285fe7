# SPDX-License-Identifier: Apache-2.0
"""What follows from a URDF as a whole: how long, wide and high the robot is, and how fast its wheels let it drive.

Source: the URDF XML specification: an origin turns by roll, pitch and yaw about fixed axes, then moves.
Rule: what does not follow is None; a mesh has a size that is not read.
"""

from __future__ import annotations

import math
from collections import defaultdict
from collections.abc import Iterator

from rai_missions.embodiment.urdf import Body, BodyJoint, BodyLink, BodyShape

__all__ = ("size_m", "speed_m_s")

Vector = tuple[float, ...]
Turn = tuple[Vector, Vector, Vector]
"""A rotation, row by row."""
NOWHERE: Vector = (0.0, 0.0, 0.0)
STRAIGHT: Turn = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))


def size_m(body: Body) -> tuple[float, float, float] | None:
    """Length, width and height of the box around all that it may collide with, its joints at zero; None: not known."""
    places = _places(body)
    solid = [(shape, places[link.name]) for link in body.links for shape in link.shapes if shape.use == "collision"]
    if not solid or any(shape.kind == "mesh" for shape, _ in solid):
        return None
    bounds = [_bounds(shape, *place) for shape, place in solid]
    x, y, z = (max(high[axis] for _, high in bounds) - min(low[axis] for low, _ in bounds) for axis in range(3))
    return x, y, z


def speed_m_s(body: Body) -> float | None:
    """How fast it can drive where the slowest of its wheels has its limit; None: no wheel has one."""
    links = {link.name: link for link in body.links}
    driven = [
        joint.velocity * radius
        for joint in body.joints
        if joint.kind == "continuous" and joint.velocity is not None
        for radius in _radii(links.get(joint.child))
    ]
    return min(driven, default=None)


def _radii(link: BodyLink | None) -> Iterator[float]:
    for shape in link.shapes if link is not None else ():
        if shape.use == "collision" and shape.kind in ("cylinder", "sphere"):
            yield shape.measures_m[0]


def _places(body: Body) -> dict[str, tuple[Turn, Vector]]:
    """How each link is turned and where it is, in the root."""
    below = defaultdict[str, list[BodyJoint]](list)
    for joint in body.joints:
        below[joint.parent].append(joint)
    reached = list({link.name for link in body.links} - {joint.child for joint in body.joints})
    found = dict.fromkeys(reached, (STRAIGHT, NOWHERE))
    for name in reached:
        turn, at = found[name]
        for joint in below[name]:
            found[joint.child] = _after(turn, _turn(joint.rpy)), _sum(at, _turned(turn, joint.origin_m))
            reached.append(joint.child)
    return found


def _bounds(shape: BodyShape, turn: Turn, at: Vector) -> tuple[Vector, Vector]:
    """The lowest and the highest corner of the box around a shape."""
    middle = _sum(at, _turned(turn, shape.origin_m))
    own = _after(turn, _turn(shape.rpy))
    half = tuple(_half(shape, own[axis]) for axis in range(3))
    return tuple(m - h for m, h in zip(middle, half, strict=True)), _sum(middle, half)


def _half(shape: BodyShape, row: Vector) -> float:
    """How far a shape reaches from its middle along one axis, in which its own axes have these shares."""
    if shape.kind == "box":
        return math.fsum(abs(share) * edge / 2 for share, edge in zip(row, shape.measures_m, strict=True))
    if shape.kind == "sphere":
        return shape.measures_m[0]
    radius, length = shape.measures_m
    return abs(row[2]) * length / 2 + math.hypot(row[0], row[1]) * radius


def _turn(rpy: Vector) -> Turn:
    (sr, sp, sy), (cr, cp, cy) = (tuple(map(each, rpy)) for each in (math.sin, math.cos))
    return (
        (cy * cp, cy * sp * sr - sy * cr, cy * sp * cr + sy * sr),
        (sy * cp, sy * sp * sr + cy * cr, sy * sp * cr - cy * sr),
        (-sp, cp * sr, cp * cr),
    )


def _turned(turn: Turn, vector: Vector) -> Vector:
    return tuple(math.fsum(a * b for a, b in zip(row, vector, strict=True)) for row in turn)


def _after(first: Turn, second: Turn) -> Turn:
    columns = tuple(zip(*second, strict=True))
    one, two, three = (
        tuple(math.fsum(a * b for a, b in zip(row, each, strict=True)) for each in columns) for row in first
    )
    return one, two, three


def _sum(one: Vector, other: Vector) -> Vector:
    return tuple(a + b for a, b in zip(one, other, strict=True))
