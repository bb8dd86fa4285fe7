# SPDX-License-Identifier: Apache-2.0
"""How the hand can take a thing or set it down: directions of the fingers that are free of what stands next to it.

Rule: a grasp comes from what the camera measured, and is offered only where fingers and palm, seen from above, keep a
gap to everything else.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import islice
from typing import NamedTuple

from rai_missions.worlds.desk.footprints import SeenThing, Slab, overlap, slabs
from rai_missions.worlds.desk.kinematics import ToolPose
from rai_missions.worlds.desk.panda.model import MAX_WIDTH_M, TIP_BELOW_TCP_M

__all__ = ("Grasp", "HeldThing", "grasps", "hand_parts", "releases", "standing_on", "too_wide")

GAP_M = 0.002
"""Between a finger and a neighbour, beyond the camera's noise."""
WIDEST_M = 0.072
"""What the fingers can close on."""
TIP_M, TIP_SIDE_M, TIP_UP_M = 0.011, 0.0095, 0.017
"""A finger's tip: how thick, half of how wide, and how far above the TCP it becomes thicker."""
FINGER_M, FINGER_SIDE_M = 0.026, 0.0115
"""The upper part of a finger."""
PALM_UP_M, PALM_M, PALM_SIDE_M = 0.036, 0.105, 0.0325
"""The hand above the fingers: how far above the TCP, and half of its extents."""
CLEAR_M = 0.004
"""Between the tips and what is below."""
OPENINGS_M = (MAX_WIDTH_M, 0.024, 0.014)
"""The fingers' width: all of it, or the thing's and so much."""
RELEASES_M = (0.03, 0.018, 0.012)
"""By how much the fingers open to let go."""
DROPS_M = (0.02, 0.05)
"""From how high a thing may fall into a container, before it falls from above its walls."""


class Grasp(NamedTuple):
    """One way to take or to release a thing."""

    pose: ToolPose
    """Of the TCP, from straight above."""
    opening_m: float
    """Between the fingers before they close, or once they have opened."""


class HeldThing(NamedTuple):
    """How a thing is held."""

    thing: SeenThing
    """As it was when it was taken."""
    pose: ToolPose
    """Of the TCP then."""

    @property
    def below_m(self) -> float:
        """How far it reaches below the TCP."""
        return self.pose.z - self.thing.slab.bottom

    @property
    def reach_m(self) -> float:
        """How far it reaches from the hand's axis."""
        return self.thing.slab.radius


def grasps(target: SeenThing, others: Sequence[SeenThing]) -> Iterator[Grasp]:
    """Ways to take a thing, the best first.

    Args:
        target: What is to be taken.
        others: Everything else that was seen.
    """
    around = slabs(others)
    z = max(target.z, target.slab.bottom + TIP_BELOW_TCP_M + CLEAR_M)
    for along in _offsets(target):
        x = target.x + math.cos(target.yaw) * along
        y = target.y + math.sin(target.yaw) * along
        for yaw, wide in _directions(target):
            pose = ToolPose(x, y, z, yaw)
            openings = (min(MAX_WIDTH_M, extra if extra == MAX_WIDTH_M else wide + extra) for extra in OPENINGS_M)
            free = (each for each in openings if each > wide + 0.008 and _is_free(pose, wide, each, around))
            yield from (Grasp(pose, opening) for opening in islice(free, 1))


def releases(held: HeldThing, x: float, y: float, z: float, yaw: float, others: Sequence[SeenThing]) -> Iterator[Grasp]:
    """Ways to set a held thing down with its centre at a place, the best first.

    Args:
        held: What is held, and how.
        x: Of the place, m.
        y: Of the place, m.
        z: Of its centre there, m.
        yaw: It is to have, rad; one that looks the same will do, and at last half a turn more.
        others: Everything else that was seen.
    """
    around = slabs(others)
    thing, grip = held.thing, held.pose
    turns = max(thing.turns or 12, 2)
    wide = _width(thing, grip.yaw)
    ordered = sorted(range(turns), key=lambda number: abs(math.remainder(math.tau * number / turns, math.tau)))
    for lift in _lifts(x, y, z, held, others):
        for number in ordered:
            turned = math.remainder(yaw + math.tau * number / turns - thing.yaw, math.tau)
            cos, sin = math.cos(turned), math.sin(turned)
            dx, dy = grip.x - thing.x, grip.y - thing.y
            pose = ToolPose(
                x + cos * dx - sin * dy, y + sin * dx + cos * dy, z + grip.z - thing.z + lift, grip.yaw + turned
            )
            openings = [min(MAX_WIDTH_M, wide + extra) for extra in RELEASES_M]
            yield from (Grasp(pose, opening) for opening in openings if _is_free(pose, wide, opening, around))


