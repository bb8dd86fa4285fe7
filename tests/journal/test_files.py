# SPDX-License-Identifier: Apache-2.0
"""A journal as a file: written, read, altered, cut, refused."""

from __future__ import annotations

import shutil
import sqlite3
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.engine.decision import Evidence, Question
from rai_missions.engine.step import Ask, Step
from rai_missions.errors import ConnectorError, DefinitionError, MissionError, UsageError
from rai_missions.event import Event
from rai_missions.image import Image
from rai_missions.journal import Confirmation, Header, Journal, Note, Record, StepRow, make_way, read, verify
from rai_missions.journal.rows import GENESIS, Blob, Raw, chained
from rai_missions.journal.sqlite import LONGEST_BYTES
from tests.rigs.journals import anomalies, blackboard_writes, listing, raw_rows_of, shown, steps

HEADER = Header('{"format": 1}', profile="{}", arguments={"alleys": 6}, run="r1")


@pytest.fixture
def path(tmp_path: Path) -> Path:
    """A closed journal: row 0, five steps, a confirmation, a note."""
    path = tmp_path / "run.journal"
    with Journal.create(path, HEADER) as journal:
        for step in anomalies(5):
            journal.write(step, since=step.at - 0.5)
        journal.confirm(3, "succeeded")
        journal.note("resumed", {"after": "a crash"})
    return path


def alter(path: Path, *statements: str) -> None:
    database = sqlite3.connect(path)
    with database:
        for statement in statements:
            database.execute(statement)
    database.close()


