# SPDX-License-Identifier: Apache-2.0
"""`rai-missions run --resume JOURNAL MISSION --migrate MAP`: a run that resumes in a mission that has changed."""

from __future__ import annotations

import itertools
from pathlib import Path
from typing import TYPE_CHECKING

from rai_missions.check import errors_of, load_whole
from rai_missions.cli.inputs import program_hashes, warn
from rai_missions.engine import Named
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.journal import opened
from rai_missions.redaction import shown

if TYPE_CHECKING:
    from rai_missions.cli.run.options import RunOptions
    from rai_missions.mission.mission import Mission
    from rai_missions.profile import Robot, RobotProgram

__all__ = ("migrated",)


def migrated(options: RunOptions, named: Named | None) -> tuple[RunOptions, RobotProgram | None]:
    """Make the journal of the run in the mission and on the robot as they are now.

    Returns:
        The options with which the run resumes from it, and its robot if that is in Python, executed once.

    Raises:
        DefinitionError: The mission, the robot or the map is at fault, or the map is not complete.
        UsageError: The run cannot be resumed, or the options do not name it, the mission, and a robot in Python.
    """
    from rai_missions.replay.migrate import load_map, migrate

    if not (options.migrate and options.resume and options.mission):
        raise UsageError("--migrate MAP goes with --resume JOURNAL and the mission as it is now: MISSION")
    mission = load_whole(options.mission, python=not options.no_python)
    if faults := errors_of(mission, options.mission, named=named or {}):
        raise DefinitionError(faults, options.mission)
    to = Path(options.journal) if options.journal else _free_name(Path(options.resume))
    robot, program = _robot_of_now(options, mission)
    done = migrate(
        options.resume,
        mission,
        load_map(options.migrate),
        to=to,
        robot=robot,
        named=named,
        programs=program_hashes(mission=options.mission, guards=options.guards),
        source=options.migrate,
    )
    warn(f"the run of {options.resume} resumes in {to}, as '{mission.name}' {mission.version}")
    for note in done.notes:
        warn(f"migrated: {note}")
    return options._replace(resume=str(to), journal=None), program


def _robot_of_now(options: RunOptions, mission: Mission) -> tuple[Robot | None, RobotProgram | None]:
    """The profile of the robot that is named, and its program; no profile where the journal's remains.

    Raises:
        DefinitionError: It is at fault, or lacks what the mission uses.
        UsageError: None is named, and the run's was in Python.
    """
    from rai_missions.profile import check_functions, is_program, load_whole_profile, profile_of, read_program
    from rai_missions.profile.python_robot import KIND
    from rai_missions.replay.rebuild import recorded_robot

    with opened(options.resume or "") as record:
        before, _ = recorded_robot(record)
    if not options.robot and before is not None and before.connector["kind"] == KIND:
        file = shown(str(before.connector.get("file", "its robot")))
        raise UsageError(f"the run's robot is in Python; give its file as it is now: --robot {file}")
    if not options.robot or not is_program(options.robot):
        return (load_whole_profile(options.robot, mission) if options.robot else None), None
    program = read_program(options.robot)
    same = before is not None and before.connector.get("sha256") == program.sha256
    robot, known = program.ready(), (before.blackboard if before is not None and same else ())
    check_functions(robot, mission, options.robot, known=known)
    return profile_of(robot, mission, program, known=known), program


def _free_name(journal: Path) -> Path:
    """A name that nothing has yet."""
    numbers = itertools.chain(("",), (f"-{number}" for number in itertools.count(2)))
    names = (journal.with_stem(f"{journal.stem}-migrated{number}") for number in numbers)
    return next(path for path in names if not path.exists())
