# SPDX-License-Identifier: Apache-2.0
"""The tractor's two actions: drive to a place, and drive over what it handed over for.

Rule: a goal ends as the tractor's pose and the judge of the physics state, never because time has passed.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal

from rai_missions.connectors.connector import Data, OnReport
from rai_missions.worlds.goal_server import End, GoalServer, Later, RunningGoal
from rai_missions.worlds.messages import pose_stamped, stamp
from rai_missions.worlds.orchard.autonomy import Autonomy
from rai_missions.worlds.orchard.crossing_judge import CrossingJudge
from rai_missions.worlds.orchard.planner import Lattice
from rai_missions.worlds.orchard.tractor import TractorPose

__all__ = ("Cross", "NavigateToPose")

ARRIVED_M = 1.0


class OneGoal(GoalServer):
    """What both actions share: one goal at a time, an end that waits for the tractor to stop.

    Args:
        autonomy: Who drives.
        later: Reports go out through it.
        at: Simulated seconds at the start.
    """

    name = ""

    def __init__(self, autonomy: Autonomy, later: Later, at: float) -> None:
        super().__init__(later, at)
        self.autonomy = autonomy

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        running = RunningGoal(goal_id, report, self.at)
        why = f"{self.name} pursues another goal" if self.running else self.begin(goal, running)
        if why:
            self._reject(running, why)
        else:
            self._begin(running)

    def cancel(self, goal_id: str) -> None:
        if self.running is not None and self.running.goal_id == goal_id:
            self.running.is_unwanted = True
            self.autonomy.stop()

    def step(self, at: float, pose: TractorPose) -> None:
        """Report what has come about."""
        self.at, running = at, self.running
        if running is None:
            return
        end, why = self.end(running, pose)
        if running.is_unwanted:
            end, why = ("canceled", "canceled") if abs(pose.speed) < 0.05 else ("", "")
        if end:
            self._end(running, end, self.result(at - running.begun, end), why)
        elif not running.is_unwanted:
            self._feed_back(running, lambda taken_s: self.feedback(pose, taken_s))

    def begin(self, goal: Data, running: RunningGoal) -> str:
        """Set out; why not, if not."""
        raise NotImplementedError

    def end(self, running: RunningGoal, pose: TractorPose) -> tuple[End | Literal[""], str]:
        """How the goal has ended and why, or empty."""
        raise NotImplementedError

    def feedback(self, pose: TractorPose, taken_s: float) -> dict[str, Any]:
        raise NotImplementedError

    def result(self, taken_s: float, status: str) -> dict[str, Any]:
        raise NotImplementedError


class NavigateToPose(OneGoal):
    """nav2_msgs/action/NavigateToPose: out of the alleys to a place on a headland; no pose means home.

    The heading in the goal is not pursued: the tractor stands as it came.
    """

    name = "/navigate_to_pose"

    def __init__(self, autonomy: Autonomy, later: Later, at: float, lattice: Lattice) -> None:
        super().__init__(autonomy, later, at)
        self._lattice = lattice

    def begin(self, goal: Data, running: RunningGoal) -> str:
        x, y = _position(goal) or self._lattice.layout.home[:2]
        running.place = self._lattice.position(self._lattice.nearest(x, y))
        return self.set_out(x, y)

    def set_out(self, x: float, y: float) -> str:
        """Begin to drive to a place, for any client that asks; why not, if not."""
        if self.running is not None:
            return f"{self.name} pursues another goal"
        place = self._lattice.nearest(x, y)
        found = self._lattice.position(place)
        if math.dist((x, y), found) > self._lattice.layout.radius_m:
            near = ", ".join(f"{v:.2f}" for v in found)
            return f"({x:.2f}, {y:.2f}) is not on a headland; the nearest place that is: ({near})"
        return "" if self.autonomy.go_to(place) else "no way leads there"

    def end(self, running: RunningGoal, pose: TractorPose) -> tuple[End | Literal[""], str]:
        if self.autonomy.is_homing:
            return "", ""
        if math.dist((pose.x, pose.y), running.place) <= ARRIVED_M:
            return ("succeeded", "") if abs(pose.speed) < 0.05 else ("", "")
        return "failed", "the tractor was stopped on the way"

    def feedback(self, pose: TractorPose, taken_s: float) -> dict[str, Any]:
        return {
            "current_pose": pose_stamped(*pose[:3], self.at),
            "navigation_time": stamp(taken_s),
            "distance_remaining": round(self.autonomy.left_m, 2),
            "number_of_recoveries": 0,
        }

    def result(self, taken_s: float, status: str) -> dict[str, Any]:
        return {"error_code": 0 if status == "succeeded" else 1, "error_msg": ""}


class Cross(OneGoal):
    """nav2_msgs/action/DriveOnHeading: drive on, over the obstacle that was handed over for, until it lies behind."""

    name = "/cross"

    def __init__(self, autonomy: Autonomy, later: Later, at: float, judge: CrossingJudge) -> None:
        super().__init__(autonomy, later, at)
        self._judge = judge
        self._start = (0.0, 0.0)

    def begin(self, goal: Data, running: RunningGoal) -> str:
        return self.set_out()

    def set_out(self) -> str:
        """Begin to drive over the obstacle ahead of the tractor, for any client that asks; why not, if not."""
        if self._judge.crossing is None or self.autonomy.word != "STOPPED" or not self.autonomy.watches:
            return "there is nothing to cross: the tractor has not stopped for an obstacle"
        if self._judge.crossing.outcome == "failed":
            self._judge.begin(self.autonomy.pose, self.autonomy.range_m or 0.0)
        self._start = self.autonomy.pose[:2]
        return "" if self.autonomy.proceed(over=True) else "the tractor does not drive on"

    def end(self, running: RunningGoal, pose: TractorPose) -> tuple[End | Literal[""], str]:
        crossing = self._judge.crossing
        if crossing is None or crossing.outcome == "passed":
            return "succeeded", ""
        if crossing.outcome == "failed":
            return "failed", crossing.why
        return ("", "") if self.autonomy.is_driving else ("failed", "the tractor was stopped on the way")

    def feedback(self, pose: TractorPose, taken_s: float) -> dict[str, Any]:
        return {"distance_traveled": round(math.dist(pose[:2], self._start), 2)}

    def result(self, taken_s: float, status: str) -> dict[str, Any]:
        return {"total_elapsed_time": stamp(taken_s), "error_code": 0 if status == "succeeded" else 1, "error_msg": ""}


def _position(goal: Data) -> tuple[float, float] | None:
    """x and y of the goal's geometry_msgs/msg/PoseStamped."""
    pose: Any = goal.get("pose")
    for name in ("pose", "position"):
        pose = pose.get(name) if isinstance(pose, Mapping) else None
    return (float(pose.get("x", 0.0)), float(pose.get("y", 0.0))) if isinstance(pose, Mapping) else None