def _lifts(x: float, y: float, z: float, held: HeldThing, others: Sequence[SeenThing]) -> list[float]:
    """How much higher than its place a thing may be let go: into a container from up to above its walls, m."""
    spot = Slab(x, y, 0.0, 0.001, 0.001, z, z)
    rims = [one.slab.top for one in others if one.is_container and overlap(one.slab, spot)]
    if not rims:
        return [0.0]
    above = max(rims) + TIP_BELOW_TCP_M + CLEAR_M - (z + held.pose.z - held.thing.z)
    return [0.0, *(lift for lift in DROPS_M if lift < above), max(0.0, above)]


def standing_on(target: SeenThing, others: Sequence[SeenThing]) -> SeenThing | None:
    """What rests on a thing; None where nothing does."""
    top = target.slab.top
    on_it = (one for one in others if one.slab.bottom > top - 0.012 and one.z > target.z + 0.01)
    return next((one for one in on_it if overlap(one.slab, target.slab, -0.004)), None)


def too_wide(target: SeenThing) -> bool:
    """Whether the fingers can close on it in no direction."""
    return target.is_container or min(target.size[:2]) > WIDEST_M


def _directions(target: SeenThing) -> list[tuple[float, float]]:
    """Closing directions (as `ToolPose.yaw`) that hold it, and how wide it is in each."""
    if target.turns == 0:
        yaws = [math.atan2(target.y, target.x) + math.pi * number / 12 for number in (0, 1, -1, 2, -2, 3, -3, 4, -4, 6)]
    elif target.size[0] > 1.5 * target.size[1]:
        yaws = [target.yaw + lean for lean in (0.0, 0.2, -0.2)]
    else:
        yaws = [target.yaw, target.yaw + math.pi / 2]
    bearing = math.atan2(target.y, target.x)
    wides = [(yaw, _width(target, yaw)) for yaw in yaws]
    fitting = [(yaw, wide) for yaw, wide in wides if wide <= WIDEST_M]
    return sorted(fitting, key=lambda one: round(one[1], 3) + 0.001 * abs(math.remainder(one[0] - bearing, math.pi)))


def _width(target: SeenThing, yaw: float) -> float:
    """The target's extent along the fingers' closing direction."""
    if target.turns == 0:
        return max(target.size[:2])
    turn = yaw - target.yaw
    if target.size[0] > 1.5 * target.size[1]:
        return target.size[1] / max(0.5, abs(math.cos(turn)))
    return target.size[1] * abs(math.cos(turn)) + target.size[0] * abs(math.sin(turn))


def _offsets(target: SeenThing) -> tuple[float, ...]:
    """Places along its long axis at which it may be taken."""
    if target.turns == 0 or target.size[0] <= 1.5 * target.size[1]:
        return (0.0,)
    return (-0.015, 0.0, -0.03, 0.015, 0.03)


def _is_free(pose: ToolPose, wide: float, opening: float, around: Sequence[Slab]) -> bool:
    """Whether fingers and palm keep clear of what stands, here and straight above, while the fingers open or close."""
    parts = hand_parts(pose, wide, opening)
    return not any(overlap(part, one, GAP_M) for part in parts for one in around if one.top > part.bottom)


def hand_parts(pose: ToolPose, wide: float, opening: float) -> list[Slab]:
    """The hand from above: what two tips and the fingers' upper parts sweep, and the palm.

    Args:
        pose: The pose of the TCP.
        wide: Between the fingers where they hold a thing, m.
        opening: Between them where they are open, m.
    """
    parts = [_part(pose, 0.0, PALM_SIDE_M, PALM_M, PALM_UP_M)]
    for thick, half_x, up in ((TIP_M, TIP_SIDE_M, -TIP_BELOW_TCP_M), (FINGER_M, FINGER_SIDE_M, TIP_UP_M)):
        inside, outside = wide / 2, opening / 2 + thick
        middle, half_y = (inside + outside) / 2, (outside - inside) / 2
        parts += [_part(pose, side * middle, half_x, half_y, up) for side in (-1.0, 1.0)]
    return parts


def _part(pose: ToolPose, along: float, half_x: float, half_y: float, up: float) -> Slab:
    """A box of the hand, so far along the closing direction."""
    return Slab(
        pose.x + math.sin(pose.yaw) * along,
        pose.y - math.cos(pose.yaw) * along,
        pose.yaw,
        half_x,
        half_y,
        pose.z + up,
        math.inf,
    )
