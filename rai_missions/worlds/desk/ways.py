# SPDX-License-Identifier: Apache-2.0
"""The way of the gripper to where it is to be: over what stands, by a pose of the hand that the arm can reach.

Rule: nothing here moves the arm; a way begins where it is given to begin.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Sequence
from typing import NamedTuple

from rai_missions.worlds.desk.footprints import SeenThing
from rai_missions.worlds.desk.grasps import Grasp
from rai_missions.worlds.desk.kinematics import TILTS, Joints, Kinematics, ToolPose, Unreachable, toward
from rai_missions.worlds.desk.panda.model import TIP_BELOW_TCP_M
from rai_missions.worlds.desk.path import SPEED_MPS, across, follow
from rai_missions.worlds.desk.trajectory import Trajectory

__all__ = ("LIFT_M", "WayPlanner", "WayStart", "leaning", "transit_height")

LOW_M, CLEARANCE_M = 0.13, 0.025
"""The transit's least height, and what it keeps above what stands, m."""
LANE_M = 0.13
"""Half of the width of the lane in which things count for the transit."""
LIFT_M = 0.06
WRIST = (-2.0, 3.5)
"""How far the hand turns from the arm's bearing, rad."""


class WayStart(NamedTuple):
    """Where the arm is."""

    pose: ToolPose
    joints: Joints


class WayPlanner:
    """Plans ways.

    Args:
        kinematics: The arm's.
    """

    def __init__(self, kinematics: Kinematics) -> None:
        self._kinematics = kinematics

    def first(
        self,
        start: WayStart,
        ends: Iterable[Grasp],
        seen: Sequence[SeenThing],
        hanging: tuple[float, float],
        same: float,
    ) -> tuple[Trajectory, Grasp]:
        """The way to the first of several ends that the arm can reach.

        Args:
            start: Where it begins.
            ends: The poses, the best one first.
            seen: What it leads over.
            hanging: How far what is held, or the fingers, reach below the TCP and to the sides, m.
            same: The turn of the hand that makes no difference, rad.

        Raises:
            Unreachable: It can reach none.
        """
        last: ToolPose | None = None
        below, reach = hanging
        for grasp in ends:
            end = _turned(start.pose, grasp.pose, same)
            height = transit_height(start.pose, end, seen, below, reach)
            try:
                return follow(self._kinematics, across(start.pose, end, height), start.joints), grasp._replace(pose=end)
            except Unreachable:
                last = last or end
        raise self._too_far(last)

    def _too_far(self, pose: ToolPose | None) -> Unreachable:
        """Why there is no way: the place itself is out of reach, or only the way to it."""
        if pose is None:
            return Unreachable("the gripper has no way there")
        at, far = f"({pose.x:.3f}, {pose.y:.3f}, {pose.z:.3f}) m", math.hypot(pose.x, pose.y)
        leans = (pose._replace(tilt=tilt) for tilt in TILTS)
        if not any(self._kinematics.solve(each, toward(each)) is not None for each in leans):
            return Unreachable(f"the gripper cannot reach {at}, {far:.2f} m from the base, however the hand leans")
        return Unreachable(f"the gripper reaches {at}, but not from above what stands on the way")

    def back_out(self, joints: Joints, came: Iterable[Joints], height: float) -> Trajectory:
        """The way by which the gripper came, back to a height: where it came down, it can go up.

        Args:
            joints: Where the arm is.
            came: The knots of the way by which it came, from its end.
            height: Of the TCP, m.
        """
        back = [joints]
        for knot in came:
            back.append(knot)
            if self._kinematics.place(knot)[0][2] >= height:
                break
        return Trajectory(back, [LIFT_M / SPEED_MPS] * (len(back) - 1))


def transit_height(
    start: ToolPose, end: ToolPose, seen: Iterable[SeenThing], below: float = TIP_BELOW_TCP_M, reach: float = 0.0
) -> float:
    """How high the TCP passes over what stands near the way, m.

    Args:
        start: Where the way begins.
        end: Where it ends.
        seen: What may stand near it.
        below: How far what is held, or the fingers, reach below the TCP, m.
        reach: How far to the sides, m.
    """
    way = across(start, end, 0.5)
    near = (
        one.slab.top
        for one in seen
        if any(math.dist((one.x, one.y), knot[:2]) < LANE_M + reach + one.slab.radius for knot in way)
    )
    return max(LOW_M, max(near, default=0.0) + below + CLEARANCE_M)


def leaning(ways: Sequence[Grasp]) -> Iterator[Grasp]:
    """Each way from straight above, then each with more and more of a lean."""
    for lean in TILTS:
        for way in ways:
            yield way._replace(pose=way.pose._replace(tilt=lean, z=way.pose.z + 0.009 * abs(math.sin(lean))))


def _turned(start: ToolPose, end: ToolPose, same: float) -> ToolPose:
    """The end pose under that of its equivalent turns for which the wrist is nearest to its middle."""
    bearing = math.atan2(end.y, end.x)
    wrist = start.yaw - math.atan2(start.y, start.x)
    least = math.remainder(end.yaw - bearing, same)
    fitting = [turn for turn in (least, least - same, least + same) if WRIST[0] < turn < WRIST[1]]
    turn = min(fitting or [least], key=lambda turn: abs(turn) + 0.3 * abs(turn - wrist))
    return end._replace(yaw=bearing + turn)
