# SPDX-License-Identifier: Apache-2.0
"""Whether fingers fit around a thing where it is: boxes of a parallel gripper, seen from above.

Rule: it only orders moves. The arm has the last word, and may push free what a plan takes for crowded.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

from rai_missions.planning.geometry import Footprint, box, gap
from rai_missions.planning.scene import BALLS, CONTAINERS, Thing

__all__ = ("PALM_UP_M", "can_take", "crowding", "least_crowding")

GAP_M = 0.002
"""Between a finger and a neighbour."""
OPEN_M = 0.007
"""Between a finger and the thing, before it closes."""
TIP_M, TIP_WIDE_M, TIP_DOWN_M = 0.011, 0.019, 0.009
"""How thick and how wide a tip is, and how far below the thing's centre it reaches."""
FINGER_M, FINGER_WIDE_M, FINGER_UP_M = 0.026, 0.023, 0.017
"""The finger's upper part, and how far above the centre it begins."""
PALM_M, PALM_WIDE_M = 0.21, 0.065
PALM_UP_M = 0.036
"""How far above the centre of what is taken the palm is."""
BELOW_M = 0.006
"""What reaches no higher than so far above a thing's lowest point is below it."""
BALL_YAWS = tuple(math.pi * number / 6 for number in range(6))


def can_take(thing: Thing, others: Iterable[Thing]) -> bool:
    """Whether the fingers have room in at least one direction, as a coarse rule.

    Args:
        thing: Where it is.
        others: All else, where it is; containers do not count, since things are taken out of them from above.
    """
    near = [other for other in others if _counts(thing, other)]
    return any(not any(_is_blocked(part, near) for part in _hand(thing, yaw)) for yaw in _directions(thing))


def crowding(thing: Thing, others: Iterable[Thing]) -> Iterator[Thing]:
    """The things that leave a thing's fingers no room in some direction."""
    near = [other for other in others if _counts(thing, other)]
    for other in near:
        if any(_is_blocked(part, [other]) for yaw in _directions(thing) for part in _hand(thing, yaw)):
            yield other


def least_crowding(thing: Thing, others: Iterable[Thing]) -> list[Thing]:
    """The fewest things that have to leave so that the fingers have room in one direction; none where they have."""
    near = [other for other in others if _counts(thing, other)]
    choices = (
        [other for other in near if any(_is_blocked(part, [other]) for part in _hand(thing, yaw))]
        for yaw in _directions(thing)
    )
    return min(choices, key=len)


def _counts(thing: Thing, other: Thing) -> bool:
    return other.name != thing.name and other.type not in CONTAINERS and other.top > thing.bottom + BELOW_M


def _directions(thing: Thing) -> tuple[float, ...]:
    """Directions in which the fingers close."""
    if thing.type in BALLS:
        return BALL_YAWS
    across = thing.yaw + math.pi / 2
    return (across,) if thing.size[0] > 1.5 * thing.size[1] else (thing.yaw, across)


def _hand(thing: Thing, yaw: float) -> Iterator[tuple[Footprint, float]]:
    """What the hand that closes in a direction sweeps, each part with the height at which it begins."""
    half = thing.size[1] / 2
    yield box(thing.x, thing.y, (PALM_M, PALM_WIDE_M), yaw), thing.z + PALM_UP_M
    for side in (-1.0, 1.0):
        for thick, wide, from_z in ((TIP_M, TIP_WIDE_M, -TIP_DOWN_M), (FINGER_M, FINGER_WIDE_M, FINGER_UP_M)):
            swept = OPEN_M + thick
            along = side * (half + swept / 2)
            yield (
                box(thing.x + math.cos(yaw) * along, thing.y + math.sin(yaw) * along, (swept, wide), yaw),
                thing.z + from_z,
            )


def _is_blocked(part: tuple[Footprint, float], others: list[Thing]) -> bool:
    footprint, from_z = part
    return any(other.top > from_z and gap(footprint, _outline(other)) < GAP_M for other in others)


def _outline(thing: Thing) -> Footprint:
    """What fingers keep clear of: the box of a thing, for an arm takes a ball for one too."""
    return box(thing.x, thing.y, thing.size[:2], thing.yaw)
