# SPDX-License-Identifier: Apache-2.0
"""The tractor's two actions: drive to a place, and drive over what it handed over for.

Rule: a goal ends as the tractor's pose and the judge of the physics state, never because time has passed.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal

from rai_missions.connectors.connector import Data, Report
from rai_missions.worlds.messages import pose_stamped, stamp
from rai_missions.worlds.orchard.autonomy import Autonomy
from rai_missions.worlds.orchard.crossing_judge import Judge
from rai_missions.worlds.orchard.planner import Lattice
from rai_missions.worlds.orchard.tractor import TractorPose

__all__ = ("Cross", "NavigateToPose")

Status = Literal["accepted", "rejected", "feedback", "succeeded", "failed", "canceled", "cancel_rejected", "lost"]
Later = Callable[[Callable[[], None]], None]
"""Does something once the world's step is over and its lock is free."""
ARRIVED_M = 1.0


@dataclass
class RunningGoal:
    """The goal being pursued."""

    goal_id: str
    report: Callable[[Report], None]
    begun: float
    place: tuple[float, float] = (0.0, 0.0)
    is_unwanted: bool = False
    next_feedback: float = 0.0


class OneGoal:
    """What both actions share: one goal at a time, an end that waits for the tractor to stop.

    Args:
        autonomy: Who drives.
        later: Reports go out through it.
    """

    name = ""

    def __init__(self, autonomy: Autonomy, later: Later) -> None:
        self.autonomy, self._later = autonomy, later
        self.running: RunningGoal | None = None
        self.at = 0.0

    def accept(self, goal_id: str, goal: Data, report: Callable[[Report], None]) -> None:
        running = RunningGoal(goal_id, report, self.at)
        why = f"{self.name} pursues another goal" if self.running else self.begin(goal, running)
        if why:
            self._later(lambda: report(Report(goal_id, "rejected", {}, why)))
            return
        self.running = running
        self.report(running, "accepted")

    def cancel(self, goal_id: str) -> None:
        if self.running is not None and self.running.goal_id == goal_id:
            self.running.is_unwanted = True
            self.autonomy.stop()

    def step(self, at: float, pose: TractorPose) -> None:
        """Report what has come about."""
        self.at, running = at, self.running
        if running is None:
            return
        status, why = self.end(running, pose)
        if running.is_unwanted:
            status, why = ("canceled", "canceled") if abs(pose.speed) < 0.05 else ("", "")
        if status:
            self.running = None
            self.report(running, status, self.result(at - running.begun, status), why)  # type: ignore[arg-type]
        elif at >= running.next_feedback and not running.is_unwanted:
            running.next_feedback = at + 0.5
            self.report(running, "feedback", self.feedback(pose, at - running.begun))

    def report(self, running: RunningGoal, status: Status, data: Data | None = None, why: str = "") -> None:
        self._later(lambda: running.report(Report(running.goal_id, status, data or {}, why)))

    def begin(self, goal: Data, running: RunningGoal) -> str:
        """Set out; why not, if not."""
        raise NotImplementedError

    def end(self, running: RunningGoal, pose: TractorPose) -> tuple[str, str]:
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

    def __init__(self, autonomy: Autonomy, later: Later, lattice: Lattice) -> None:
        super().__init__(autonomy, later)
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

    def end(self, running: RunningGoal, pose: TractorPose) -> tuple[str, str]:
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

    def __init__(self, autonomy: Autonomy, later: Later, judge: Judge) -> None:
        super().__init__(autonomy, later)
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

    def end(self, running: RunningGoal, pose: TractorPose) -> tuple[str, str]:
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
