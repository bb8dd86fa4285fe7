# SPDX-License-Identifier: Apache-2.0
"""A robot that is a few Python functions, and the connector that calls them.

Imports the modules of the root only.
"""

from rai_missions.connectors.python_robot.action import ActionRun, AsyncActionRun
from rai_missions.connectors.python_robot.connector import PythonRobotConnector
from rai_missions.connectors.python_robot.robot import PythonRobot
from rai_missions.connectors.python_robot.robot_time import RobotTime

__all__ = ("ActionRun", "AsyncActionRun", "PythonRobot", "PythonRobotConnector", "RobotTime")
