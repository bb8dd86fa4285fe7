# SPDX-License-Identifier: Apache-2.0
"""What a node needs before it can begin: a mission without faults, and clients that answer as the operator."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from rai_missions.agents.mission import RunConfig
from rai_missions.agents.run_plan import profile_of
from rai_missions.check import errors_of, load_whole
from rai_missions.connectors.python_robot import PythonRobot
from rai_missions.engine.decision import Question
from rai_missions.errors import DefinitionError, MissionError, UsageError
from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot, RobotProgram, check_functions, middleware_faults, missing

__all__ = ("Clients", "about", "readied")

OUTSIDE = re.compile(r"^(?=\d)|[^A-Za-z0-9_]")
"""What a node's name may not have, or, before a digit, not begin with."""


class Clients:
    """The operator, wherever on the graph: the status shows a question, and an order brings the answer."""

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Nothing to do: the status shows it, and the answer comes as an order."""

    def withdraw(self, number: int) -> None:
        """Nothing to do: the status no longer shows it."""


def about(given: Mission | str | Path | None) -> tuple[str, tuple[str, str]]:
    """What a mission's node is called, and the mission's name and version as far as they are known.

    A file that is at fault now, which may be mended before the node is configured, lends its own name.
    """
    if isinstance(given, str | Path):
        try:
            given = load_whole(given)
        except MissionError:
            return OUTSIDE.sub("_", Path(str(given)).stem), ("", "")
    return (given.stem, (given.name, given.version)) if given is not None else ("", ("", ""))


def readied(setting: RunConfig) -> tuple[Mission, Robot | None]:
    """The mission and the profile, read and checked; nothing is begun.

    Raises:
        DefinitionError: One of them is at fault: every fault at once.
        UsageError: There is no such file, or journals cannot be written.
    """
    given = setting.mission
    if given is None:
        raise UsageError("a node needs to know its mission; name its file")
    mission = given if isinstance(given, Mission) else load_whole(given)
    source = "" if isinstance(given, Mission) else str(given)
    if faults := errors_of(mission, source, named=setting.named or {}):
        raise DefinitionError(faults, source)
    robot = profile_of(replace(setting, mission=mission))
    if robot is not None:
        lacks = missing(mission, robot) or (middleware_faults(mission, robot) if setting.connector is None else ())
        if lacks:
            raise DefinitionError(lacks, "" if isinstance(setting.robot, Robot) else str(setting.robot))
    if isinstance(setting.robot, PythonRobot | RobotProgram):
        _cover(setting.robot, mission)
    if setting.journal is not None:
        _writable(Path(setting.journal).parent)
    return mission, robot


def _cover(given: PythonRobot | RobotProgram, mission: Mission) -> None:
    """Check that a robot in Python has what the mission uses.

    Raises:
        DefinitionError: It lacks some: every name at once.
    """
    robot, source = (given.ready(), str(given.file)) if isinstance(given, RobotProgram) else (given, given.name)
    check_functions(robot, mission, source)


def _writable(folder: Path) -> None:
    existing = next(each for each in (folder, *folder.absolute().parents) if each.exists())
    if not os.access(existing, os.W_OK):
        raise UsageError(f"no journal can be written in {folder}; give another with --journal")