@settings(max_examples=settings.default.max_examples * 2 // 5)  # each draws steps of everything that there is
@given(st.lists(st.tuples(steps, blackboard_writes), max_size=4))
def test_a_run_that_was_written_is_the_run_that_is_read(
    tmp_path_factory: pytest.TempPathFactory, run: list[tuple[Step, Any]]
) -> None:
    path = tmp_path_factory.mktemp("run") / "journal"
    with Journal.create(path, HEADER) as journal:
        for step, quiet in run:
            journal.write(step, since=1.25, quiet=quiet)
    with read(path) as record:
        assert list(record.steps()) == [step for step, _ in run]
        assert [row.before for row in record.entries()] == [tuple(quiet) for _, quiet in run]


@settings(max_examples=settings.default.max_examples * 2 // 5)
@given(st.lists(st.tuples(steps, st.lists(st.integers(0, 9), max_size=3)), max_size=4))
def test_confirmations_written_with_a_step_are_the_rows_of_those_written_before_it(
    tmp_path_factory: pytest.TempPathFactory, run: list[tuple[Step, list[int]]]
) -> None:
    folder, seen = tmp_path_factory.mktemp("run"), list[tuple[tuple[Raw, ...], tuple[Blob, ...]]]()
    header = HEADER._replace(started="2026-01-01T00:00:00.000+00:00")
    with (
        Journal.create(folder / "j", header, witness=lambda *rows: seen.append(rows)) as journal,
        Journal.create(folder / "twin", header) as twin,
    ):
        for step, performed in run:
            journal.write(step, since=1.25, performed=performed)
            for number in performed:
                twin.confirm(number, "performed")
            twin.write(step, since=1.25)
    assert raw_rows_of(folder / "j") == raw_rows_of(folder / "twin") == [raw for raws, _ in seen for raw in raws]
    with read(folder / "j") as record:
        assert {blob[0] for blob in record.pictures()} == {blob[0] for _, blobs in seen for blob in blobs}
    assert all(raws[-1][1] == "step" for raws, blobs in seen if blobs)
    assert len(seen) == 1 + len(run), "rows that are written at once are handed over at once"


def test_every_row_is_read_in_its_order(path: Path) -> None:
    with read(path) as record:
        rows = list(record.rows())
        assert rows[0] == StepRow(1, anomalies(1)[0], 0.0)
        assert rows[-2:] == [Confirmation(6, 3, "succeeded"), Note(7, "resumed", {"after": "a crash"})]
        assert (record.confirmations(), record.notes()) == ({3: "succeeded"}, (rows[-1],))
        assert record.last() == rows[4]
    assert verify(path) == ()


def test_row_0_reports_what_is_needed_to_run_it_again(path: Path) -> None:
    with read(path) as record:
        header = record.header
    assert (header.mission, header.profile, header.arguments, header.run) == (
        '{"format": 1}',
        "{}",
        {"alleys": 6},
        "r1",
    )
    assert {"python", "format"} <= set(header.versions)
    assert header.started.endswith("+00:00")


def test_a_journal_is_continued_with(path: Path) -> None:
    with Journal.open(path) as journal:
        assert journal.write(anomalies(6)[5], since=2.5) == 8
    assert verify(path) == ()


def test_reading_changes_nothing(path: Path) -> None:
    before = listing(path.parent)
    with read(path) as record:
        list(record.rows())
    verify(path)
    assert listing(path.parent) == before


def test_a_journal_is_read_while_it_is_written(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with Journal.create(path, HEADER) as journal:
        for count, step in enumerate(anomalies(40), 1):
            journal.write(step, since=0.0)
            before = listing(tmp_path)
            with read(path) as record:
                assert len(list(record.steps())) == count
            assert listing(tmp_path) == before
    assert verify(path) == ()


def test_a_journal_is_written_by_one_alone(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with Journal.create(path, HEADER):
        with pytest.raises(UsageError, match="is being written by this process already; close that journal first"):
            Journal.open(path)
        with pytest.raises(UsageError, match="is there already, and a journal is never overwritten"):
            Journal.create(path, HEADER)
    Journal.open(path).close()


def test_a_closed_journal_takes_no_row(path: Path) -> None:
    journal = Journal.open(path)
    journal.close()
    journal.close()
    with pytest.raises(UsageError, match="is closed; open it again to write"):
        journal.note("late")


@pytest.mark.parametrize("where", ["", "file/run.journal"])
def test_a_journal_that_cannot_be_written_reports_where(tmp_path: Path, where: str) -> None:
    (tmp_path / "file").touch()
    with pytest.raises(UsageError, match=r"a journal cannot be written at .*; name another file"):
        Journal.create(tmp_path / where, HEADER)
    assert sorted(item.name for item in tmp_path.iterdir()) == ["file"]


def test_what_is_no_journal_is_left_and_another_name_is_asked_for(tmp_path: Path) -> None:
    path = tmp_path / "notes.txt"
    path.write_text("my notes")
    with pytest.raises(
        DefinitionError, match="this file is left as it is, and no journal is written in its place; name"
    ):
        make_way(path)
    assert path.read_text() == "my notes"


def test_a_row_that_was_not_written_leaves_the_chain_whole(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with Journal.create(path, HEADER) as journal:
        journal._database.execute(
            f"PRAGMA max_page_count={journal._database.execute('PRAGMA page_count').fetchone()[0]}"
        )
        with pytest.raises(ConnectorError, match=r"j cannot be written: database or disk is full; row 1 is lost"):
            journal.note("x" * 100_000)
        assert journal.note("short") == 1
    assert verify(path) == ()


def test_a_step_that_was_not_written_takes_its_confirmations_with_it(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with Journal.create(path, HEADER) as journal:
        with pytest.raises(ConnectorError, match="too big; rows 1 to 3 are lost"):
            journal.write(anomalies(1)[0]._replace(why="x" * LONGEST_BYTES), since=0.0, performed=(4, 5))
        assert journal.confirm(4, "performed") == 1
    assert verify(path) == ()


def test_a_row_that_no_one_could_read_is_not_written(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with Journal.create(path, HEADER) as journal:
        with pytest.raises(ConnectorError, match="too big; row 1 is lost"):
            journal.note("x" * LONGEST_BYTES)
        assert journal.note("short") == 1
    assert verify(path) == ()


def test_what_cannot_be_written_leaves_the_chain_whole(tmp_path: Path) -> None:
    path = tmp_path / "j"
    with Journal.create(path, HEADER) as journal:
        with pytest.raises(UsageError, match="NaN"):
            journal.note("measured", float("nan"))
        with pytest.raises(UsageError, match="plain data"):
            journal.write(anomalies(1)[0], since=float("nan"))
        assert journal.note("fine") == 1
    assert verify(path) == ()


def test_the_pictures_of_a_question_are_kept_once(tmp_path: Path) -> None:
    path = tmp_path / "j"
    image = Image("camera@1", 2, 2, "rgb8", lambda: bytes(range(12)))
    question = Question(1, "assessing", "agent", "What now?", (), (Evidence("camera", image, 0.1, True),))
    with Journal.create(path, HEADER) as journal:
        for seq in (1, 2):
            journal.write(Step(seq, 0.0, Event("anomaly", 0.0, {"seen": image}), effects=(Ask(question),)), since=0.0)
    with read(path) as record:
        first = next(record.steps())
        assert first.question is not None
        assert first.question.evidence[0].value.data == bytes(range(12))
        assert list(record.blobs()) == [image.digest]
        with pytest.raises(UsageError, match=r"keeps pictures that a question showed, and not 'camera@1'"):
            _ = first.event.data["seen"].data


def test_a_picture_that_cannot_be_made_does_not_keep_the_step_from_being_written(tmp_path: Path) -> None:
    def broken() -> bytes:
        raise ConnectorError("no camera")

    question = Question(1, "a", "agent", "?", (), (Evidence("camera", Image("c", 1, 1, "rgb8", broken), 0.1, True),))
    with Journal.create(tmp_path / "j", HEADER) as journal:
        journal.write(Step(1, 0.0, Event("x"), effects=(Ask(question),)), since=0.0)
    assert verify(tmp_path / "j") == ()


ALTERED = {
    "a changed row": (
        "UPDATE rows SET content = replace(content, '\"n\":3', '\"n\":4') WHERE number = 3",
        "row 3: its hash '.{12}…' is not that of its content and the row before; the journal was altered after the run",
    ),
    "a missing row": ("DELETE FROM rows WHERE number = 3", "row 3: missing: row 4 comes next; rows were taken out"),
    "no row 0": ("DELETE FROM rows WHERE number = 0", "row 0: missing: row 1 comes next"),
    "no row": ("DELETE FROM rows", "row 0: missing: the journal is empty"),
    "a changed kind": ("UPDATE rows SET kind = 'note' WHERE number = 2", "row 2: its hash"),
    "a changed hash": ("UPDATE rows SET hash = 'x' WHERE number = 2", "row 2: its hash 'x…' is not"),
    "rows exchanged": (
        "UPDATE rows SET content = (SELECT content FROM rows WHERE number = 4) WHERE number = 3",
        "row 3: its hash",
    ),
    "no text": ("UPDATE rows SET content = x'00ff' WHERE number = 2", "row 2: its parts are not text"),
    "a view": ("CREATE VIEW trap AS SELECT 1", "/: its tables are not those of a journal: blobs, rows, view trap"),
    "a negative row": ("INSERT INTO rows VALUES (-1, 'note', '{}', '')", "row 0: missing: row -1 comes next"),
}


OTHERS = {
    "a later format": ("PRAGMA user_version = 2", "/: a journal of format 2; this program reads format 1"),
    "another file": ("PRAGMA application_id = 7", "/: a SQLite file, but no journal"),
}


@pytest.mark.parametrize("name", OTHERS)
def test_what_is_no_journal_of_this_format_is_not_verified(path: Path, name: str) -> None:
    statement, reported = OTHERS[name]
    alter(path, statement)
    for look in (read, verify):
        with pytest.raises(DefinitionError, match=reported):
            look(path)


@pytest.mark.parametrize("name", ALTERED)
def test_a_journal_that_was_altered_is_refused_with_its_row(path: Path, name: str) -> None:
    statement, reported = ALTERED[name]
    alter(path, statement)
    with pytest.raises(DefinitionError, match=reported):
        read(path)
    assert verify(path)


def test_a_row_that_was_altered_with_its_hash_breaks_the_row_after(path: Path) -> None:
    database = sqlite3.connect(path)
    (before,) = database.execute("SELECT hash FROM rows WHERE number = 2").fetchone()
    content = '{"text":"all is well"}'
    with database:
        database.execute(
            "UPDATE rows SET kind = 'note', content = ?, hash = ? WHERE number = 3",
            (content, chained(before, 3, "note", content)),
        )
    database.close()
    assert [fault.place for fault in verify(path)] == ["row 4"]


def test_a_picture_that_was_altered_is_reported(tmp_path: Path) -> None:
    path = tmp_path / "j"
    image = Image("camera@1", 1, 1, "png", lambda: b"a person")
    with Journal.create(path, HEADER) as journal:
        journal.write(shown(1, image), since=0.0)
    digest = image.digest
    alter(path, "UPDATE blobs SET bytes = CAST('nobody' AS BLOB)")
    reported = f"picture {digest[:12]}…: its bytes do not have the hash under which they are kept"
    assert [str(fault).startswith(reported) for fault in verify(path)] == [True]
    with read(path) as record, pytest.raises(DefinitionError, match="its bytes do not have the hash"):
        record.blob(digest)


def test_a_journal_that_cannot_be_begun_leaves_no_file(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="NaN"):
        Journal.create(tmp_path / "j", HEADER._replace(arguments={"speed": float("nan")}))
    assert list(tmp_path.iterdir()) == []


def test_every_fault_is_reported_at_once(path: Path) -> None:
    alter(path, "UPDATE rows SET kind = 'note' WHERE number IN (2, 4)")
    assert [fault.place for fault in verify(path)][:2] == ["row 2", "row 4"]


def forge(path: Path, number: int, kind: str, content: str) -> None:
    """Alters a row and mends the chain after it, as someone who knows how would."""
    database = sqlite3.connect(path)
    with database:
        database.execute("INSERT OR REPLACE INTO rows VALUES (?, ?, ?, '')", (number, kind, content))
        before = GENESIS
        for row, what, text in database.execute("SELECT number, kind, content FROM rows ORDER BY number").fetchall():
            before = chained(before, row, what, text)
            database.execute("UPDATE rows SET hash = ? WHERE number = ?", (before, row))
    database.close()


@pytest.mark.parametrize(
    ("kind", "content", "message"),
    [
        ("step", "{", "no step can be read here: Expecting property name"),
        ("step", "[" * 100_000, "no step can be read here: it is nested too deeply"),
        ("step", "{}", "no step can be read here: 'step' is missing"),
        ("step", '{"since": 1, "step": {"seq": NaN}}', "NaN is no JSON"),
        ("step", '{"since": 1, "step": {"seq": 1}}', "missing"),
        ("fly", "{}", "a row is one of step, confirmation, note, not 'fly'"),
    ],
)
def test_a_row_that_is_none_is_reported_though_its_chain_holds(
    path: Path, kind: str, content: str, message: str
) -> None:
    forge(path, 2, kind, content)
    with read(path) as record, pytest.raises(DefinitionError, match="row 2: ") as refused:
        list(record.rows())
    assert message in str(refused.value)
    assert verify(path)[0].place == "row 2"


def test_a_step_out_of_order_is_reported_though_its_chain_holds(path: Path) -> None:
    forge(path, 3, "step", '{"since": 0, "step": {"seq": 2, "at": 1, "event": {"name": "again"}}}')
    assert [str(fault) for fault in verify(path)] == ["row 3: step 2 comes after step 2; the numbers of steps grow"]


def test_the_seal_reports_a_forged_journal_from_the_true_one(path: Path) -> None:
    seal = Record(path).seal
    forge(path, 7, "note", '{"text": "all went well"}')
    assert verify(path) == ()
    assert Record(path).seal != seal


@given(cut=st.integers(0, 20_000), garbage=st.binary(max_size=64), at=st.integers(0, 20_000))
def test_a_damaged_journal_is_a_fault_and_never_a_traceback(
    tmp_path_factory: pytest.TempPathFactory, cut: int, garbage: bytes, at: int
) -> None:
    path = tmp_path_factory.mktemp("damaged") / "j"
    with Journal.create(path, HEADER) as journal:
        for step in anomalies(40):
            journal.write(step, since=0.0)
    data = bytearray(path.read_bytes())
    data[at : at + len(garbage)] = garbage
    path.write_bytes(data[:cut])
    try:
        with read(path) as record:
            list(record.rows())
        verify(path)
    except MissionError:
        pass
    shutil.rmtree(path.parent)


@pytest.mark.parametrize("content", [b"", b"SQLite format 3\0", b'{"format": 1}', b"\0" * 5000])
def test_a_file_that_is_no_journal_is_refused(tmp_path: Path, content: bytes) -> None:
    (tmp_path / "j").write_bytes(content)
    with pytest.raises(DefinitionError, match="no journal"):
        read(tmp_path / "j")
    with pytest.raises((DefinitionError, UsageError)):
        Journal.open(tmp_path / "j")
    assert listing(tmp_path)["j"][0] == content


def test_a_path_without_a_file_is_refused(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="there is no such file"):
        read(tmp_path / "none")
    with pytest.raises(UsageError, match="that is a folder"):
        read(tmp_path)


def test_a_file_that_was_emptied_next_to_its_log_is_damaged(path: Path, tmp_path: Path) -> None:
    with Journal.open(path) as journal:
        journal.note("in the log")
        for suffix in ("", "-wal"):
            shutil.copyfile(f"{path}{suffix}", f"{tmp_path / 'left'}{suffix}")
    (tmp_path / "left").write_bytes(b"")
    log = (tmp_path / "left-wal").read_bytes()
    with pytest.raises(DefinitionError, match="the journal is damaged"):
        Journal.open(tmp_path / "left")
    assert (tmp_path / "left-wal").read_bytes() == log


def test_a_journal_that_has_become_large_is_mentioned_once_at_each_tenfold(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, caplog: pytest.LogCaptureFixture
) -> None:
    monkeypatch.setattr("rai_missions.journal.writer.FIRST_MARK", 1_000_000)
    path, text = tmp_path / "j", "x" * 10_000

    def mentioned(notes: int) -> int:
        caplog.clear()
        for _ in range(notes):
            journal.note(text)
        assert all(str(path) in record.getMessage() for record in caplog.records)
        return len(caplog.records)

    with Journal.create(path, HEADER) as journal:
        assert [mentioned(count) for count in (99, 701, 100)] == [0, 1, 0]
    with Journal.open(path) as journal:
        assert [mentioned(count) for count in (100, 1_000)] == [0, 1]
        assert f"{path} has 1" in caplog.text and " MB; it grows as long as the run lasts" in caplog.text
        path.unlink()
        assert mentioned(200) == 0
