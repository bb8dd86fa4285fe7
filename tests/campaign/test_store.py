# SPDX-License-Identifier: Apache-2.0
"""The store of a campaign: what was added is there, once, whatever ended the process that added it."""

from __future__ import annotations

import os
import sqlite3
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from rai_missions.campaign.records import (
    CellRecord,
    LabelRecord,
    PictureRecord,
    QuestionRecord,
    SceneRecord,
)
from rai_missions.campaign.store import ResultStore
from rai_missions.errors import UsageError
from tests.rigs.files import largest_file

CELL = CellRecord("k1", "tractor", "s1", 1, "rules", "none", "written", "answered", option="replan", permitted=1)


@contextmanager
def fresh() -> Iterator[ResultStore]:
    """A store in which there is nothing yet; for examples, which share a test's `tmp_path`."""
    with tempfile.TemporaryDirectory() as folder, ResultStore(Path(folder) / "results.db", writes=True) as store:
        yield store


def test_what_is_added_is_read_back(tmp_path: Path) -> None:
    scene = SceneRecord("s1", "orchard", "branch", 7, "tune", '{"seed": 7}')
    question = QuestionRecord("s1", "none", "What now?", "{}", '["replan"]', '["replan"]')
    label, picture = LabelRecord("s1", "replan", "harmless", "{}"), PictureRecord("s1", "camera", b"\x89PNG")
    with ResultStore(tmp_path / "results.db", writes=True) as store:
        store.add([scene, question, label, picture, CELL])
        store.set_meta({"code": "abc", "models": ["rules"]})
    with ResultStore(tmp_path / "results.db") as store:
        assert list(store.scenes()) == [scene]
        assert list(store.questions()) == [question]
        assert list(store.label_records()) == [label]
        assert store.labels() == {"s1": {"replan": "harmless"}}
        assert store.pictures("s1") == {"camera": b"\x89PNG"} and store.pictures("s2") == {}
        assert list(store.cells()) == [CELL]
        assert store.meta == {"code": "abc", "models": ["rules"]}


def test_a_cell_is_there_once_and_its_last_answer_counts(tmp_path: Path) -> None:
    with ResultStore(tmp_path / "results.db", writes=True) as store:
        store.add([CELL._replace(status="failed", option="", error="429")])
        assert store.done() == set() and store.ends() == {"k1": ("failed", "429")}
        store.add([CELL])
        assert list(store.cells()) == [CELL] and store.done() == {"k1"}


def test_a_transaction_that_fails_leaves_nothing(tmp_path: Path) -> None:
    with ResultStore(tmp_path / "results.db", writes=True) as store:
        with pytest.raises(sqlite3.IntegrityError):
            store.add([CELL, CELL._replace(cell="k2", status="lost")])  # type: ignore[arg-type]
        assert list(store.cells()) == []


def test_one_process_writes_and_others_read(tmp_path: Path) -> None:
    path = tmp_path / "results.db"
    with ResultStore(path, writes=True) as store:
        store.add([CELL])
        with pytest.raises(UsageError, match="is being written by another campaign"):
            ResultStore(path, writes=True)
        with ResultStore(path) as reader:
            assert list(reader.cells()) == [CELL]
        store.add([CELL._replace(cell="k2")])
    with ResultStore(path, writes=True) as store:
        assert len(list(store.cells())) == 2


WRITER = """
import sys
from rai_missions.campaign.records import CellRecord
from rai_missions.campaign.store import ResultStore
with ResultStore(sys.argv[1], writes=True) as store:
    for number in range(10**6):
        store.add([CellRecord(f"k{number:06}", "m", "s", 1, "rules", "none", "written", "answered")])
        print(number, flush=True)
"""


def test_what_was_added_survives_a_kill(tmp_path: Path) -> None:
    path = tmp_path / "results.db"
    for after in (0, 3, 40):
        writer = subprocess.Popen([sys.executable, "-c", WRITER, str(path)], stdout=subprocess.PIPE, text=True)
        assert writer.stdout is not None
        last = -1
        while last < after:
            last = int(writer.stdout.readline())
        writer.kill()
        last = max([last, *map(int, writer.stdout.read().split())])
        writer.wait()
        writer.stdout.close()
        with ResultStore(path, writes=True) as store:  # the lock died with its holder
            keys = [record.cell for record in store.cells()]
        assert keys == [f"k{number:06}" for number in range(len(keys))]
        assert len(keys) > last


@pytest.mark.parametrize(("content", "fault"), [
    (b"no database at all, but long enough to be read as one" * 20, "is no store of a campaign"),
    (None, "no results at"),
])  # fmt: skip
def test_what_is_no_store_is_left_as_it_is(tmp_path: Path, content: bytes | None, fault: str) -> None:
    path = tmp_path / "results.db"
    if content is not None:
        path.write_bytes(content)
        with pytest.raises(UsageError, match=fault):
            ResultStore(path, writes=True)
        assert path.read_bytes() == content
    with pytest.raises(UsageError, match=fault):
        ResultStore(path)


