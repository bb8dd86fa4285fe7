# SPDX-License-Identifier: Apache-2.0
"""What several commands read from what they are given."""

from __future__ import annotations

import sys
from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rai_missions.errors import DefinitionError, Fault, UsageError, irregular
from rai_missions.mission.mission import Mission

if TYPE_CHECKING:
    from rai_missions.journal.reader import Record

__all__ = ("named_in", "steps_of", "warn")


def warn(sentence: str) -> None:
    """Say something on stderr, if there is something to say."""
    if sentence:
        print(sentence, file=sys.stderr)


def named_in(path: str | None, *, python: bool = True) -> dict[str, Callable[..., bool | None]] | None:
    """The public functions of a file, by name.

    Args:
        path: The file, which is executed.
        python: Whether it may be.
    """
    if path is None:
        return None
    if not python:
        raise UsageError(f"--guards {path} is Python, which --no-python refuses; leave one of them out")
    import runpy

    if sort := irregular(path):
        raise UsageError(f"'{path}' is {sort}; name a .py file with guards")
    if not Path(path).is_file():
        raise UsageError(f"there is no file '{path}' with guards")
    try:
        found = runpy.run_path(path)
    except (Exception, SystemExit) as error:  # a file that exits must not look like a run that succeeded
        raise DefinitionError([Fault("", f"{type(error).__name__}: {error}")], path) from error
    own = {name: each for name, each in found.items() if callable(each) and not name.startswith("_")}
    return {name: each for name, each in own.items() if getattr(each, "__module__", None) == "<run_path>"}


def steps_of(journal: str | None, mission: Mission | None = None, *, remedy: str = "") -> tuple[Any, ...]:
    """The steps of a journal, or of the one in a recording.

    Args:
        journal: The file.
        mission: Whose it must be.
        remedy: What to do where its rows are damaged or were altered.

    Raises:
        DefinitionError: The journal is damaged, or is of another mission.
    """
    if journal is None:
        return ()
    from rai_missions.recording import journal_of
    from rai_missions.replay.rebuild import mission_of

    with journal_of(journal) as found, _sound(found.path, remedy) as record:
        warn(found.warning)
        if mission is not None and record.header.mission and mission_of(record) != mission:
            sentence = "this is the journal of another mission, or of another version of it"
            raise DefinitionError(
                [Fault("", f"{sentence}: {mission_of(record).name} {mission_of(record).version}")], journal
            )
        return tuple(record.steps())


def _sound(path: Path, remedy: str) -> Record:
    """A journal whose rows are as they were written."""
    from rai_missions.journal import read

    try:
        return read(path)
    except DefinitionError as error:
        more = [Fault("", remedy)] if remedy else []
        raise DefinitionError([*error.faults, *more], str(path)) from None
