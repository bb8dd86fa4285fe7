# SPDX-License-Identifier: Apache-2.0
"""The servers of Nav2's actions: drive to a pose, drive to the dock, and wait.

Rule: a goal ends as the robot's pose and the charger state, and canceled only once the robot has stopped. As in Nav2,
a newer goal replaces the one that is pursued, which is aborted.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any, Literal, NamedTuple

from rai_missions.connectors.connector import Data, OnReport
from rai_missions.plain_data import is_number
from rai_missions.worlds.goal_server import End, GoalServer, Later, RunningGoal
from rai_missions.worlds.house.layout import PLACES, NamedPose
from rai_missions.worlds.house.navigator import Navigator
from rai_missions.worlds.house.rosbot import FASTEST_MPS, RobotPose
from rai_missions.worlds.messages import pose_stamped, stamp

__all__ = ("DOCK", "NAVIGATE", "WAIT", "DockRobot", "NavigateToPose", "Server", "Wait")

NAVIGATE = "/navigate_to_pose", "nav2_msgs/action/NavigateToPose"
DOCK = "/dock_robot", "nav2_msgs/action/DockRobot"
WAIT = "/wait", "nav2_msgs/action/Wait"
NOT_STAGED, NOT_CHARGED = 903, 906
"""FAILED_TO_STAGE and FAILED_TO_CHARGE of nav2_msgs/action/DockRobot."""
CHARGE_S = 3.0
"""How long the charger may take to notice the robot."""


class NavigationRequest(NamedTuple):
    """What a goal asks for."""

    place: NamedPose
    turns: bool = True
    """Its heading is meant too."""


class Server(GoalServer):
    """What both actions share: an `ActionServer` over the navigation.

    Args:
        navigator: Who drives.
        later: Reports go out through it.
        at: Simulated seconds at the start.
    """

    def __init__(self, navigator: Navigator, later: Later, at: float) -> None:
        super().__init__(later, at)
        self.navigator = navigator

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        wanted, running = self.wanted(goal), RunningGoal(goal_id, report, self.at)
        if isinstance(wanted, str):
            self._reject(running, wanted)
            return
        self._replace()
        running.number = self.navigator.begin(wanted.place, turns=wanted.turns, at=self.at)
        self._begin(running)

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
                self._conclude(running, "canceled", "canceled", 0)
        elif self.navigator.outcome == "failed":
            self._conclude(running, "failed", self.navigator.why, self.navigator.error)
        elif self.navigator.outcome == "arrived":
            running.arrived_at = at if running.arrived_at is None else running.arrived_at
            status, why, error = self.arrived(at - running.arrived_at, charging=charging)
            if status:
                self._conclude(running, status, why, error)
        else:
            self._feed_back(running, lambda taken_s: self.feedback(pose, taken_s))

    def wanted(self, goal: Data) -> NavigationRequest | str:
        """What a goal asks for, or why it is rejected."""
        raise NotImplementedError

    def arrived(self, since_s: float, *, charging: bool) -> tuple[End | Literal[""], str, int]:
        """How a goal ends whose robot has arrived, why, and the error's number; empty while that is open."""
        return "succeeded", "", 0

    def feedback(self, pose: RobotPose, taken_s: float) -> dict[str, Any]:
        raise NotImplementedError

    def result(self, error: int, why: str) -> dict[str, Any]:
        return {"error_code": error, "error_msg": why}

    def _replace(self) -> None:
        if self.running is not None:
            self._conclude(self.running, "failed", "a newer goal replaced this one", 0)

    def _conclude(self, running: RunningGoal, end: End, why: str, error: int) -> None:
        self._end(running, end, self.result(error, why), why)


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

    def arrived(self, since_s: float, *, charging: bool) -> tuple[End | Literal[""], str, int]:
        if charging:
            return "succeeded", "", 0
        return ("failed", "the charger does not notice the robot", NOT_CHARGED) if since_s > CHARGE_S else ("", "", 0)

    def feedback(self, pose: RobotPose, taken_s: float) -> dict[str, Any]:
        return {"state": 1, "docking_time": stamp(taken_s), "num_retries": self.navigator.recoveries}

    def result(self, error: int, why: str) -> dict[str, Any]:
        error = error if error in (0, NOT_CHARGED) else NOT_STAGED
        retries = self.navigator.recoveries
        return {"success": not why, "error_code": error, "num_retries": retries, "error_msg": why}


class Wait(GoalServer):
    """nav2_msgs/action/Wait: stay for a while; it moves nothing, and is no concern of the navigation."""

    _until = 0.0

    def accept(self, goal_id: str, goal: Data, report: OnReport) -> None:
        running, time = RunningGoal(goal_id, report, self.at), goal.get("time")
        lasts = _seconds(time)
        if lasts is None:
            self._reject(running, f"{time!r} is no time to wait; give 'sec' and 'nanosec', 0 or more")
            return
        if self.running is not None:
            self._conclude(self.running, "failed", "a newer goal replaced this one")
        self._until = self.at + lasts
        self._begin(running)

    def cancel(self, goal_id: str) -> None:
        if self.running is not None and self.running.goal_id == goal_id:
            self._conclude(self.running, "canceled", "canceled")

    def step(self, at: float, _pose: RobotPose, *, charging: bool) -> None:
        """Report what has come about."""
        self.at, running = at, self.running
        if running is None:
            return
        if at >= self._until - 1e-9:
            self._conclude(running, "succeeded", "")
        else:
            self._feed_back(running, lambda _taken_s: {"time_left": stamp(self._until - at)})

    def _conclude(self, running: RunningGoal, end: End, why: str) -> None:
        self._end(running, end, {"total_elapsed_time": stamp(self.at - running.begun)}, why)


def _seconds(time: Any) -> float | None:
    """A builtin_interfaces/msg/Duration, or seconds; None where it is neither, or negative."""
    if isinstance(time, Mapping):
        parts = (time.get("sec", 0), time.get("nanosec", 0))
        if not all(map(is_number, parts)):
            return None
        time = parts[0] + parts[1] / 1e9
    return float(time) if is_number(time) and time >= 0 else None


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
