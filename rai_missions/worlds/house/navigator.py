# SPDX-License-Identifier: Apache-2.0
"""The navigation: plans a way, follows it, plans again when it is blocked, and recovers until it gives up.

Rule: it knows the map and what lidar and depth camera saw, and nothing else of the house.
"""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
from numpy.typing import NDArray

from rai_missions.worlds.house.collision_monitor import CollisionMonitor
from rai_missions.worlds.house.costmap import CELL_M, Costmap, points_along
from rai_missions.worlds.house.layout import NamedPose
from rai_missions.worlds.house.low_scan import LowPoints
from rai_missions.worlds.house.planner import plan
from rai_missions.worlds.house.recovery import Recovery, sort_of
from rai_missions.worlds.house.rosbot import FASTEST_MPS, RobotPose

__all__ = ("Navigator",)

NO_WAY, NO_PROGRESS = 308, 105
"""NO_VALID_PATH of nav2_msgs/action/ComputePathToPose, and FAILED_TO_MAKE_PROGRESS of FollowPath."""
ARRIVED_M, TURNED_RAD = 0.12, 0.12
AHEAD_M = 0.35
"""How far along the way it aims."""
PLAN_S, PATIENCE_S = 3.0, 10.0
"""How often it plans again, and how long it may take to come 0.2 m nearer."""
TOUCH_M = 0.22
"""So near ahead of the lidar nothing may be."""
LOW_STOP_M = 0.38
"""So near ahead what is low may be a person: the robot may turn, and drives on when it looks elsewhere."""
HIDDEN_M, BEAM_RAD = 0.06, 0.03
"""How much nearer than the lidar sees a low point must be, in beams so near it: else the lidar sees that thing, too."""

DriveOutcome = Literal["", "arrived", "failed"]


