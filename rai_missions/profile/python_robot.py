# SPDX-License-Identifier: Apache-2.0
"""A robot in Python as a profile, which is all that a run, its journal and a replay know of it.

Rule: only a file that a person names is executed, and only as the bytes whose hash is in the journal. No profile in
JSON and no journal leads here.
"""

from __future__ import annotations

import hashlib
import sys
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from pathlib import Path
from types import ModuleType
from typing import Any

from rai_missions.connectors.python_robot import PythonRobot
from rai_missions.connectors.python_robot.robot import EVENTS, FACTS, MESSAGES
from rai_missions.errors import DefinitionError, Fault, file_text
from rai_missions.mission.json_reader import file_bytes
from rai_missions.mission.mission import Mission
from rai_missions.mission.python_file import call_offered, run_file
from rai_missions.model.validation_errors import validated
from rai_missions.profile.coverage import missing
from rai_missions.profile.profile import Robot
from rai_missions.redaction import shown

__all__ = ("KIND", "RobotProgram", "check_functions", "profile_of", "read_program")

KIND = "python"
"""The kind of its connector; a run opens it for a program that was named, and for nothing else."""


class RobotProgram:
    """A file in Python that offers a robot, executed once.

    Args:
        file: Where it is.
        sha256: Of its bytes, in hex.
        module: What it left.
    """

    def __init__(self, file: Path, sha256: str, module: ModuleType) -> None:
        self.file, self.sha256, self.module = file, sha256, module
        self._next: PythonRobot | None = None

    def ready(self) -> PythonRobot:
        """The robot of the next run, made now, so that what it lacks is known before the run begins.

        Raises:
            DefinitionError: As `robot`.
        """
        self._next = self._next or self._made()
        return self._next

    def robot(self) -> PythonRobot:
        """The file's `robot`, or what its `robot()` makes for a run.

        Raises:
            DefinitionError: It offers none, or `robot()` raises.
        """
        made, self._next = self._next or self._made(), None
        return made

    def _made(self) -> PythonRobot:
        offered = getattr(self.module, "robot", None)
        if callable(offered) and not isinstance(offered, PythonRobot):
            with _neighbours(self.file):
                offered = call_offered(offered, self.file)
            if not isinstance(offered, PythonRobot):
                raise self._refused(f"robot() returned {shown(repr(offered))}; return a PythonRobot")
        if not isinstance(offered, PythonRobot):
            there = "the file offers no 'robot'" if offered is None else f"its 'robot' is {shown(repr(offered))}"
            raise self._refused(f'{there}; write `robot = PythonRobot("name")`, or `def robot()` for one a run')
        return offered

    def _refused(self, sentence: str) -> DefinitionError:
        return DefinitionError([Fault("", sentence)], str(self.file))


def read_program(path: str | Path, *, expected: str | None = None) -> RobotProgram:
    """Execute the file of a robot.

    Args:
        path: The file.
        expected: The hash that it must have to be executed; None for any.

    Raises:
        DefinitionError: It has another hash, or cannot be executed.
        UsageError: There is no such file.
    """
    file = Path(path)
    source, sha256 = same_file(file, expected)
    with _neighbours(file):
        return RobotProgram(file, sha256, run_file(file, source))


def same_file(file: Path, expected: str | None) -> tuple[bytes, str]:
    """The bytes of a robot's file and their hash; nothing is executed.

    Raises:
        DefinitionError: It has another hash than is expected.
        UsageError: There is no such file.
    """
    source = file_bytes(file)
    sha256 = hashlib.sha256(source).hexdigest()
    if expected is not None and sha256 != expected:
        sentence = (
            f"the run's robot was another file, or has changed since (sha256 {expected[:12]}…, now {sha256[:12]}…)"
        )
        raise DefinitionError([Fault("", f"{sentence}; resume with the file as it was")], str(file))
    return source, sha256


@contextmanager
def _neighbours(file: Path) -> Iterator[None]:
    """While it lasts, modules next to a file can be imported, as in a program that Python is started with."""
    folder = str(file.resolve().parent)
    sys.path.insert(0, folder)
    try:
        yield
    finally:
        with suppress(ValueError):  # the file may have set the path as it likes
            sys.path.remove(folder)


def profile_of(
    robot: PythonRobot, mission: Mission | None, program: RobotProgram | None = None, *, known: Iterable[str] = ()
) -> Robot:
    """The profile of a robot in Python, for a mission.

    Args:
        robot: The robot.
        mission: Whose events and keys it may bring; None where it is not known.
        program: Where it comes from, if from a file.
        known: Keys that it has brought in an earlier process.

    Raises:
        DefinitionError: Its rules, or how it talks, are at fault.
    """
    origin = {} if program is None else {"file": file_text(program.file.name), "sha256": program.sha256}
    facts = {
        name: {"topic": FACTS + name, "field": "value"}
        for name in _facts(robot, mission, known)
        if mission is None or name in mission.blackboard
    }
    source = robot.name if program is None else str(program.file)
    return validated(Robot, _written(robot, mission, facts, {"kind": KIND, **origin}), source)


def check_functions(robot: PythonRobot, mission: Mission, source: str, *, known: Iterable[str] = ()) -> None:
    """Check that a robot in Python has a function for all that a mission uses.

    Args:
        robot: The robot.
        mission: What is to run on it.
        source: Its file or name, for the faults.
        known: Keys that it has brought in an earlier process.

    Raises:
        DefinitionError: It lacks some: every name at once.
    """
    facts = {name: {"topic": FACTS + name, "field": "value"} for name in _facts(robot, mission, known)}
    profile = validated(Robot, _written(robot, mission, facts, {"kind": KIND}), source)
    if faults := missing(mission, profile, remedies=REMEDIES):
        raise DefinitionError(faults, source)


REMEDIES: Mapping[str, str] = {
    "blackboard": 'write `@robot.fact("{}")`, or `robot.fact("{}")` where robot.write brings it',
    "services": 'write `@robot.service("{}")`',
    "actions": 'write `@robot.action("{}")`',
    "topics": 'write `@robot.topic("{}")`',
}
"""Section of a profile → what makes a robot in Python have a name in it."""


def _facts(robot: PythonRobot, mission: Mission | None, known: Iterable[str]) -> dict[str, None]:
    """The keys that it brings; one that need not be there may be written without being declared."""
    keys = mission.blackboard if mission is not None else {}
    optional = [name for name, key in keys.items() if key.source == "robot" and key.optional]
    return dict.fromkeys([*robot.fact_functions, *robot.written, *optional, *known])


def _written(
    robot: PythonRobot, mission: Mission | None, facts: Mapping[str, Any], connector: Mapping[str, Any]
) -> dict[str, Any]:
    """The profile as its JSON would be."""
    optional = {"about": robot.about or None, "conversation": robot.conversation}
    return {
        "format": 1,
        "name": robot.name,
        "connector": connector,
        "blackboard": facts,
        "events": {name: {"topic": EVENTS + name} for name in (mission.events if mission is not None else ())},
        "actions": {
            name: {"action": name, "uses": list(action.uses), "keep": action.keep, "repeat": action.repeat}
            for name, action in robot.action_functions.items()
        },
        "services": {
            name: {"service": name, "type": "", "repeat": service.repeat}
            for name, service in robot.service_functions.items()
        },
        "topics": {name: {"topic": MESSAGES + name, "type": ""} for name in robot.topic_functions},
        "rules": robot.rules,
    } | {word: value for word, value in optional.items() if value is not None}
