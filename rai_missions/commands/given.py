# SPDX-License-Identifier: Apache-2.0
"""What several commands read from what they are given."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.mission import Mission

__all__ = ("named_in", "steps_of")


def named_in(path: str | None) -> dict[str, Callable[..., bool | None]] | None:
    """The public functions of a file, by name."""
    if path is None:
        return None
    import runpy

    if not Path(path).is_file():
        raise UsageError(f"there is no file '{path}' with guards")
    try:
        found = runpy.run_path(path)
    except (Exception, SystemExit) as error:  # a file that exits must not look like a run that succeeded
        raise DefinitionError([Fault("", f"{type(error).__name__}: {error}")], path) from error
    own = {name: each for name, each in found.items() if callable(each) and not name.startswith("_")}
    return {name: each for name, each in own.items() if getattr(each, "__module__", None) == "<run_path>"}


def steps_of(journal: str | None, mission: Mission | None = None) -> tuple[Any, ...]:
    """The steps of a journal.

    Raises:
        DefinitionError: The journal is damaged, or is of another mission.
    """
    if journal is None:
        return ()
    from rai_missions.journal import read
    from rai_missions.rebuild import mission_of

    with read(journal) as record:
        if mission is not None and record.header.mission and mission_of(record) != mission:
            sentence = "this is the journal of another mission, or of another version of it"
            raise DefinitionError(
                [Fault("", f"{sentence}: {mission_of(record).name} {mission_of(record).version}")], journal
            )
        return tuple(record.steps())
