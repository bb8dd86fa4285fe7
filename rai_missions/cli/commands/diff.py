# SPDX-License-Identifier: Apache-2.0
"""`rai-missions diff textconv`: what changed between two missions, in files or in a git repository."""

from __future__ import annotations

import argparse
import sys
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING

from rai_missions.cli.arguments import warn
from rai_missions.errors import MissionError, UsageError, irregular
from rai_missions.mission.files import load
from rai_missions.mission.mission import Mission

if TYPE_CHECKING:
    from visualize import Difference

__all__ = ("diff", "textconv")


def diff(given: argparse.Namespace) -> int:
    """Say and write what changed between two missions."""
    from visualize import difference, draw_difference
    from visualize.mermaid import oversize

    with _old(given) as old:
        found = difference(old, load(given.old if given.git else given.new, python=not given.no_python))
    for line in found.lines():
        print(line)
    for output in given.output:
        warn(oversize(draw_difference(found, output)))
        print(f"written: {output}")
    return _status(found, given.fail_on)


@contextmanager
def _old(given: argparse.Namespace) -> Iterator[Mission]:
    """The mission as it was: in a file, or in a file of another revision."""
    if given.git is None:
        if given.new is None:
            raise UsageError("give two missions, OLD and NEW, or one and where it was: diff --git REV MISSION")
        yield load(given.old, python=not given.no_python)
        return
    if given.new is not None:
        raise UsageError("--git compares one mission with itself at a revision: diff --git REV MISSION")
    from rai_missions.cli.git import at_revision

    with at_revision(given.git, Path(given.old), python=given.python and not given.no_python) as file:
        yield load(file)


def _status(found: Difference, fail_on: str) -> int:
    fatal = {"safety": found.safety, "any": found.changes, "none": ()}[fail_on]
    return 1 if fatal else 0


def textconv(given: argparse.Namespace) -> int:
    """Print a mission as text that `git diff` can show; what is no mission is printed as it is."""
    from rai_missions.mission.include import read_mission
    from visualize.outline import outline

    try:
        text = outline(read_mission(Path(given.file)))
    except MissionError:
        if irregular(given.file):
            raise
        text = Path(given.file).read_text(encoding="utf-8", errors="replace")
    sys.stdout.write(text)
    return 0
