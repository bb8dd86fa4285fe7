# SPDX-License-Identifier: Apache-2.0
"""What a journal's reader gives and refuses: bytes that it lacks, a closed file, words that look like a picture."""

from __future__ import annotations

from pathlib import Path

import pytest

from rai_missions.engine.step import StartGoal, Step
from rai_missions.errors import DefinitionError, MissionError, UsageError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, StepRow, read, verify
from rai_missions.journal.in_flight import InFlight


def written(path: Path, *steps: Step) -> Path:
    with Journal.create(path, Header('{"format": 1}')) as journal:
        for step in steps:
            journal.write(step, since=0.0)
    return path


def test_bytes_that_were_never_kept_are_refused_as_such(tmp_path: Path) -> None:
    path, digest = written(tmp_path / "run.journal"), "0" * 64
    with read(path) as record, pytest.raises(UsageError, match=f"holds no bytes with the hash '{digest}'"):
        record.blob(digest)


def test_a_record_that_was_closed_gives_nothing_more(tmp_path: Path) -> None:
    record = read(written(tmp_path / "run.journal", Step(1, 0.0, Event("go"))))
    assert record.last() is not None
    record.close()
    with pytest.raises(MissionError):
        record.last()


def test_an_event_that_holds_a_hash_shows_no_picture(tmp_path: Path) -> None:
    """Its words are those by which a picture is written; only what has all of them is one that was kept."""
    data = {"sha256": "0" * 64, "encoding": "png", "width": 1, "height": 1}
    assert verify(written(tmp_path / "run.journal", Step(1, 0.0, Event("go", 0.0, data)))) == ()


def test_what_a_server_had_accepted_before_a_migration_is_accepted_after_it() -> None:
    migrated = Event("migrate", 3.0, {"accepted": [4]}, "command")
    goals = tuple(StartGoal(number, "moving", "move", {}) for number in (4, 5))
    under = InFlight()
    under.follow(StepRow(1, Step(1, 3.0, migrated, effects=goals), 0.0))
    assert under.accepted == {4}


def test_a_file_that_is_no_database_next_to_a_log_is_no_journal(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    path.write_bytes(b"no database" * 100)
    path.with_name("run.journal-wal").write_bytes(b"no log" * 100)
    with pytest.raises(DefinitionError, match="no journal"):
        read(path)


@pytest.mark.parametrize("length", [251, 252, 255])
def test_a_name_that_has_no_room_for_that_of_its_log_is_reported_in_a_sentence(tmp_path: Path, length: int) -> None:
    with pytest.raises(UsageError, match=r"a journal cannot be written at .*; name another file"):
        Journal.create(tmp_path / ("n" * length), Header("{}"))
    assert list(tmp_path.iterdir()) == []
