# SPDX-License-Identifier: Apache-2.0
"""A run done again from its journal: the same events, so the same steps, or the first difference by name.

Rule: every step is compared whole; the first difference ends it.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import NamedTuple

from rai_missions.engine.step import Step, step_count
from rai_missions.errors import Fault
from rai_missions.journal import difference, read
from rai_missions.mission.mission import Mission
from rai_missions.replay.rebuild import JournalReplayer, mission_of

__all__ = ("Replay", "replay")


class Replay(NamedTuple):
    """What came of a replay."""

    steps: int
    """How many were done again and were the same, as `step_count` counts them."""
    difference: str = ""
    """The first step that was not, in words; empty if all were."""
    outcome: str | None = None
    why: str = ""
    rows: int = 0
    """The rows of the journal that hold them."""
    outdated: tuple[Fault, ...] = ()
    """What in the profile of the run would be refused at the start of a run today."""

    @property
    def holds(self) -> bool:
        return not self.difference


def replay(
    path: Path | str,
    on_step: Callable[[Step], object] | None = None,
    mission: Mission | None = None,
    progress: Callable[[int, int], None] = lambda done, total: None,
) -> Replay:
    """Do a journal's run again.

    Args:
        path: The journal.
        on_step: Receives each step that was the same.
        mission: The mission, where its journal does not hold it: one with behaviours written in Python.
        progress: Receives how many steps were done again, and how many there are.

    Raises:
        DefinitionError: The journal is damaged or altered; every fault with its row.
        UsageError: There is no such journal.
    """
    with read(path) as record:
        replayer = JournalReplayer(record, mission if mission is not None else mission_of(record))
        chart, count, rows, found = replayer.chart, 0, 0, ""
        last = record.last()
        total = last.step.seq if last is not None else 0
        for row in record.entries():
            got = replayer.again(row)
            if found := difference(row.step, got, without=replayer.reworded):
                break
            count, rows = step_count((got,)), rows + 1
            progress(count, total)
            if on_step is not None:
                on_step(got)
        return Replay(count, found, chart.outcome, chart.why, rows, replayer.outdated)
