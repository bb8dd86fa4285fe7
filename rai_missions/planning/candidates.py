# SPDX-License-Identifier: Apache-2.0
"""Places that a thing may be tried at: around another, to its left or right, in a container.

Each is a sequence in a fixed order, the most promising first; whether a place is free is asked by the search.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import product

from rai_missions.planning.geometry import Point, gap, turned
from rai_missions.planning.goal import Beyond
from rai_missions.planning.relations import inner
from rai_missions.planning.scene import Thing

__all__ = (
    "LEAST_M",
    "SLACK_M",
    "about_a_place",
    "aligned",
    "amid",
    "around",
    "at_an_end",
    "from_a_corner",
    "from_the_middle",
    "packed",
    "to_a_side",
)

LEAST_M = 0.004
"""Metres between two footprints, whatever their heights."""
SLACK_M = 0.0003
"""What rounding may take from a clearance, or from the room between two things, metres."""
DIRECTIONS = 16
NEARBY_M = (0.004, 0.008, 0.012)
"""How far from a place that was named a thing may be put, with room to spare for an arm that is not exact, metres."""
STEP_IN_M = 0.012
"""The raster of places in a container."""
QUARTERS = (0.0, math.pi / 2)
"""Lengthwise and across."""


def around(thing: Thing, partner: Thing, clearance: float) -> Iterator[Thing]:
    """Places on the desk at one free distance round another thing, the one on its own side first.

    Args:
        thing: Where it is now.
        partner: Where the other will be.
        clearance: Metres that are to be free between them.
    """
    towards = math.atan2(thing.y - partner.y, thing.x - partner.x)
    away = (math.hypot(*thing.size[:2]) + math.hypot(*partner.size[:2])) / 2
    for turn in sorted(range(DIRECTIONS), key=lambda each: (min(each, DIRECTIONS - each), each)):
        angle = towards + turn * 2 * math.pi / DIRECTIONS
        cos, sin = math.cos(angle), math.sin(angle)
        distance = away + clearance
        for _ in range(2):
            there = thing.moved(partner.x + distance * cos, partner.y + distance * sin, thing.size[2] / 2)
            distance -= gap(there.footprint, partner.footprint) - clearance - 0.002
        yield thing.moved(partner.x + distance * cos, partner.y + distance * sin, thing.size[2] / 2)


def about_a_place(there: Thing) -> Iterator[Thing]:
    """Places all round one that was named, the same within the tolerance of a place.

    Args:
        there: The thing at the place.
    """
    for away, turn in product(NEARBY_M, range(DIRECTIONS)):
        angle = turn * 2 * math.pi / DIRECTIONS
        yield there.moved(there.x + away * math.cos(angle), there.y + away * math.sin(angle), there.z)


def to_a_side(thing: Thing, partner: Thing, wanted: Beyond, clearance: float) -> Iterator[Thing]:
    """Places on the desk to a side of another thing, as a relation between the two wants it.

    Args:
        thing: Where it is now, one of the two.
        partner: Where the other will be.
        wanted: The relation; the distance that it names is kept exactly.
        clearance: Metres that are to be free between them where it names none.
    """
    is_further, axis = wanted.pair[0] == thing.name, wanted.axis
    own, its = thing.footprint.extent(axis), partner.footprint.extent(axis)
    centre, across = (thing.x, thing.y)[axis], (partner.x, partner.y)[1 - axis]
    gaps = (0.002, 0.03, 0.06, 0.1, 0.15, 0.2) if wanted.gap_m is None else (wanted.gap_m,)
    for free, off in product(gaps, (0.0, 0.05, -0.05, 0.1, -0.1, 0.2, -0.2)):
        room = free + (clearance if wanted.gap_m is None else 0.0)
        along = its[1] + room + (centre - own[0]) if is_further else its[0] - room - (own[1] - centre)
        x, y = (along, across + off) if axis == 0 else (across + off, along)
        if wanted.gap_m is None or off == 0:
            yield thing.moved(x, y, thing.size[2] / 2)


def amid(thing: Thing, ends: Sequence[Thing]) -> Iterator[Thing]:
    """The place on the desk in the middle of what is free between two things, as it lies and turned along their line.

    Args:
        thing: Where it is now.
        ends: Where the two will be.
    """
    one, other = ends
    line = math.atan2(other.y - one.y, other.x - one.x)
    first, last = (each.footprint.turned(-line).extent(0) for each in (one, other))
    along = (first[1] + last[0]) / 2 - turned((one.x, one.y), -line)[0]
    x, y = one.x + along * math.cos(line), one.y + along * math.sin(line)
    for yaw in (thing.yaw, aligned(thing.yaw, line)):
        yield thing.moved(x, y, thing.size[2] / 2, yaw)


def at_an_end(thing: Thing, partner: Thing, middle: Thing, clearance: float) -> Iterator[Thing]:
    """Places on the desk such that a third thing has room on the line from another: all round it, at twice a distance.

    Args:
        thing: Where it is now.
        partner: Where the other end will be.
        middle: What is to have room between the two.
        clearance: Metres that are to be free on both sides of it.
    """
    free = 2 * clearance + max(middle.size[:2])
    yield from around(thing, partner, free)


def from_the_middle(thing: Thing, container: Thing, z: float) -> Iterator[Thing]:
    """Places all over a container, its middle first; z is the height of the thing's middle in metres."""
    raster = sorted(_raster(container), key=lambda point: (round(math.hypot(*point), 6), point))
    yield from _turned_both_ways(thing, container, z, raster)


