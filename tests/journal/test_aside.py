# SPDX-License-Identifier: Apache-2.0
"""A journal that another run's journal takes the name of: nothing of it is lost, and no one who writes is disturbed."""

from __future__ import annotations

import shutil
import sqlite3
from contextlib import closing
from pathlib import Path

import pytest

from rai_missions.cli.main import main
from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.event import Event
from rai_missions.journal import Header, Journal, make_way, read, set_aside


def killed(path: Path, rows: int) -> Path:
    """A journal as it is left by a process that was killed: its rows are in the log next to it."""
    with Journal.create(path.with_name("living"), Header("{}")) as journal:
        for seq in range(1, rows + 1):
            journal.write(Step(seq, float(seq), Event("anomaly", float(seq))), since=0.0)
        for suffix in ("", "-wal"):
            shutil.copyfile(f"{journal.path}{suffix}", f"{path}{suffix}")
    journal.path.unlink()
    return path


def test_a_folder_that_cannot_be_made_is_refused_with_the_remedy(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    (tmp_path / "file").write_text("kept")
    mission, path = tmp_path / "mission.json", tmp_path / "file/runs/run.journal"
    mission.write_text('{"name": "brief", "initial": "over", "states": {"over": {"final": "aborted"}}}')
    assert main(["run", str(mission), "--journal", str(path)]) == 2
    assert capsys.readouterr().err == (
        f"rai-missions run: a journal cannot be written at {path}: Not a directory; name another file\n"
    )
    assert (tmp_path / "file").read_text() == "kept"


def test_a_killed_run_keeps_its_rows_when_its_journal_is_moved_aside(tmp_path: Path) -> None:
    path = killed(tmp_path / "run.journal", 7)
    set_aside(path, tmp_path / "run.1.journal")
    Journal.create(path, Header("{}")).close()
    with read(tmp_path / "run.1.journal") as record:
        assert len(list(record.steps())) == 7
    assert sorted(each.name for each in tmp_path.iterdir()) == ["run.1.journal", "run.journal"]


def test_a_new_run_takes_no_row_of_a_killed_one_of_the_same_name(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    path, mission = killed(tmp_path / "run.journal", 7), tmp_path / "mission.json"
    mission.write_text('{"name": "brief", "initial": "over", "states": {"over": {"final": "aborted"}}}')
    assert main(["run", str(mission), "--journal", str(path)]) == 1
    with read(tmp_path / "run.1.journal") as old, read(path) as new:
        assert (len(list(old.steps())), len(list(new.steps()))) == (7, 1)


def test_a_journal_that_is_moved_aside_takes_no_row_of_one_that_was_deleted(tmp_path: Path) -> None:
    """Its log was left behind."""
    path = tmp_path / "run.journal"
    Journal.create(path, Header("{}")).close()
    killed(tmp_path / "run.1.journal", 7).unlink()
    moved = make_way(path)
    assert moved == tmp_path / "run.2.journal"
    with read(moved) as record:
        assert not list(record.steps())


def test_a_journal_that_is_being_written_is_not_moved(tmp_path: Path) -> None:
    path = tmp_path / "run.journal"
    with Journal.create(path, Header("{}")) as journal:
        with pytest.raises(UsageError, match="is being written by this process already"):
            set_aside(path, tmp_path / "run.1.journal")
        journal.note("still here")
    with read(path) as record:
        assert [note.text for note in record.notes()] == ["still here"]


def empty(path: Path) -> None:
    path.touch()


def only_marked(path: Path) -> None:
    """What is left where the log was not written yet."""
    database = sqlite3.connect(path)
    database.execute("PRAGMA journal_mode=WAL").fetchall()
    database.close()


def without_rows(path: Path) -> None:
    with Journal.create(path, Header("{}")):
        pass
    database = sqlite3.connect(path)
    with database:
        database.execute("DELETE FROM rows")
    database.close()


@pytest.mark.parametrize("begin", [empty, only_marked, without_rows])
def test_a_process_that_died_making_its_journal_is_in_no_later_one_s_way(tmp_path: Path, begin: object) -> None:
    path = tmp_path / "run.journal"
    assert callable(begin)
    begin(path)
    with pytest.raises(DefinitionError, match=r"(its process died|a process that died) making it"):
        read(path)
    set_aside(path, tmp_path / "run.1.journal")
    Journal.create(path, Header("{}")).close()
    read(path).close()


@pytest.mark.parametrize("content", ["a text", "CREATE TABLE mine (a)"])
def test_what_is_no_journal_is_not_moved(tmp_path: Path, content: str) -> None:
    path = tmp_path / "run.journal"
    if content.startswith("CREATE"):
        with closing(sqlite3.connect(path)) as database:
            database.execute(content)
    else:
        path.write_text(content)
    with pytest.raises(DefinitionError, match="no journal"):
        set_aside(path, tmp_path / "run.1.journal")
    assert [each.name for each in tmp_path.iterdir()] == ["run.journal"]