def test_a_full_disk_is_named_and_what_was_stored_before_is_kept(tmp_path: Path) -> None:
    with ResultStore(tmp_path / "a.db", writes=True) as store:
        store.add([CELL])
        connection: sqlite3.Connection = vars(store)["_db"]
        connection.execute("PRAGMA max_page_count=1").fetchall()  # SQLite's own "database or disk is full"
        with pytest.raises(
            UsageError, match=r"results cannot be written at .*a\.db: database or disk is full; what was"
        ):
            store.add([CELL._replace(cell=f"k{at}", raw="x" * 9000) for at in range(2, 99)])
        connection.execute("PRAGMA max_page_count=100000").fetchall()
        store.add([CELL._replace(cell="k2")])
    with ResultStore(tmp_path / "a.db") as store:
        assert [each.cell for each in store.cells()] == ["k1", "k2"]


def test_a_store_that_is_damaged_is_named_whether_it_is_read_or_written(tmp_path: Path) -> None:
    path, cells = tmp_path / "a.db", [CELL._replace(cell=f"k{at:03}", raw="x" * 900) for at in range(99)]
    with ResultStore(path, writes=True) as store:
        store.add(cells)
    content = bytearray(path.read_bytes())
    for page in range(10 * 4096, len(content), 4096):
        content[page : page + 64] = b"\xff" * 64
    path.write_bytes(content)
    fault = r"a\.db is damaged: database disk image is malformed; take a copy from before, or name another file"
    with ResultStore(path, writes=True) as store:
        for use in (lambda: list(store.cells()), store.ends, lambda: store.add(cells)):
            with pytest.raises(UsageError, match=fault):
                use()
        with pytest.raises(sqlite3.IntegrityError):  # a fault of the program stays one
            store.add([CELL._replace(status="unknown")])  # type: ignore[arg-type]


@contextmanager
def read_only(folder: Path) -> Iterator[None]:
    """No file can be made in a folder, also where the tests are run by root."""
    folder.chmod(0o555)
    is_root = os.geteuid() == 0
    if is_root:
        os.seteuid(65534)
    try:
        yield
    finally:
        if is_root:
            os.seteuid(0)
        folder.chmod(0o755)


def test_a_store_is_read_where_no_file_can_be_made_unless_a_part_of_it_is_elsewhere() -> None:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "a.db"
        with ResultStore(path, writes=True) as store:
            store.add([CELL])
        with read_only(path.parent), ResultStore(path) as store:
            assert [each.cell for each in store.cells()] == ["k1"]
        (Path(folder) / "a.db-wal").write_bytes(b"left by a kill")
        with (
            read_only(path.parent),
            pytest.raises(UsageError, match=r"a\.db has a part in a\.db-wal; open it once where files can be written"),
        ):
            ResultStore(path)


@pytest.mark.parametrize("size", [0, 2000, 4096, 8192, 20_000, 33_000, 50_000])
def test_a_disk_that_is_full_is_named_and_what_was_stored_is_read(tmp_path: Path, size: int) -> None:
    with ResultStore(tmp_path / "a.db", writes=True) as store:
        store.add([CELL])
    for left in tmp_path.glob("a.db-*"):
        left.unlink()
    with largest_file(size), ResultStore(tmp_path / "a.db") as store:
        assert [each.cell for each in store.cells()] == ["k1"]
    refused = ""
    with largest_file(size):
        try:
            ResultStore(tmp_path / "new.db", writes=True).close()
        except UsageError as error:
            refused = str(error)
    assert not refused or refused.startswith(f"results cannot be written at {tmp_path / 'new.db'}: "), refused
    with ResultStore(tmp_path / "new.db", writes=True) as store:  # once there is room
        store.add([CELL])


def test_a_database_of_another_program_is_refused(tmp_path: Path) -> None:
    with sqlite3.connect(tmp_path / "other.db") as other:
        other.execute("CREATE TABLE cell (cell)")
    other.close()
    with pytest.raises(UsageError, match="is no store of a campaign; name another file"):
        ResultStore(tmp_path / "other.db", writes=True)


@pytest.mark.drill
def test_a_hundred_thousand_cells_are_written_and_read_fast(tmp_path: Path) -> None:
    cells = [CELL._replace(cell=f"k{at:06}", scene=f"s{at % 500}", raw="x" * 200) for at in range(100_000)]
    began = time.process_time()
    with ResultStore(tmp_path / "results.db", writes=True) as store:
        for at in range(0, len(cells), 1000):
            store.add(cells[at : at + 1000])
        assert sum(1 for _ in store.cells()) == len(store.done()) == 100_000
    assert time.process_time() - began < 5.0
