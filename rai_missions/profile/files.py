# SPDX-License-Identifier: Apache-2.0
"""Robot profiles in files and texts.

Rule: whatever a file holds, it becomes a `Robot` or a `DefinitionError` with every fault and its place.
"""

from __future__ import annotations

import json
import os
from collections.abc import Mapping
from contextlib import suppress
from pathlib import Path
from typing import Any

from pydantic import ValidationError

from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.mission.file_kinds import object_of
from rai_missions.mission.json_reader import parse_json, read_json
from rai_missions.model import RECORDED
from rai_missions.model.validation_errors import validated
from rai_missions.profile.profile import Robot
from rai_missions.redaction import shown
from rai_missions.worlds.scene_files import with_scene_read

__all__ = ("dump_profile", "identity_folder", "is_program", "load_profile", "parse_profile", "recorded_profile")


def load_profile(path: str | os.PathLike[str]) -> Robot:
    """The robot profile in a JSON file.

    Raises:
        DefinitionError: The profile is at fault, or names a folder that is not next to it; every fault with its
            pointer.
        UsageError: There is no such file, or it is a robot in Python.
    """
    file = Path(path)
    if is_program(file):
        raise UsageError(f"'{file}' is a robot in Python, which only a run executes; give a profile in JSON, or none")
    robot = _robot(_whole(read_json(file), file), str(file))
    identity_folder(robot, file)
    return robot


def _whole(data: Any, file: Path) -> Any:
    """A profile's data with the scene of its simulated world, which may be in a file that is found from its own.

    Where that cannot be read, the world finds out, by the same path.
    """
    connector = data.get("connector") if isinstance(data, Mapping) else None
    if not isinstance(connector, Mapping) or connector.get("kind") != "local":
        return data
    folder = file.resolve().parent
    try:
        return {**data, "connector": with_scene_read(connector, folder)}
    except UsageError:
        return {**data, "connector": {**connector, "scene": str(folder / connector["scene"])}}


def is_program(given: object) -> bool:
    """Whether what is named as a robot is a file in Python; only its name is looked at."""
    return isinstance(given, str | os.PathLike) and Path(given).suffix == ".py"


def parse_profile(text: str, source: str = "") -> Robot:
    """The robot profile in JSON text; the folder that it names is not looked for.

    Raises:
        DefinitionError: The profile is at fault.
    """
    return _robot(parse_json(text.encode("utf-8", "surrogatepass"), source), source)


def recorded_profile(text: str, source: str) -> tuple[Robot, tuple[Fault, ...]]:
    """The robot profile in a journal, and what in it would be refused today where its run was accepted.

    Raises:
        DefinitionError: No run was made with it.
    """
    try:
        return parse_profile(text, source), ()
    except DefinitionError as error:
        data = parse_json(text.encode("utf-8", "surrogatepass"), source)
        with suppress(ValidationError):
            return Robot.model_validate(data, context=RECORDED), error.faults
        raise


def dump_profile(robot: Robot) -> str:
    """A profile as JSON text: `parse_profile` gives an equal one."""
    return json.dumps(robot.written(), indent=2, ensure_ascii=False, allow_nan=False) + "\n"


def identity_folder(robot: Robot, file: str | os.PathLike[str]) -> Path | None:
    """Where the identity of a profile is that was read from a file; None for one without.

    Raises:
        DefinitionError: It is no folder, or outside the file's own.
    """
    if not robot.identity:
        return None
    home = Path(file).resolve().parent
    try:
        folder = (home / robot.identity).resolve()
        if not folder.is_relative_to(home):
            sentence = f"{shown(robot.identity)} lies outside the profile's own folder; move it next to the profile"
        elif not folder.is_dir():
            sentence = f"there is no folder {shown(robot.identity)} next to the profile; add it or drop 'identity'"
        else:
            return folder
    except (OSError, ValueError, RuntimeError) as error:
        sentence = f"{shown(robot.identity)} is no folder's name: {error}"
    raise DefinitionError([Fault("/identity", sentence)], str(file))


def _robot(data: Any, source: str) -> Robot:
    return validated(Robot, object_of("profile", data, source), source)
