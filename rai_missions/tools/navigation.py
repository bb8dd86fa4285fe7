# SPDX-License-Identifier: Apache-2.0
"""What a mobile robot is asked for: where it is, what its map has, and to drive somewhere.

Rule: a goal is started as any other, under the same list of what may be written; it has an id, and an end.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Annotated, Any

from pydantic import Field

from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import cut_repr
from rai_missions.tools.access import AllowedConnector, Sample, until
from rai_missions.tools.actuators import result_of
from rai_missions.tools.arguments import Age, Metres, Name, Text, Timeout
from rai_missions.tools.geometry import GeometryTools
from rai_missions.tools.goals import ToolGoals
from rai_missions.tools.occupancy import LEGEND, grid_of
from rai_missions.tools.result import ToolResult
from rai_missions.tools.transforms import planar

__all__ = ("NavigationTools",)

POSE_TOPIC = "Where the robot publishes its pose, such as '/amcl_pose' or '/odom'; empty: from the transforms."
RADIUS_M = "Around the point: half of the side shown, in metres."
ACCEPT_S = "How long its server may take to accept it, in seconds; 0 to 60."
NAVIGATE_TYPE, GRID_TYPE = "nav2_msgs/action/NavigateToPose", "nav_msgs/msg/OccupancyGrid"


class NavigationTools:
    """The tools of a robot that drives.

    Args:
        reach: The way to the robot.
        measuring: Knows the transforms.
        goals: The goals that were started.
    """

    def __init__(self, reach: AllowedConnector, measuring: GeometryTools, goals: ToolGoals) -> None:
        self._reach, self._measuring, self._goals = reach, measuring, goals

    def get_robot_pose(
        self,
        *,
        topic: Annotated[Text, Field(description=POSE_TOPIC)] = "",
        frame: Annotated[Name, Field(description="Without a topic: the frame in which the pose is reported.")] = "map",
        robot_frame: Annotated[Name, Field(description="Without a topic: the robot's own frame.")] = "base_link",
        max_age_s: Age = None,
        timeout_s: Timeout = 2.0,
    ) -> ToolResult:
        """Where the robot is: x, y and yaw in a frame."""
        if topic:
            newest = self._newest(topic, "", max_age_s, timeout_s)
            return _pose(*_planar(newest.data), age_s=newest.age_s)
        found = self._measuring.get_transform(frame, robot_frame, max_age_s=max_age_s, timeout_s=timeout_s).data
        at = found["translation"]
        return _pose(found["target"], at["x"], at["y"], found["yaw"], age_s=found["age_s"])

    def get_occupancy_grid(
        self,
        topic: Annotated[Name, Field(description="The map's topic, of nav_msgs/msg/OccupancyGrid.")] = "/map",
        *,
        x: Annotated[
            Metres | None, Field(description="Only around this point of the map's frame, in metres; with y.")
        ] = None,
        y: Annotated[Metres | None, Field(description="Its other coordinate.")] = None,
        radius_m: Annotated[float, Field(gt=0, le=1e6, description=RADIUS_M)] = 5.0,
        max_age_s: Age = None,
        timeout_s: Timeout = 5.0,
    ) -> ToolResult:
        """The robot's map, or its part around a point.

        It is in at most 40 rows of characters: free, occupied, unknown.
        """
        if (x is None) != (y is None):
            raise UsageError("x and y: state both, or neither for the whole map")
        center = None if x is None or y is None else (x, y)
        newest = self._newest(topic, GRID_TYPE, max_age_s, timeout_s)
        grid = grid_of(newest.data)
        part = grid.window(center, radius_m)
        header = newest.data.get("header")
        facts: dict[str, Any] = {
            "frame": str(header.get("frame_id", "")) if isinstance(header, Mapping) else "",
            "lower left corner": {"x": round(part.corner[0], 3), "y": round(part.corner[1], 3)},
            "metres of a character": round(part.cell_m, 4),
            "turned by": round(grid.origin[2], 4),
            "rows": part.labelled(),
            "cells of the map": grid.counts(),
            **({} if center is None else {"at the point": grid.cell_at(*center)}),
        }
        words = (
            f"The map of {topic}, {newest.age_s:.2f} s old, each row with its metres above the lower left corner, "
            f"each character the worst of its cells: {LEGEND}."
        )
        data = {"topic": topic, "age_s": newest.age_s, **facts, "message": newest.data}
        return ToolResult(words, data, facts)

    def navigate_to_pose(
        self,
        x: Annotated[Metres, Field(description="Where to, in metres of the frame.")],
        y: Annotated[Metres, Field(description="Its other coordinate.")],
        *,
        yaw: Annotated[
            float, Field(ge=-7, le=7, allow_inf_nan=False, description="The heading there, in radians.")
        ] = 0.0,
        frame: Annotated[Name, Field(description="The frame of x, y and yaw.")] = "map",
        action: Annotated[Name, Field(description="The action's whole name.")] = "/navigate_to_pose",
        timeout_s: Annotated[Timeout, Field(description=ACCEPT_S)] = 5.0,
    ) -> ToolResult:
        """Send the robot to a pose, with Nav2.

        Reports whether it took the goal, and the goal's id, as start_action does.
        """
        if not all(map(math.isfinite, (x, y, yaw))):
            raise UsageError(f"x, y and yaw: ({x}, {y}, {yaw}) is no pose")
        ends = until(timeout_s)
        turned = {"x": 0.0, "y": 0.0, "z": math.sin(yaw / 2), "w": math.cos(yaw / 2)}
        pose = {"position": {"x": float(x), "y": float(y), "z": 0.0}, "orientation": turned}
        # Without a stamp: the newest transform counts.
        goal = {"pose": {"header": {"frame_id": frame}, "pose": pose}}
        self._reach.allowed.check(action, "write")
        return result_of(self._goals.start(action, NAVIGATE_TYPE, goal, ends))

    def _newest(self, topic: str, type_name: str, max_age_s: float | None, timeout_s: float) -> Sample:
        """The newest message, if it is no older than asked.

        Raises:
            ConnectorError: None came in time.
        """
        newest, too_old = self._reach.newest(topic, type_name, max_age_s, timeout_s)
        if newest is not None:
            return newest
        if too_old is not None:
            raise ConnectorError(f"what was received on {topic} is {too_old.age_s:.2f} s old, more than asked for")
        raise ConnectorError(f"nothing was received on {topic} within {timeout_s:g} s; what is so now is unknown")


def _pose(frame: str, x: float, y: float, yaw: float, *, age_s: float | None) -> ToolResult:
    numbers = {"x": x, "y": y, "yaw": yaw}
    when = "it does not change" if age_s is None else f"{age_s:.2f} s old"
    facts = {"frame": frame, **{name: round(number, 4) for name, number in numbers.items()}}
    return ToolResult(
        f"The robot's pose in metres and radians, {when}:", {"frame": frame, **numbers, "age_s": age_s}, facts
    )


def _planar(message: Mapping[str, Any]) -> tuple[str, float, float, float]:
    """Frame, x, y and yaw of a PoseStamped, a PoseWithCovarianceStamped or an Odometry."""
    try:
        frame, pose = str(message["header"]["frame_id"]), message["pose"]
        numbers = planar(pose.get("pose", pose))
    except (AttributeError, KeyError, TypeError, ValueError) as fault:
        raise ConnectorError(f"{cut_repr(message, 80)} holds no pose: {cut_repr(fault, 60)}") from None
    if not all(map(math.isfinite, numbers)):
        raise ConnectorError(f"the pose {numbers} is none")
    return frame, *numbers