def from_a_corner(thing: Thing, container: Thing, z: float) -> Iterator[Thing]:
    """Places all over a container, from its corner on; z is the height of the thing's middle in metres."""
    yield from _turned_both_ways(thing, container, z, _raster(container))


def packed(thing: Thing, container: Thing, z: float, inside: Sequence[Thing], clearance: float) -> Iterator[Thing]:
    """Places in the corners that the walls of a container and what is in it leave, lengthwise and across.

    Args:
        thing: What is placed.
        container: Where it will be.
        z: The height of the thing's middle, metres.
        inside: What is in the container already.
        clearance: Metres that the fingers need.
    """
    halves = [side / 2 for side in inner(container).size[:2]]
    taken = [_in_frame(each, container) for each in inside]
    wall = clearance if container.top > z + thing.size[2] / 2 else LEAST_M
    for quarter in QUARTERS:
        placed = thing.moved(container.x, container.y, z, container.yaw + quarter)
        own = _in_frame(placed, container)
        lines = [
            sorted(
                {SLACK_M + wall - halves[axis] + own[axis][1]}
                | {at[axis][0] + at[axis][1] + clearance + SLACK_M + own[axis][1] for at in taken}
            )
            for axis in (0, 1)
        ]
        yield from (_in(thing, container, z, point, quarter) for point in product(lines[0], lines[1]))


def aligned(yaw: float, other: float) -> float:
    """The angle nearest to the first at which two boxes are parallel, radians."""
    quarter = math.pi / 2
    return other + quarter * round((yaw - other) / quarter)


def _raster(container: Thing) -> list[Point]:
    """Points in the frame of a container, metres."""
    width, length = (side / 2 for side in inner(container).size[:2])
    across, along = (math.floor(half / STEP_IN_M) for half in (width, length))
    return [(i * STEP_IN_M, j * STEP_IN_M) for i, j in product(range(-across, across + 1), range(-along, along + 1))]


def _turned_both_ways(thing: Thing, container: Thing, z: float, points: Sequence[Point]) -> Iterator[Thing]:
    yield from (_in(thing, container, z, point, quarter) for point, quarter in product(points, QUARTERS))


def _in(thing: Thing, container: Thing, z: float, point: Point, quarter: float) -> Thing:
    u, v = turned(point, container.yaw)
    return thing.moved(container.x + u, container.y + v, z, container.yaw + quarter)


def _in_frame(thing: Thing, container: Thing) -> list[tuple[float, float]]:
    """The middle of a thing, and half of its width, along each axis of a container."""
    corners = [turned((x - container.x, y - container.y), -container.yaw) for x, y in thing.footprint.corners]
    radius = thing.footprint.radius
    sides = [(min(each) - radius, max(each) + radius) for each in zip(*corners, strict=True)]
    return [((low + high) / 2, (high - low) / 2) for low, high in sides]
