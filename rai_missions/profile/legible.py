# SPDX-License-Identifier: Apache-2.0
"""What can be read of a profile of which some entries cannot, so that what it lacks is found as well."""

from __future__ import annotations

import os
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from rai_missions.errors import DefinitionError, Fault, steps_of
from rai_missions.mission.file_kinds import object_of
from rai_missions.mission.json_reader import read_json
from rai_missions.mission.mission import Mission
from rai_missions.model.validation_errors import faults_of
from rai_missions.profile.connector_faults import connector_faults
from rai_missions.profile.coverage import missing
from rai_missions.profile.files import load_profile
from rai_missions.profile.profile import Robot

__all__ = ("legible_profile", "load_whole_profile", "missing_anyway")

ROUNDS = 10
"""A profile that is not read after entries were left out so many times is left."""
SECTIONS = frozenset({"blackboard", "events", "actions", "services", "topics", "rules", "control"})
"""The words whose value has entries by names."""

WITH_THE_REST = ("connector", "events")
"""The words that are held against the rest of a profile; what is wrong there has no place of its own."""


def load_whole_profile(path: str | os.PathLike[str], mission: Mission | None) -> Robot:
    """The profile in a file, as `load_profile`; where it cannot be read, what is wrong in the rest is in the error too.

    Args:
        path: The file.
        mission: What is to run on the robot; None where it is not known.

    Raises:
        DefinitionError: The profile is at fault; every fault with its pointer.
        UsageError: There is no such file, or it is a robot in Python.
    """
    try:
        return load_profile(path)
    except DefinitionError as error:
        raise DefinitionError((*error.faults, *_rest_faults(Path(path), mission)), error.source) from None


def _rest_faults(path: Path, mission: Mission | None) -> Iterator[Fault]:
    """What is wrong with a profile of which some entries cannot be read, whatever those turn out to be."""
    try:
        document = object_of("profile", read_json(path), str(path))
    except DefinitionError:
        return
    robot = legible_profile(document)
    if robot is None:
        return
    if robot.connector == document.get("connector"):
        yield from (each for each in connector_faults(robot) if each.place.startswith("/connector"))
    if mission is not None:
        yield from missing_anyway(mission, robot, document)


def legible_profile(data: Any) -> Robot | None:
    """A profile without the entries that cannot be read; None where too little is left.

    Args:
        data: The JSON document.
    """
    if not isinstance(data, Mapping):
        return None
    rest = {word: dict(item) if isinstance(item, Mapping) else item for word, item in data.items()}
    for _ in range(ROUNDS):
        rest.setdefault("name", "unread")
        try:
            return Robot.model_validate(rest)
        except ValidationError as error:
            for fault in faults_of(error, Robot, rest):
                section, *inside = steps_of(fault.place) or ("",)
                if inside and section in SECTIONS:
                    rest[section].pop(inside[0], None)
                    continue
                for word in (section,) if section else WITH_THE_REST:
                    rest.pop(word, None)
    return None


def missing_anyway(mission: Mission, robot: Robot, data: Mapping[str, Any]) -> Iterator[Fault]:
    """What a profile lacks for a mission, whatever its unreadable entries turn out to be.

    Args:
        mission: The mission.
        robot: What could be read of the profile.
        data: The JSON document of the whole.
    """
    for fault in missing(mission, robot):
        section, *inside = steps_of(fault.place)
        written = data.get(section, {})
        if len(inside) == 1 and isinstance(written, Mapping) and inside[0] not in written:
            yield fault
