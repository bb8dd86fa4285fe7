# SPDX-License-Identifier: Apache-2.0
"""What is between a run and its journal: a hanging disk holds no run up."""

from __future__ import annotations

import math

import pytest

from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError
from rai_missions.event import Event
from rai_missions.journal import buffer
from rai_missions.journal.buffer import BufferedWriter
from tests.rigs.journals import MemoryJournal


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
