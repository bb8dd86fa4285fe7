# SPDX-License-Identifier: Apache-2.0
"""All tools over one connector, with one list of what they may touch.

Rule: what only looks is marked so; a decision is given nothing else.
"""

from __future__ import annotations

from collections.abc import Callable

from rai_missions.connectors.connector import Connector
from rai_missions.tools import arguments as args
from rai_missions.tools.access import AllowedConnector, until
from rai_missions.tools.actuators import ActuatorTools
from rai_missions.tools.allowlist import Allowlist
from rai_missions.tools.geometry import GeometryTools
from rai_missions.tools.goals import GoalState, ToolGoals
from rai_missions.tools.navigation import NavigationTools
from rai_missions.tools.sensors import SensorTools
from rai_missions.tools.tool import RobotTool, robot_tool

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
        self.tools: tuple[RobotTool, ...] = (*_that_look(self), *_that_act(self))

    @property
    def read_only(self) -> tuple[RobotTool, ...]:
        """The tools that only look."""
        return tuple(tool for tool in self.tools if tool.is_read_only)

    def stop(self, within_s: float = 5.0) -> tuple[GoalState, ...]:
        """Cancel the goals that still run and end every wait; the goals whose end no one confirmed in time."""
        left = self._goals.stop(until(within_s))
        self.measuring.stop()
        self._reach.stop()
        return left

    def close(self) -> None:
        """Stop, for a caller that needs no answer."""
        self.stop()


def _that_look(box: Toolbox) -> tuple[RobotTool, ...]:
    """Each has the name of its function."""
    look, measure, drive = box.looking, box.measuring, box.navigating
    rows = (
        ("The robot's topics with their types.", args.List, look.list_topics),
        ("The robot's services with their types.", args.List, look.list_services),
        ("The robot's actions with their types.", args.List, look.list_actions),
        ("The fields of a message, service or action type.", args.DescribeType, look.describe_type),
        (
            "The newest message of a topic, with its age in seconds. States it if none comes in time.",
            args.ReceiveMessage,
            look.receive_message,
        ),
        ("The newest picture of a camera, with its age in seconds.", args.GetImage, look.get_image),
        (
            "Where one coordinate frame lies in another: translation in metres, rotation as a quaternion, yaw.",
            args.GetTransform,
            measure.get_transform,
        ),
        (
            "How far from the camera, in metres, the objects are that a detector sees.",
            args.GetDistanceToObjects,
            measure.get_distance_to_objects,
        ),
        ("Where the robot is: x, y and yaw in a frame.", args.GetRobotPose, drive.get_robot_pose),
        (
            "The robot's map, or its part around a point, in at most 40 rows of characters: free, occupied, unknown.",
            args.GetOccupancyGrid,
            drive.get_occupancy_grid,
        ),
        ("The goals that were started here, with their states.", args.ListGoals, box.acting.list_goals),
        (
            "How a goal is that start_action or navigate_to_pose started: running, succeeded, aborted, canceled, "
            "rejected or lost, with its feedback and result. Waits for its end as long as it may.",
            args.WatchAction,
            box.acting.watch_action,
        ),
    )
    return tuple(robot_tool(act.__name__, about, takes, act, read_only=True) for about, takes, act in rows)


def _that_act(box: Toolbox) -> tuple[RobotTool, ...]:
    rows = (
        ("Publish one message on a topic.", args.PublishMessage, box.acting.publish_message),
        ("Call a service and wait for its reply.", args.CallService, box.acting.call_service),
        (
            "Start an action. Reports whether its server took the goal, and the goal's id for watch_action and "
            "cancel_action; it does not wait for the end, and an accepted goal has not succeeded.",
            args.StartAction,
            box.acting.start_action,
        ),
        (
            "Send the robot to a pose, with Nav2. Reports whether it took the goal, and the goal's id, as start_action "
            "does.",
            args.NavigateToPose,
            box.navigating.navigate_to_pose,
        ),
        (
            "Ask for the end of a goal, and state how it ended or that it has not.",
            args.CancelAction,
            box.acting.cancel_action,
        ),
    )
    return tuple(robot_tool(act.__name__, about, takes, act, read_only=False) for about, takes, act in rows)
