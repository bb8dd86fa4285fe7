# SPDX-License-Identifier: Apache-2.0
"""The servers of Nav2's actions: drive to a pose, and drive to the dock.

Rule: a goal ends as the robot's pose and the charger state, and canceled only once the robot has stopped. As in Nav2,
a newer goal replaces the one that is pursued, which is aborted.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any, Literal, NamedTuple

from rai_missions.connectors.connector import Data, Report
from rai_missions.worlds.house.layout import PLACES, NamedPose
from rai_missions.worlds.house.navigator import Navigator
from rai_missions.worlds.house.rosbot import FASTEST_MPS, RobotPose
from rai_missions.worlds.messages import pose_stamped, stamp

__all__ = ("DOCK", "NAVIGATE", "DockRobot", "NavigateToPose", "Server")

NAVIGATE = "/navigate_to_pose", "nav2_msgs/action/NavigateToPose"
DOCK = "/dock_robot", "nav2_msgs/action/DockRobot"
FEEDBACK_S = 0.5
NOT_STAGED, NOT_CHARGED = 903, 906
"""FAILED_TO_STAGE and FAILED_TO_CHARGE of nav2_msgs/action/DockRobot."""
CHARGE_S = 3.0
"""How long the charger may take to notice the robot."""

Later = Callable[[Callable[[], None]], None]
Status = Literal["accepted", "rejected", "feedback", "succeeded", "failed", "canceled", "cancel_rejected", "lost"]


class NavigationRequest(NamedTuple):
    """What a goal asks for."""

    place: NamedPose
    turns: bool = True
    """Its heading is meant too."""


@dataclass
class RunningNavigation:
    """The goal being pursued."""

    goal_id: str
    report: Callable[[Report], None]
    begun: float
    number: int
    is_unwanted: bool = False
    next_feedback: float = 0.0
    arrived_at: float | None = None


class Server:
    """What both actions share: an `ActionServer` over the navigation.

    Args:
        navigator: Who drives.
        later: Reports go out through it.
    """

    def __init__(self, navigator: Navigator, later: Later) -> None:
        self.navigator, self._later = navigator, later
        self.running: RunningNavigation | None = None
        self.at = 0.0

    def accept(self, goal_id: str, goal: Data, report: Callable[[Report], None]) -> None:
        wanted = self.wanted(goal)
        if isinstance(wanted, str):
            self._later(lambda: report(Report(goal_id, "rejected", {}, wanted)))
            return
        self._replace()
        number = self.navigator.begin(wanted.place, turns=wanted.turns, at=self.at)
        self.running = RunningNavigation(goal_id, report, self.at, number)
        self._report(self.running, "accepted")

    def cancel(self, goal_id: str) -> None:
        running = self.running
        if running is not None and running.goal_id == goal_id:
            running.is_unwanted = True
            if running.number == self.navigator.number:
                self.navigator.stop()

    def step(self, at: float, pose: RobotPose, *, charging: bool) -> None:
        """Report what has come about."""
        self.at, running = at, self.running
        if running is None:
            return
        if running.number != self.navigator.number:
            self._replace()
        elif running.is_unwanted:
            if abs(pose.speed) < 0.05 and abs(pose.turn) < 0.2:
                self._end(running, "canceled", "canceled", 0)
        elif self.navigator.outcome == "failed":
            self._end(running, "failed", self.navigator.why, self.navigator.error)
        elif self.navigator.outcome == "arrived":
            running.arrived_at = at if running.arrived_at is None else running.arrived_at
            status, why, error = self.arrived(at - running.arrived_at, charging=charging)
            if status:
                self._end(running, status, why, error)
        elif at >= running.next_feedback:
            running.next_feedback = at + FEEDBACK_S
            self._report(running, "feedback", self.feedback(pose, at - running.begun))

    def wanted(self, goal: Data) -> NavigationRequest | str:
        """What a goal asks for, or why it is rejected."""
        raise NotImplementedError

    def arrived(self, since_s: float, *, charging: bool) -> tuple[Status | Literal[""], str, int]:
        """How a goal ends whose robot has arrived, why, and the error's number; empty while that is open."""
        return "succeeded", "", 0

    def feedback(self, pose: RobotPose, taken_s: float) -> dict[str, Any]:
        raise NotImplementedError

    def result(self, error: int, why: str) -> dict[str, Any]:
        return {"error_code": error, "error_msg": why}

    def _replace(self) -> None:
        if self.running is not None:
            self._end(self.running, "failed", "a newer goal replaced this one", 0)

    def _end(self, running: RunningNavigation, status: Status, why: str, error: int) -> None:
        self.running = None
        self._report(running, status, self.result(error, why), why)

    def _report(self, running: RunningNavigation, status: Status, data: Data | None = None, why: str = "") -> None:
        self._later(lambda: running.report(Report(running.goal_id, status, data or {}, why)))


