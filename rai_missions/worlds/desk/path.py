# SPDX-License-Identifier: Apache-2.0
"""The way of the gripper from one pose to another: straight up, across at a height, and straight down."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import pairwise

from rai_missions.worlds.desk.kinematics import Joints, Kinematics, ToolPose, Unreachable
from rai_missions.worlds.desk.trajectory import Trajectory

__all__ = ("SPEED_MPS", "across", "follow", "straight")

ROUND_M = 0.04
"""The radius of the corners."""
STRAIGHT_M, ACROSS_M, TURN_RAD = 0.025, 0.08, 0.35
"""Between two knots: on straight stretches near things, at the height of the transit, and where the hand turns."""
SPEED_MPS, SLOW_MPS, TURN_RADPS = 0.7, 0.12, 2.0


def straight(start: ToolPose, end: ToolPose) -> list[ToolPose]:
    """Knots on a straight line, turning evenly, the first included."""
    apart = math.dist(start[:3], end[:3])
    turn = max(abs(end.yaw - start.yaw), abs(end.tilt - start.tilt))
    count = max(1, math.ceil(apart / STRAIGHT_M), math.ceil(turn / TURN_RAD))
    return [_between(start, end, number / count) for number in range(count + 1)]


def across(start: ToolPose, end: ToolPose, height: float) -> list[ToolPose]:
    """Knots of a way over what stands, the first included.

    Args:
        start: Where it begins.
        end: Where it leads.
        height: Of the TCP on the way, m; to an end that is higher the way slopes.
    """
    level = math.dist(start[:2], end[:2])
    if level < 0.01 and max(abs(end.yaw - start.yaw), abs(end.tilt - start.tilt)) < 0.05:
        return straight(start, end)
    tops = max(height, start.z), max(height, end.z)
    if level < 0.01:  # it turns on the spot, at the top
        above, over = start.at(z=max(tops)), end.at(z=max(tops))
        return straight(start, above) + straight(above, over)[1:] + straight(over, end)[1:]
    rise = _rise(start.z, tops[0], level)
    fall = [(level - run, up) for run, up in reversed(_rise(end.z, tops[1], level))]
    return [_level(start, end, run / level, up) for run, up in _filled([*rise, *fall])]


def follow(
    kinematics: Kinematics, knots: Sequence[ToolPose], begin: Joints, *, slowly: bool = False, end: Joints | None = None
) -> Trajectory:
    """The motion along poses.

    Args:
        kinematics: The arm's.
        knots: Poses; the first is where the arm is.
        begin: The joints there.
        slowly: With a speed at which contact is expected.
        end: The joints at the last pose, where any that reach it will not do.

    Raises:
        Unreachable: A pose on the way has no joints near those before it.
    """
    speed = SLOW_MPS if slowly else SPEED_MPS
    joints, times = [begin], []
    for previous, knot in pairwise(knots):
        found = kinematics.solve(knot, joints[-1])
        if found is None:
            raise Unreachable(f"on the way, the gripper cannot go through ({knot.x:.3f}, {knot.y:.3f}, {knot.z:.3f}) m")
        turn = max(abs(knot.yaw - previous.yaw), abs(knot.tilt - previous.tilt))
        times.append(max(math.dist(previous[:3], knot[:3]) / speed, turn / TURN_RADPS))
        joints.append(found)
    if end is not None:
        joints[-1] = end
    return Trajectory(joints, times) if times else Trajectory([begin, begin], [0.0])


def _between(start: ToolPose, end: ToolPose, part: float) -> ToolPose:
    return ToolPose(*(begin + (last - begin) * part for begin, last in zip(start, end, strict=True)))


def _rise(low: float, height: float, level: float) -> list[tuple[float, float]]:
    """From a start straight up, and round the corner to where the way across begins: (run, height) of each knot."""
    radius = min(ROUND_M, height - low, level / 2)
    if radius < 1e-6:
        return [(0.0, low)]
    angles = (0.0, math.pi / 6, math.pi / 3, math.pi / 2)
    arc = [(radius * (1 - math.cos(angle)), height - radius * (1 - math.sin(angle))) for angle in angles]
    return [(0.0, low), *arc]


def _filled(corners: Sequence[tuple[float, float]]) -> Iterator[tuple[float, float]]:
    """The corners, with points between those that are far apart."""
    yield corners[0]
    for before, after in pairwise(corners):
        apart = math.dist(before, after)
        if apart < 1e-6:
            continue
        count = math.ceil(apart / (STRAIGHT_M * 2 if before[0] == after[0] else ACROSS_M))
        for number in range(1, count + 1):
            yield (
                before[0] + (after[0] - before[0]) * number / count,
                before[1] + (after[1] - before[1]) * number / count,
            )


def _level(start: ToolPose, end: ToolPose, part: float, up: float) -> ToolPose:
    """The pose at a part of the way across: bearing and radius change evenly, which stays clear of the base."""
    near, far = math.hypot(start.x, start.y), math.hypot(end.x, end.y)
    begin = math.atan2(start.y, start.x)
    angle = begin + math.remainder(math.atan2(end.y, end.x) - begin, math.tau) * part
    radius = near + (far - near) * part
    return ToolPose(
        radius * math.cos(angle),
        radius * math.sin(angle),
        up,
        start.yaw + (end.yaw - start.yaw) * part,
        start.tilt + (end.tilt - start.tilt) * part,
    )
