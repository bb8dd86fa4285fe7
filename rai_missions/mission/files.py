# SPDX-License-Identifier: Apache-2.0
"""Missions in files: `.json` or `.py` to a `Mission`, and back to JSON.

Rule: whatever a file holds, it becomes a `Mission` or a `DefinitionError` with every fault and its place.
"""

from __future__ import annotations

import json
import os
import secrets
import stat
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.errors import make_folder_of
from rai_missions.mission.garbage import few_collections

if TYPE_CHECKING:
    from rai_missions.mission.mission import Mission

__all__ = ("SCHEMA", "dump", "journal_text", "load", "write_atomically", "written_mission")

SCHEMA = "mission.schema.json"
"""Where an editor looks for the schema: next to the mission. `rai-missions schema` prints it."""

# The models are imported when used, so that the package's front door can offer these functions and stay light.


@few_collections()
def load(path: str | os.PathLike[str], *, python: bool = True) -> Mission:
    """The mission in a file, with the missions that it includes expanded.

    Args:
        path: A `.json` file, or a `.py` file, which is executed; its `mission` is a `Mission` or a function of it.
        python: Whether a `.py` file may be executed.

    Raises:
        DefinitionError: The mission is at fault; every fault with its JSON pointer.
        UsageError: There is no such file, or it is of another kind.
    """
    from rai_missions.mission.include import expanded

    return expanded(written_mission(path, python=python), Path(path))


def written_mission(path: str | os.PathLike[str], *, python: bool) -> Mission:
    """The mission in a file as it is written there: inclusions are states of their own.

    Args:
        path: As `load` takes it.
        python: Whether a `.py` file may be executed.

    Raises:
        DefinitionError: The mission is at fault; every fault with its JSON pointer.
        UsageError: There is no such file, or it is of another kind.
    """
    from rai_missions.errors import UsageError, meant_file
    from rai_missions.given import given_path
    from rai_missions.mission.include import read_mission
    from rai_missions.mission.python_file import run_mission_file

    file = given_path(path, "load")
    if file.suffix == ".json":
        return read_mission(file)
    if file.suffix == ".py":
        if not python:
            raise UsageError(f"'{file}' is Python, which is not to be executed here; give the mission as JSON")
        return run_mission_file(file)
    if str(path).lstrip().startswith("{"):
        raise UsageError("this is the text of a mission; load takes its file, Mission.model_validate_json the text")
    raise UsageError(f"'{file}' is neither .json nor .py; a mission is one of them{meant_file(file, '.json', '.py')}")


def dump(mission: Mission, path: str | os.PathLike[str] | None = None) -> str:
    """A mission as JSON text: `load` gives an equal one from its file, `Mission.model_validate_json` from the text.

    Args:
        mission: Whatever was built or loaded.
        path: Where to write it too; the file is replaced at once, or left as it was.

    Raises:
        DefinitionError: It nests deeper than `load` would read.
        UsageError: It is no mission.
    """
    from rai_missions.errors import DefinitionError, Fault
    from rai_missions.mission.json_reader import MAX_DEPTH, too_deep
    from rai_missions.mission.mission import given_mission

    written: dict[str, Any] = {"$schema": SCHEMA, **given_mission(mission, "dump").written()}
    text = json.dumps(written, indent=2, ensure_ascii=False, allow_nan=False) + "\n"
    if too_deep(text) is not None:
        raise DefinitionError([Fault("", f"more than {MAX_DEPTH} objects and lists inside each other; nest less")])
    if path is not None:
        write_atomically(Path(path), text.encode())
    return text


def journal_text(mission: Mission) -> str:
    """A mission as a journal holds it: empty with behaviours in Python, which have no JSON; a replay needs its file."""
    return "" if mission.behaviours() else dump(mission)


def write_atomically(path: Path, data: bytes) -> None:
    """Write a file so that a reader finds the old one or the new one, never a part; its permissions stay.

    Its folder is made where there is none.

    The system gives a new file its permissions as it is created, so that no thread has to change the process's mask.

    Raises:
        OSError: It cannot be written; nothing is left behind.
    """
    part = path.with_name(f".{path.name}.{secrets.token_hex(8)}")
    make_folder_of(part)
    try:
        with part.open("xb") as file:
            if path.exists():
                part.chmod(stat.S_IMODE(path.stat().st_mode))
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        part.replace(path)
    except BaseException:
        part.unlink(missing_ok=True)
        raise
