# SPDX-License-Identifier: Apache-2.0
"""`rai-missions doctor`."""

from __future__ import annotations

from pathlib import Path

from rai_missions.cli.command import MissionFile, RobotFile, command

__all__ = ("doctor",)


@command()
def doctor(
    *, robot: RobotFile | None = None, mission: MissionFile | None = None, no_python: bool = False, voice: bool = False
) -> int:
    """Check what this machine has, what it lacks and how to get it.

    Args:
        robot: Check also whether the profile's message types are installed, and whether its topics, services and
            actions are there. Of a robot in Python, check that its file loads; it is executed in a process of its own.
        mission: Check also whether the answerers of other packages that it asks can be opened, each in a process of
            its own.
        no_python: Refuse a robot or a mission in Python.
        voice: Open also what listens and speaks, and list the devices of sound.

    Exit status:
        0 nothing that is needed is missing (what only `warns` counts as there), 1 something is, 2 the input is at fault

    Example:
        rai-missions doctor --robot robot.json
    """
    from rai_missions.agents.talk.settings import conversation_faults
    from rai_missions.check import load_whole
    from rai_missions.cli.doctor import examine
    from rai_missions.cli.inputs import is_robot_program
    from rai_missions.errors import DefinitionError
    from rai_missions.profile import Robot, load_profile

    given: Robot | Path | None = None
    if robot:
        given = Path(robot) if is_robot_program(robot, python=not no_python) else load_profile(robot)
    is_missing = False
    whole = load_whole(mission, python=not no_python) if mission else None
    if isinstance(given, Robot) and (faults := conversation_faults(given, whole)):
        raise DefinitionError(faults, str(robot))
    for finding in examine(given, mission=whole, voice=voice):
        print(finding, flush=True)
        is_missing |= finding.status == "missing"
    return int(is_missing)
