# SPDX-License-Identifier: Apache-2.0
"""A robot that is a few Python functions, and the connector that calls them.

Imports the modules of the root only.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from rai_missions.connectors.python_robot.action import ActionRun
from rai_missions.connectors.python_robot.connector import PythonRobotConnector
from rai_missions.connectors.python_robot.robot import PythonRobot
from rai_missions.connectors.python_robot.robot_time import RobotTime
from rai_missions.errors import lazy_names

if TYPE_CHECKING:
    from rai_missions.connectors.python_robot.tasks import AsyncActionRun

__all__ = ("ActionRun", "AsyncActionRun", "PythonRobot", "PythonRobotConnector", "RobotTime")

if not TYPE_CHECKING:  # asyncio is loaded by the name that needs it
    __getattr__, __dir__ = lazy_names(globals(), {"tasks": ("AsyncActionRun",)})
