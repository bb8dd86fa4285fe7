# SPDX-License-Identifier: Apache-2.0
"""All tools over one connector, with one list of what they may touch.

Rule: what only looks is marked so; a decision is given nothing else.
"""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.connectors.connector import Connector
from rai_missions.tools.access import AllowedConnector, until
from rai_missions.tools.actuators import ActuatorTools
from rai_missions.tools.allowlist import Allowlist
from rai_missions.tools.geometry import GeometryTools
from rai_missions.tools.goals import GoalState, ToolGoals
from rai_missions.tools.navigation import NavigationTools
from rai_missions.tools.result import ToolResult
from rai_missions.tools.sensors import SensorTools
from rai_missions.tools.tool import RobotTool, is_read_only, robot_tool

__all__ = ("Toolbox",)


class Toolbox:
    """Tools for models and for programs.

    For a program the tools are plain functions, `toolbox.looking.receive_message("/battery").data`, which raise
    `MissionError`; for a model they are langchain's, in `tools`, which raise nothing.

    Args:
        connector: Started, and stopped, by its owner.
        allowed: What may be read, written and never touched; left out, everything may be read and nothing written.
        now: Seconds on the clock that stamps the connector's messages: the run's.
    """

    def __init__(self, connector: Connector, allowed: Allowlist | None = None, *, now: Callable[[], float]) -> None:
        self.allowed = allowed or Allowlist()
        self._reach = AllowedConnector(connector, self.allowed, now)
        self._goals = ToolGoals(self._reach)
        self.looking, self.measuring = SensorTools(self._reach), GeometryTools(self._reach)
        self.acting = ActuatorTools(self._reach, self._goals)
        self.navigating = NavigationTools(self._reach, self.measuring, self._goals)
        look, measure, drive, act = self.looking, self.measuring, self.navigating, self.acting
        looks: tuple[Callable[..., ToolResult], ...] = (
            look.list_topics,
            look.list_services,
            look.list_actions,
            look.describe_type,
            look.receive_message,
            look.get_image,
            measure.get_transform,
            measure.get_distance_to_objects,
            drive.get_robot_pose,
            drive.get_occupancy_grid,
            act.list_goals,
            act.watch_action,
        )
        acts: tuple[Callable[..., ToolResult], ...] = (
            act.publish_message,
            act.call_service,
            act.start_action,
            drive.navigate_to_pose,
            act.cancel_action,
        )
        self.tools: tuple[RobotTool, ...] = (
            *(robot_tool(each, read_only=True) for each in looks),
            *(robot_tool(each, read_only=False) for each in acts),
        )

    @property
    def read_only(self) -> tuple[RobotTool, ...]:
        """The tools that only look."""
        return tuple(filter(is_read_only, self.tools))

    def stop(self, within_s: float = 5.0) -> tuple[GoalState, ...]:
        """Cancel the goals that still run and end every wait; the goals whose end no one confirmed in time."""
        left = self._goals.stop(until(within_s))
        self.measuring.stop()
        self._reach.stop()
        return left

    def close(self) -> None:
        """Stop, for a caller that needs no answer."""
        self.stop()
