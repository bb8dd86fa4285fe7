# SPDX-License-Identifier: Apache-2.0
"""The servers of the arm's actions: move the gripper, take a thing, set it down.

Rule: the arm pursues one goal at a time and rejects another; a goal ends as the arm's own sensors state, and canceled
only once the arm is at rest.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rai_missions.connectors.connector import Data, OnReport
from rai_missions.plain_data import is_numeric
from rai_missions.worlds.desk.kinematics import ToolPose
from rai_missions.worlds.desk.motion import Motion, SkillEnd, ThingPose
from rai_missions.worlds.desk.skill_log import Skill
from rai_missions.worlds.goal_server import GoalServer, Later, RunningGoal

__all__ = ("MOVE", "PICK", "PLACE", "ArmServer", "MoveArm", "PickAt", "PlaceAt")

MOVE = "/move_arm", "rai_missions_msgs/action/MoveArm"
PICK = "/pick_at", "rai_missions_msgs/action/PickAt"
PLACE = "/place_at", "rai_missions_msgs/action/PlaceAt"
GRIPPER = ("as_is", "closed", "open")


class ArmServer(GoalServer):
    """What the actions share: an `ActionServer` over the arm's motion.

    Args:
        motion: The arm's.
        later: Reports go out through it.
        at: Simulated seconds at the start.
    """

    def __init__(self, motion: Motion, later: Later, at: float) -> None:
        super().__init__(later, at)
        self._motion = motion

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        running = RunningGoal(goal_id, report, self.at)
        skill = "the arm is busy with another goal" if self._motion.is_busy else self.skill(goal)
        if isinstance(skill, str):
            self._reject(running, skill)
            return
        self._motion.begin(skill)
        self._begin(running)

    def cancel(self, goal_id: str) -> None:
        if self.running is not None and self.running.goal_id == goal_id:
            self._motion.stop()

    def step(self, at: float) -> None:
        """Report what has come about."""
        self.at, running, ending = at, self.running, self._motion.ending
        if running is None:
            return
        if ending is None:
            self._feed_back(running, lambda _taken_s: {"gripper": _written(self._motion.pose)})
        else:
            self._end(running, ending.end, _result(ending), ending.message)

    def skill(self, goal: Data) -> Skill | str:
        """What a goal asks for, or why it is rejected."""
        raise NotImplementedError


class MoveArm(ArmServer):
    """rai_missions_msgs/action/MoveArm: the gripper to a pose."""

    def skill(self, goal: Data) -> Skill | str:
        place = _place(goal.get("target"), "target")
        if isinstance(place, str):
            return place
        gripper = goal.get("gripper") or "as_is"
        if gripper not in GRIPPER:
            return f"gripper: {gripper!r} is none of: {', '.join(GRIPPER)}"
        return self._motion.move(ToolPose(*place), after=gripper, grasp=bool(goal.get("grasp")))


class PickAt(ArmServer):
    """rai_missions_msgs/action/PickAt: a thing into the gripper."""

    def skill(self, goal: Data) -> Skill | str:
        place = _place(goal.get("pose"), "pose")
        return place if isinstance(place, str) else self._motion.pick(str(goal.get("object") or "thing"), place)


class PlaceAt(ArmServer):
    """rai_missions_msgs/action/PlaceAt: what the gripper holds to a place."""

    def skill(self, goal: Data) -> Skill | str:
        place = _place(goal.get("pose"), "pose")
        return place if isinstance(place, str) else self._motion.place(str(goal.get("object") or "thing"), place)


def _place(written: Any, field: str) -> ThingPose | str:
    """A rai_missions_msgs/msg/PoseYaw, or what is wrong with it."""
    if not isinstance(written, Mapping):
        return f"the goal has no '{field}'; give x, y, z (m) and yaw (rad) in panda_link0"
    numbers = [written.get(axis, 0.0 if axis == "yaw" else None) for axis in ("x", "y", "z", "yaw")]
    if not all(map(is_numeric, numbers)):
        return f"'{field}' is {dict(written)}; give x, y, z (m) and yaw (rad) in panda_link0"
    if not all(math.isfinite(each) for each in numbers):
        return f"'{field}' is not finite"
    x, y, z, yaw = map(float, numbers)
    return ThingPose(x, y, z, yaw)


def _written(pose: ToolPose) -> dict[str, float]:
    return {"x": round(pose.x, 4), "y": round(pose.y, 4), "z": round(pose.z, 4), "yaw": round(pose.yaw, 4)}


def _result(ending: SkillEnd) -> dict[str, Any]:
    return {"success": ending.end == "succeeded", "reason": ending.reason, "message": ending.message}