class Navigator:
    """Drives to one place at a time.

    Args:
        recoveries: How many are tried before it gives up.
    """

    def __init__(self, recoveries: int) -> None:
        self.costmap = Costmap()
        self._monitor = CollisionMonitor()
        self.goal: NamedPose | None = None
        self.number = 0
        """Of the goals that were begun: whose number it is not has been replaced."""
        self.outcome: DriveOutcome = ""
        self.why, self.error = "", 0
        self.recoveries = 0
        self._most = recoveries
        self._way: list[tuple[float, float]] = []
        self._recovery: Recovery | None = None
        self._turns = False
        self._ahead_m = self._behind_m = self._low_ahead_m = math.inf
        self._place = (0.0, 0.0)
        self._next_plan = self._best_at = 0.0
        self._best_m = math.inf

    @property
    def is_driving(self) -> bool:
        return self.goal is not None

    @property
    def left_m(self) -> float:
        """Along the way."""
        return sum(math.dist(one, other) for one, other in zip(self._way, self._way[1:], strict=False))

    def begin(self, goal: NamedPose, *, turns: bool, at: float) -> int:
        """Set out; the goal's number.

        Args:
            goal: Where to.
            turns: Whether its heading is meant too.
            at: Now.
        """
        self.stop()
        self.goal, self._turns, self.number = goal, turns, self.number + 1
        self.outcome, self.why, self.error, self.recoveries = "", "", 0, 0
        self._next_plan = self._best_at = at
        self._best_m = math.inf
        return self.number

    def stop(self) -> None:
        """Stop, whatever was meant."""
        self.goal, self._recovery, self._way = None, None, []

    def fail(self, why: str, error: int) -> None:
        self.stop()
        self.outcome, self.why, self.error = "failed", why, error

    def see(
        self,
        place: tuple[float, float],
        heading: float,
        angles: NDArray[np.float64],
        ranges: NDArray[np.float64],
        below: LowPoints | None = None,
    ) -> None:
        """Take in a scan, and what is below it.

        Args:
            place: The place of the lidar.
            heading: The heading of the robot.
            angles: Of the beams, from straight ahead.
            ranges: Metres.
            below: From the lidar's place.
        """
        self._place = place
        self.costmap.look(place, angles + heading, ranges)
        hits = np.isfinite(ranges)
        self._monitor.see(points_along(place, angles[hits] + heading, ranges[hits]))
        if below is not None:
            low = below.low[_unseen(below.low, angles, ranges)]
            self.costmap.look_down(_on_map(below.floor, place, heading), _on_map(low, place, heading))
        self._low_ahead_m = self.costmap.low_near(place, heading)
        self._ahead_m = min(float(np.min(ranges[np.abs(angles) < 0.5])), self._low_ahead_m)
        low_behind_m = self.costmap.low_near(place, heading + math.pi)
        self._behind_m = min(float(np.min(ranges[np.abs(angles) > math.pi - 0.5])), low_behind_m)
        if any(math.isinf(self.costmap.cost[self.costmap.cell(*point)]) for point in self._way[3:]):
            self._next_plan = 0.0

    def step(self, pose: RobotPose, at: float) -> tuple[float, float]:
        """Speed (m/s) and turn (rad/s) from here."""
        return self._monitor.reduced(pose[:2], pose.heading, self._command(pose, at))

    def _command(self, pose: RobotPose, at: float) -> tuple[float, float]:
        goal = self.goal
        if goal is None:
            return 0.0, 0.0
        if self._recovery is not None:
            if not self._recovery.is_over(at):
                return self._recovery.command(self._behind_m)
            self._recovery, self._next_plan, self._best_at, self._best_m = None, at, at, math.inf
        left = math.dist(pose[:2], goal[:2])
        if left < ARRIVED_M:
            return self._turn(pose, goal)
        if (at >= self._next_plan or not self._way) and not self._plan(pose, goal, at):
            return self._recover(f"no way leads to {_place(goal)}", NO_WAY, at)
        self._pass(pose)
        if self._ahead_m < TOUCH_M and abs(self._aim(pose)) < 0.5:
            return self._recover(f"something stands close ahead on the way to {_place(goal)}", NO_PROGRESS, at)
        if not self._is_getting_on(at):
            return self._recover(f"no progress on the way to {_place(goal)}", NO_PROGRESS, at)
        return self._follow(pose, left)

    def _plan(self, pose: RobotPose, goal: NamedPose, at: float) -> bool:
        grid = self.costmap
        cells = plan(grid.cost, grid.cell(pose.x, pose.y), grid.cell(*goal[:2]))
        self._next_plan = at + PLAN_S
        self._way = [] if cells is None else [*map(grid.middle, cells[:-1]), goal[:2]]
        return cells is not None

    def _recover(self, why: str, error: int, at: float) -> tuple[float, float]:
        if self.recoveries >= self._most:
            self.fail(f"{why}, after {self.recoveries} recoveries", error)
            return 0.0, 0.0
        sort = sort_of(self.recoveries)
        self.recoveries += 1
        if sort == "clear":
            self.costmap.clear(self._place)
        self._recovery, self._way = Recovery(sort, at), []
        return self._recovery.command(self._behind_m)

    def _is_getting_on(self, at: float) -> bool:
        left = self.left_m
        if left < self._best_m - 0.2 or left > self._best_m + 1.0:  # much farther: another way was taken
            self._best_m, self._best_at = left, at
        return at - self._best_at < PATIENCE_S

    def _pass(self, pose: RobotPose) -> None:
        """Drop what of the way lies behind."""
        ahead = self._way[:12]
        nearest = min(range(len(ahead)), key=lambda index: math.dist(ahead[index], pose[:2]))
        del self._way[:nearest]

    def _aim(self, pose: RobotPose) -> float:
        """The angle to the point that it aims at, from straight ahead."""
        index = min(len(self._way) - 1, max(1, round(AHEAD_M / CELL_M)))
        x, y = self._way[index]
        return _wrapped(math.atan2(y - pose.y, x - pose.x) - pose.heading)

    def _follow(self, pose: RobotPose, left: float) -> tuple[float, float]:
        aside = self._aim(pose)
        speed = FASTEST_MPS * max(0.0, math.cos(aside)) ** 2 * min(1.0, left / 0.3 + 0.1)
        return speed if self._low_ahead_m > LOW_STOP_M else 0.0, 2.5 * aside

    def _turn(self, pose: RobotPose, goal: NamedPose) -> tuple[float, float]:
        self._way = []
        aside = _wrapped(goal.heading - pose.heading) if self._turns else 0.0
        if abs(aside) > TURNED_RAD:
            return 0.0, 1.5 * aside + math.copysign(0.2, aside)
        if abs(pose.speed) < 0.05 and abs(pose.turn) < 0.2:
            self.stop()
            self.outcome = "arrived"
        return 0.0, 0.0


def _place(goal: NamedPose) -> str:
    """Where a goal is, in words."""
    return f"({goal.x:.2f}, {goal.y:.2f})"


def _unseen(points: NDArray[np.float64], angles: NDArray[np.float64], ranges: NDArray[np.float64]) -> NDArray[np.bool_]:
    """Which points the lidar looks over."""
    bearings = np.arctan2(points[:, 1], points[:, 0])
    is_near = np.abs(angles[None, :] - bearings[:, None]) < BEAM_RAD
    nearest = np.where(is_near, ranges[None, :], np.inf).min(axis=1)
    hidden: NDArray[np.bool_] = np.hypot(points[:, 0], points[:, 1]) < nearest - HIDDEN_M
    return hidden


def _on_map(points: NDArray[np.float64], place: tuple[float, float], heading: float) -> NDArray[np.float64]:
    cos, sin = math.cos(heading), math.sin(heading)
    turned: NDArray[np.float64] = points @ np.array([[cos, sin], [-sin, cos]])
    return turned + place


def _wrapped(angle: float) -> float:
    return (angle + math.pi) % (2 * math.pi) - math.pi
