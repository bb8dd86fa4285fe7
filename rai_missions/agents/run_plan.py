# SPDX-License-Identifier: Apache-2.0
"""What a run is made of, read and checked before anything is opened.

Rule: every fault of a file is refused at once, under the path of the file that mends it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from contextlib import ExitStack
from pathlib import Path
from types import NoneType
from typing import TYPE_CHECKING, NamedTuple

from rai_missions.agents.python_robot import open_python_robot
from rai_missions.agents.run_config import RunConfig
from rai_missions.check import errors_of, load_whole
from rai_missions.connectors.python_robot import PythonRobot
from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.given import check_given
from rai_missions.mission.mission import Mission, given_mission
from rai_missions.profile import Robot, RobotProgram, identity_folder, is_program, load_whole_profile, missing
from rai_missions.redaction import logger, shown
from rai_missions.runtime.arguments import accepted
from rai_missions.runtime.clock import Clock, ContinuedClock

if TYPE_CHECKING:
    from rai_missions.replay.open_run import OpenedRun

__all__ = ("CleanupStack", "RunPlan", "profile_of", "read_plan")

log = logger(__name__)


class CleanupStack(ExitStack):
    """What is open, and closed in the opposite order; what cannot be closed is logged and keeps nothing else open."""

    def closes(self, close: Callable[[], object]) -> None:
        """Have something closed at the end."""

        def quietly() -> None:
            try:
                close()
            except Exception:
                log.exception("something of the run could not be closed")

        self.callback(quietly)


class RunPlan(NamedTuple):
    """What a run is made of, read and checked; nothing of it is open but the journal of a run that continues."""

    config: RunConfig
    mission: Mission
    robot: Robot | None
    identity: Path | None
    """The folder of the robot's identity."""
    resumed: OpenedRun | None
    python: PythonRobot | None = None
    """The robot, where it is one in Python; `robot` is then its profile."""

    def refuse(self, faults: Iterable[Fault], *named: object) -> None:
        """Raise the faults of a file, if there are any.

        Args:
            faults: Every one.
            named: What may be named by a path; the first that is, is where they are to be mended.
        """
        if found := tuple(faults):
            paths = (each for each in (*named, self.config.resume) if isinstance(each, str | Path))
            raise DefinitionError(found, str(next(paths, "")))

    def continued(self, clock: Clock) -> Clock:
        """A clock on which a run that continues has the time that it had left."""
        return clock if self.resumed is None else ContinuedClock(clock, self.resumed.resumption.at)


def profile_of(config: RunConfig) -> Robot | None:
    """The profile of a run; of one that resumes, that of its journal.

    None without one, and for a robot in Python, which makes one when a run is prepared.

    Raises:
        DefinitionError: It is at fault.
        UsageError: There is no such file.
    """
    robot = config.robot
    if isinstance(robot, Robot):
        return robot
    if isinstance(robot, str | Path):
        mission = config.mission if isinstance(config.mission, Mission) else None
        return None if is_program(robot) else load_whole_profile(robot, mission)
    if robot is not None or config.resume is None:
        return None
    from rai_missions.journal import opened
    from rai_missions.replay.rebuild import robot_of

    with opened(config.resume) as record:
        return robot_of(record)


def read_plan(config: RunConfig, closing: CleanupStack) -> RunPlan:
    """Read and check what a run is made of; nothing moves yet.

    Raises:
        DefinitionError: The mission or the profile is at fault, every fault at once.
        UsageError: Something named is not there.
    """
    speed: object = config.speed
    if speed is not None and not (isinstance(speed, int | float) and speed > 0):
        raise UsageError(f"{shown(speed)} is no speed; give a positive number such as 5, or infinity")
    plan = _read(config, closing)
    mission, resumed = plan.mission, plan.resumed
    plan.refuse(errors_of(mission, _named_file(config.mission), named=config.named), config.mission)
    if resumed is None:
        accepted(mission, config.arguments, whole=not config.waits)
    chosen = open_python_robot(config.robot, mission, resumed.robot if resumed is not None else None)
    if chosen is not None:
        plan = plan._replace(python=chosen.robot, robot=chosen.profile)
    if plan.robot is not None:
        plan.refuse(missing(mission, plan.robot), config.robot)
    elif resumed is None and config.connector is None and (needed := mission.needed_facts()):
        raise UsageError(f"the mission must receive {', '.join(needed)} from a robot, and none was given")
    return plan


def _read(config: RunConfig, closing: CleanupStack) -> RunPlan:
    """The mission and the profile of a run, from their files or from the journal of a run that continues."""
    mission = load_whole(config.mission) if isinstance(config.mission, str | Path) else config.mission
    robot, identity = _read_robot(config, mission)
    resumed = None
    if config.resume is not None:
        from rai_missions.replay.open_run import open_run

        resumed = open_run(config.resume, mission=mission, robot=robot, named=config.named, programs=config.programs)
        closing.closes(resumed.record.close)
        mission, robot = resumed.mission, robot or resumed.robot
    if mission is None:
        raise UsageError("no mission was named, and no run to resume")
    given_mission(mission, "a run")
    if robot is not None and robot.world and config.seed is not None:  # the journal has it with the rest
        robot = robot.model_copy(update={"connector": {**robot.connector, "seed": config.seed}})
    return RunPlan(config, mission, robot, identity, resumed)


def _read_robot(config: RunConfig, mission: Mission | None) -> tuple[Robot | None, Path | None]:
    """The profile that was given, unless it is a robot in Python, and the folder of its identity."""
    given = config.robot
    check_given(
        given,
        (Robot, PythonRobot, RobotProgram, str, Path, NoneType),
        "a run",
        "a Robot, a PythonRobot, or the file of either",
        "Robot.model_validate(…) makes one of data",
    )
    if isinstance(given, str | Path) and not is_program(given):
        robot = load_whole_profile(given, mission)
        return robot, identity_folder(robot, given)
    return given if isinstance(given, Robot) else None, None


def _named_file(mission: Mission | str | Path | None) -> str | Path:
    return mission if isinstance(mission, str | Path) else ""