class NavigateToPose(Server):
    """nav2_msgs/action/NavigateToPose: to a pose on the map."""

    def wanted(self, goal: Data) -> NavigationRequest | str:
        pose = _pose(goal)
        if isinstance(pose, str):
            return pose
        place = pose.place
        grid = self.navigator.costmap
        if not grid.is_inside(place.x, place.y):
            return f"({place.x:.2f}, {place.y:.2f}) is outside of the map"
        if not grid.is_free_on_the_map(place.x, place.y):
            return f"({place.x:.2f}, {place.y:.2f}) is too close to a wall or to furniture"
        return pose

    def feedback(self, pose: RobotPose, taken_s: float) -> dict[str, Any]:
        left = self.navigator.left_m
        return {
            "current_pose": pose_stamped(*pose[:3], self.at),
            "navigation_time": stamp(taken_s),
            "estimated_time_remaining": stamp(left / FASTEST_MPS),
            "number_of_recoveries": self.navigator.recoveries,
            "distance_remaining": round(left, 2),
        }


class DockRobot(Server):
    """nav2_msgs/action/DockRobot: to the dock, until it charges."""

    def wanted(self, goal: Data) -> NavigationRequest | str:
        dock = goal.get("dock_id") or "dock"
        if goal.get("use_dock_id") is False:
            return "docks are known by 'dock_id' here; there is: dock"
        return NavigationRequest(PLACES["dock"]) if dock == "dock" else f"there is no dock '{dock}'; there is: dock"

    def arrived(self, since_s: float, *, charging: bool) -> tuple[Status | Literal[""], str, int]:
        if charging:
            return "succeeded", "", 0
        return ("failed", "the charger does not notice the robot", NOT_CHARGED) if since_s > CHARGE_S else ("", "", 0)

    def feedback(self, pose: RobotPose, taken_s: float) -> dict[str, Any]:
        return {"state": 1, "docking_time": stamp(taken_s), "num_retries": self.navigator.recoveries}

    def result(self, error: int, why: str) -> dict[str, Any]:
        error = error if error in (0, NOT_CHARGED) else NOT_STAGED
        retries = self.navigator.recoveries
        return {"success": not why, "error_code": error, "num_retries": retries, "error_msg": why}


def _pose(goal: Data) -> NavigationRequest | str:
    """The goal's geometry_msgs/msg/PoseStamped; an orientation of zeros leaves the heading open."""
    stamped: Any = goal.get("pose")
    if not isinstance(stamped, Mapping):
        return "the goal has no 'pose'"
    frame = (stamped.get("header") or {}).get("frame_id", "")
    if frame not in ("", "map"):
        return f"the goal is in the frame '{frame}'; there is: map"
    pose = stamped.get("pose") or {}
    place, turn = pose.get("position") or {}, pose.get("orientation") or {}
    numbers = [float(part.get(axis, 0.0)) for part, axis in ((place, "x"), (place, "y"), (turn, "z"), (turn, "w"))]
    if not all(map(math.isfinite, numbers)):
        return "the goal's pose is not finite"
    x, y, z, w = numbers
    return NavigationRequest(NamedPose(x, y, 2 * math.atan2(z, w)), turns=bool(z or w))
