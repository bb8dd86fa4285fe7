# SPDX-License-Identifier: Apache-2.0
"""Missions to begin from: folders of files, which are shipped and copied under the name of a mission of one's own.

Rule: nothing that is there is written over.
"""

from __future__ import annotations

import json
import re
import shutil
from collections.abc import Iterator, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

from rai_missions.errors import UsageError, make_folder_of, suggestion, without_marks

__all__ = ("Template", "copy_template", "templates", "tutorial_folder")

PACKAGE = Path(__file__).resolve().parents[1]
PLACEHOLDER = "my_mission"
"""What a template's mission is called in each of its files."""
MISSION_NAME = re.compile(r"[a-z][a-z0-9_]*")


class Template(NamedTuple):
    """A folder that can be copied."""

    name: str
    folder: Path
    is_example: bool
    """A shipped mission, copied as it is; its robot may need an extra."""
    about: str
    mission: str
    """The file of it that is run first."""
    robot: str
    """The file of the robot that it is run on first."""


@cache
def templates() -> Mapping[str, Template]:
    """Name → what there is to begin from, the usual one first.

    Raises:
        UsageError: This installation has none.
    """
    home = _shipped("templates", PACKAGE / "missions", PACKAGE.parent / "missions", with_file="templates.json")
    index = json.loads((home / "templates.json").read_text(encoding="utf-8"))
    made = [Template(name, home / "templates" / name, False, **words) for name, words in index["templates"].items()]
    made += [Template(name, home / name, True, **words) for name, words in index["examples"].items()]
    return {template.name: template for template in made}


def tutorial_folder() -> Path:
    """Where the steps of the tutorial are.

    Raises:
        UsageError: This installation has none.
    """
    places = (PACKAGE / "tutorial", PACKAGE.parent / "docs/tutorial")
    return _shipped("tutorial", *places, with_file="1_mission/mission.json")


def _shipped(what: str, installed: Path, checkout: Path, *, with_file: str) -> Path:
    """The folder of what is shipped, by a file that is in it."""
    for place in (installed, checkout):
        if (place / with_file).is_file():
            return place
    raise UsageError(f"this installation has no {what}; install the package again")


def copy_template(name: str, directory: Path) -> tuple[Path, ...]:
    """Make a folder with a mission of one's own, whole or not at all; the files made, in order.

    Raises:
        UsageError: No such template, the folder's name is none of a mission, or it holds something already or cannot
            be made.
    """
    template = templates().get(name)
    if template is None:
        raise UsageError(f"there is no template '{name}'{suggestion(name, templates())}")
    if not template.is_example:
        _check_name(directory)
    if directory.exists() and (not directory.is_dir() or any(directory.iterdir())):
        raise UsageError(f"'{directory}' is there and not empty; name a folder that is new")
    was_there = directory.exists()
    try:
        return tuple(_copied(template, directory))
    except BaseException as error:
        _remove(directory, keeps_folder=was_there)
        if not isinstance(error, OSError):
            raise
        raise UsageError(f"'{directory}' cannot be made: {error.strerror}") from error


def _remove(directory: Path, *, keeps_folder: bool) -> None:
    """Remove what was made in a folder that was empty or absent."""
    if not keeps_folder:
        shutil.rmtree(directory, ignore_errors=True)
        return
    for each in directory.iterdir():
        if each.is_dir():
            shutil.rmtree(each, ignore_errors=True)
        else:
            each.unlink()


def _check_name(directory: Path) -> None:
    """A folder has the name of its mission.

    Raises:
        UsageError: It cannot.
    """
    name = directory.resolve().name
    if MISSION_NAME.fullmatch(name):
        return
    near = re.sub(r"[^a-z0-9]+", "_", without_marks(name)).strip("_").lstrip("_0123456789")
    hint = f"; did you mean '{directory.parent / near}'?" if near else ""
    rule = "which is a name of lower case letters, digits and '_', a letter first"
    raise UsageError(f"the mission gets the folder's name, {rule}; '{name}' is none{hint}")


def _copied(template: Template, directory: Path) -> Iterator[Path]:
    schemas: dict[str, None] = {}
    name = directory.resolve().name
    for source in sorted(template.folder.rglob("*")):
        if not source.is_file() or "__pycache__" in source.parts:
            continue
        target = directory / source.relative_to(template.folder)
        make_folder_of(target)
        content = source.read_bytes()
        target.write_bytes(content if template.is_example else content.replace(PLACEHOLDER.encode(), name.encode()))
        yield target
        if source.suffix == ".json":
            schemas |= dict.fromkeys(_schema_of(content))
    for schema in schemas:
        (directory / schema).write_bytes((PACKAGE / schema).read_bytes())
        yield directory / schema


def _schema_of(content: bytes) -> Iterator[str]:
    """The shipped schema that a file names as its neighbour, which an editor reads without a network."""
    document = json.loads(content)
    schema = document.get("$schema", "") if isinstance(document, dict) else ""
    if re.fullmatch(r"\w+\.schema\.json", schema) and (PACKAGE / schema).is_file():
        yield schema
