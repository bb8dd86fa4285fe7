# SPDX-License-Identifier: Apache-2.0
"""A play as a journal, which states in row 0, under its hash, that it was played.

Rule: what is read of it elsewhere is a run like any other, and no one takes it for evidence.
"""

from __future__ import annotations

import secrets
from pathlib import Path
from typing import Any

from rai_missions.engine.step import Step
from rai_missions.errors import UsageError, make_folder_of
from rai_missions.event import Tick
from rai_missions.journal import Header, Journal, make_way, writing_at
from rai_missions.journal.sqlite import log_of
from rai_missions.mission.files import journal_text
from rai_missions.replay.play.play import Play

__all__ = ("save",)


def save(play: Play, path: Path, *, replaces: bool = False) -> Path | None:
    """Write the present path of a play down.

    Args:
        play: What was played.
        path: The new journal.
        replaces: A journal that is there is one of this play, and is replaced; else it is moved aside.

    Returns:
        Where the journal that had this name is now; None where there was none, or it was replaced.

    Raises:
        UsageError: Nothing was played yet, or the file cannot be written.
        DefinitionError: A file of that name is no journal.
    """
    if not play.path:
        raise UsageError("nothing has been played yet; there is nothing to save")
    mission = play.mission
    with writing_at(path):
        make_folder_of(path)
    part = path.with_name(f".{path.name}.{secrets.token_hex(4)}.part")
    try:
        with Journal.create(part, Header(journal_text(mission), versions=mission.packages(), played=True)) as journal:
            _write(play, journal)
        aside = None if replaces else make_way(path)
        with writing_at(path):
            part.replace(path)
    finally:
        for left in (part, log_of(part)):
            left.unlink(missing_ok=True)
    return aside


def _write(play: Play, journal: Journal) -> None:
    carried: dict[str, tuple[str, Any, float]] = {}
    for click in play.path:
        for step, since, is_quiet in click.done:
            if is_quiet:
                carried |= _written(step)
                continue
            journal.write(step, since=since, quiet=tuple(carried.values()))
            carried.clear()
    if carried or play.path[-1].done[-1].is_quiet:
        chart = play.chart.branch()
        since = chart.at
        journal.write(chart.send(Tick(since)), since=since, quiet=tuple(carried.values()))


def _written(step: Step) -> dict[str, tuple[str, Any, float]]:
    return {key: (key, value, step.stamp_of(key)) for key, value in step.writes}
