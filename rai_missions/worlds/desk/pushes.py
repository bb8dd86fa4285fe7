# SPDX-License-Identifier: Apache-2.0
"""How a thing whose neighbours leave no room for the fingers is pushed out from between them.

A push is planned over boxes that move whole with what touches them; afterwards the camera looks again.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from typing import NamedTuple

from rai_missions.worlds.desk.footprints import SeenThing, Slab, overlap, slabs
from rai_missions.worlds.desk.grasps import FINGER_M, PALM_M, PALM_SIDE_M, PALM_UP_M, TIP_M, TIP_SIDE_M, grasps
from rai_missions.worlds.desk.kinematics import ToolPose

__all__ = ("PUSH_OPENING_M", "Push", "pushes")

DISTANCES_M = (0.025, 0.04, 0.055, 0.07)
STANDOFF_M = 0.012
"""Between the fingers and what they push, before."""
TOUCHING_M = 0.004
PUSH_Z_M = 0.02
PUSH_OPENING_M = 0.016
"""Two tips next to each other turn what they push less than closed ones do."""
EDGE = (0.26, 0.76, 0.55)
"""Nothing is pushed nearer or farther than this from the base, nor further to a side, m."""


class Push(NamedTuple):
    """A straight push with the tips of both fingers."""

    start: ToolPose
    end: ToolPose


def pushes(target: SeenThing, others: Sequence[SeenThing]) -> Iterator[Push]:
    """Pushes after which a thing can be taken, the shortest first."""
    for distance in DISTANCES_M:
        for quarter in range(4):
            heading = target.yaw + quarter * math.pi / 2
            found = _push(target, others, heading, distance)
            if found is not None:
                yield found


def _push(target: SeenThing, others: Sequence[SeenThing], heading: float, distance: float) -> Push | None:
    """The push of a thing's column in a direction, if it frees the thing and has room."""
    cos, sin = math.cos(heading), math.sin(heading)
    column = _column(target, others, heading)
    if column is None or any(one.is_container or one.slab.bottom > 0.01 for one in column):
        return None
    moved = [_moved(one, cos * distance, sin * distance) for one in column]
    left = [one for one in others if one not in column]
    around = slabs(left)
    lanes = [_lane(one.slab, heading, distance) for one in column]
    if any(overlap(lane, other, -0.003) for lane in lanes for other in around):
        return None
    if not all(EDGE[0] < math.hypot(one.x, one.y) < EDGE[1] and abs(one.y) < EDGE[2] for one in moved):
        return None
    freed = moved[0]
    if next(grasps(freed, left + moved[1:]), None) is None:
        return None
    last = min(column, key=lambda one: cos * one.x + sin * one.y)
    behind = last.slab.half_along(heading) + TIP_SIDE_M
    x, y = last.x - cos * (behind + STANDOFF_M), last.y - sin * (behind + STANDOFF_M)
    start = ToolPose(x, y, PUSH_Z_M, heading)
    tip = Slab(x, y, heading, TIP_SIDE_M, PUSH_OPENING_M / 2 + TIP_M, 0.0, 1.0)
    upper = tip._replace(half_y=PUSH_OPENING_M / 2 + FINGER_M)
    palm = tip._replace(half_x=PALM_SIDE_M, half_y=PALM_M)
    blocked = any(
        overlap(part, other, 0.002)
        for part, height in ((tip, 0.0), (upper, PUSH_Z_M + 0.017), (palm, PUSH_Z_M + PALM_UP_M))
        for other in slabs(others)
        if other.top > height
    )
    run = distance + STANDOFF_M
    return None if blocked else Push(start, start._replace(x=x + cos * run, y=y + sin * run))


def _column(target: SeenThing, others: Sequence[SeenThing], heading: float) -> list[SeenThing] | None:
    """The thing, and what would have to move with it: in front by contact, behind as far as the fingers' place.

    None where it would be more than three.
    """
    column = [target]
    is_growing = True
    while is_growing:
        is_growing = False
        for one in others:
            if one not in column and any(_moves_with(member, one, heading) for member in column):
                column.append(one)
                is_growing = True
    return column if len(column) <= 3 else None


def _moves_with(member: SeenThing, one: SeenThing, heading: float) -> bool:
    """Whether one is so near to a member of a column, along a heading, that both would move."""
    cos, sin = math.cos(heading), math.sin(heading)
    along = cos * (one.x - member.x) + sin * (one.y - member.y)
    across = abs(-sin * (one.x - member.x) + cos * (one.y - member.y))
    near = one.slab.half_along(heading) + member.slab.half_along(heading) + STANDOFF_M + 2 * TIP_SIDE_M
    narrow = one.slab.half_along(heading + math.pi / 2) + member.slab.half_along(heading + math.pi / 2)
    return abs(along) < near and across < narrow - TOUCHING_M


def _lane(slab: Slab, heading: float, distance: float) -> Slab:
    """What a slab covers while it is pushed."""
    cos, sin = math.cos(heading), math.sin(heading)
    return Slab(
        slab.x + cos * distance / 2,
        slab.y + sin * distance / 2,
        heading,
        slab.half_along(heading) + distance / 2,
        slab.half_along(heading + math.pi / 2),
        slab.bottom,
        slab.top,
    )


def _moved(one: SeenThing, dx: float, dy: float) -> SeenThing:
    return one._replace(x=one.x + dx, y=one.y + dy)
