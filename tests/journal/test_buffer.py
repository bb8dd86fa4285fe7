# SPDX-License-Identifier: Apache-2.0
"""What is between a run and its journal: no run is held up by a disk, no confirmation travels for long."""

from __future__ import annotations

import math
from contextlib import closing
from pathlib import Path

import pytest

from rai_missions.engine.step import StartGoal, Step
from rai_missions.errors import ConnectorError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, buffer
from rai_missions.journal.buffer import BufferedWriter
from rai_missions.journal.rows import Confirmation, StepRow
from rai_missions.journal.sqlite import LONGEST_BYTES
from rai_missions.journal.verify import verify
from tests.rigs.journals import MemoryJournal, rows_of


def test_closing_does_not_wait_for_a_disk_that_hangs(monkeypatch: pytest.MonkeyPatch) -> None:
    journal = MemoryJournal(hangs_at="go")
    writer = BufferedWriter(journal)
    monkeypatch.setattr(buffer, "LONGEST_S", 0.0)
    with pytest.raises(ConnectorError, match="has not answered"):
        writer.write(Step(1, 0.0, Event("go")), since=0.0)
    monkeypatch.setattr(buffer, "LONGEST_S", math.inf)  # no thread can be waited for so long
    writer.close()
    assert journal.steps == []
    journal.answers.set()


def performed(seq: int) -> Step:
    """A step that starts an action, which may not be done twice."""
    return Step(seq, float(seq), Event("go", float(seq)), effects=(StartGoal(seq, "moving", "move", {}),))


def test_a_confirmation_is_written_with_the_row_of_the_event_that_waits(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    with Journal.create(path, Header("{}")) as journal, closing(BufferedWriter(journal)) as writer:
        writer.write(performed(1), since=0.0)
        writer.confirm(performed(1), may_wait=True)
        assert rows_of(path) == [StepRow(1, performed(1), 0.0)]
        writer.write(performed(2), since=1.0)
        first = [StepRow(1, performed(1), 0.0), Confirmation(2, 1, "performed"), StepRow(3, performed(2), 1.0)]
        assert rows_of(path) == first
        writer.confirm(performed(2), may_wait=False)
        assert rows_of(path) == [*first, Confirmation(4, 2, "performed")]


def test_a_confirmation_travels_for_one_event_and_no_longer(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    with Journal.create(path, Header("{}")) as journal, closing(BufferedWriter(journal)) as writer:
        writer.write(performed(1), since=0.0)
        writer.confirm(performed(1), may_wait=True)
        quiet = Step(2, 2.0, Event("battery", 2.0, {"value": 0.5}, "write"))
        writer.confirm(quiet, may_wait=True)
        assert rows_of(path) == [StepRow(1, performed(1), 0.0), Confirmation(2, 1, "performed")]


def test_a_row_that_cannot_be_written_leaves_what_was_performed_confirmed(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    with Journal.create(path, Header("{}")) as journal, closing(BufferedWriter(journal)) as writer:
        writer.write(performed(1), since=0.0)
        writer.confirm(performed(1), may_wait=True)
        with pytest.raises(ConnectorError, match="rows 2 to 3 are lost"):
            writer.write(performed(2)._replace(why="x" * LONGEST_BYTES), since=1.0)
    assert rows_of(path) == [StepRow(1, performed(1), 0.0), Confirmation(2, 1, "performed")]
    assert verify(path) == ()
