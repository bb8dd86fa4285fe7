# SPDX-License-Identifier: Apache-2.0
"""A robot in Python for a run: which file is executed, whether it covers the mission, whether it is still the same.

Rule: a run that resumes executes no file but the one whose hash is in its journal.
"""

from __future__ import annotations

from typing import Any, NamedTuple

from rai_missions.connectors.python_robot import PythonRobot
from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, RobotProgram, check_functions, is_program, profile_of, read_program
from rai_missions.profile.python_robot import KIND
from rai_missions.redaction import shown

__all__ = ("ChosenRobot", "open_python_robot")


class ChosenRobot(NamedTuple):
    """A robot in Python, and what a run and its journal know of it."""

    robot: PythonRobot
    profile: Robot


def open_python_robot(given: Any, mission: Mission, before: Robot | None) -> ChosenRobot | None:
    """The robot in Python that a run names; None where it names none.

    Args:
        given: What was named as the robot.
        mission: What is to run on it.
        before: The profile of a run that resumes.

    Raises:
        DefinitionError: The file cannot be executed, is not the one of the run that resumes, or lacks what the mission
            uses: every name at once.
        UsageError: The run that resumes needs its robot, or had none in Python.
    """
    was = before.connector if before is not None and before.connector["kind"] == KIND else None
    program = given if isinstance(given, RobotProgram) else None
    if program is None and not isinstance(given, PythonRobot) and not is_program(given):
        if was is not None:
            file = shown(str(was.get("file", "its robot")))
            raise UsageError(f"the run's robot is in Python; resume with the same file: --robot {file}")
        return None
    if before is not None and was is None:
        raise UsageError("the run that resumes had a robot profile, not a robot in Python; resume without naming one")
    expected = None if was is None or "sha256" not in was else str(was["sha256"])
    if is_program(given):
        program = read_program(given, expected=expected)
    elif expected is not None and (program is None or program.sha256 != expected):
        raise UsageError("the run's robot was another file, or has changed since; resume with the file as it was")
    robot = program.robot() if program is not None else given
    source = str(program.file) if program is not None else robot.name
    known = before.blackboard if before is not None else ()
    check_functions(robot, mission, source, known=known)
    return ChosenRobot(robot, profile_of(robot, mission, program, known=known))
