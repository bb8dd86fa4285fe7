# SPDX-License-Identifier: Apache-2.0
"""A journal is a SQLite file, and SQLite reads files that are programs or endless: such a file is refused, and soon."""

from __future__ import annotations

import hashlib
import shutil
import sqlite3
import struct
from collections.abc import Callable
from contextlib import closing
from pathlib import Path

import pytest

from rai_missions.cli.main import main
from rai_missions.errors import DefinitionError
from rai_missions.journal import Journal, Record, read, verify
from rai_missions.journal.rows import GENESIS
from tests.fuzz.seeds import written_run

ROWS = "CREATE TABLE rows (number INTEGER PRIMARY KEY, kind TEXT NOT NULL, content TEXT NOT NULL, hash TEXT NOT NULL)"
ENDLESS = "WITH RECURSIVE c(x) AS (SELECT 1 UNION ALL SELECT x + 1 FROM c)"
HOSTILE: dict[str, tuple[str, ...]] = {
    "a trigger called like a table": (
        "CREATE TRIGGER rows AFTER INSERT ON blobs BEGIN DELETE FROM rows; END",
        # SQLite does not care in which order they are, and who keeps one of a name would keep the table
        "UPDATE sqlite_schema SET rowid = 50 WHERE type = 'table' AND name = 'rows'",
    ),
    "a trigger on what a run writes": ("CREATE TRIGGER t AFTER INSERT ON rows BEGIN DELETE FROM rows; END",),
    "an endless view": ("DROP TABLE rows", f"CREATE VIEW rows AS {ENDLESS} SELECT x number, '' kind FROM c"),
    "a view in the table's words": ("UPDATE sqlite_schema SET type = 'view' WHERE name = 'rows'",),
    "generated columns": ("DROP TABLE rows", ROWS.replace("hash TEXT NOT NULL", "hash TEXT AS (hex(zeroblob(1e9)))")),
    "a check that works": ("DROP TABLE rows", ROWS.replace("kind TEXT", "kind TEXT CHECK (length(hex(kind)) > 0)")),
    "an index on what is worked out": ("CREATE INDEX i ON rows (hex(content))",),
    "an index without words": (
        "CREATE INDEX i ON rows (content)",
        "UPDATE sqlite_schema SET sql = NULL WHERE name = 'i'",
    ),
    "a table of its own": ("CREATE TABLE more (x)",),
    "a virtual table": ("CREATE VIRTUAL TABLE v USING fts4(x)",),
    "statistics": ("ANALYZE",),
    "another program's file": ("PRAGMA application_id = 252006675",),
    "no program's file": ("PRAGMA application_id = 0",),
    "words that are no SQL": ("UPDATE sqlite_schema SET sql = 'CREATE TABLE rows (' WHERE name = 'rows'",),
}  # fmt: skip


@pytest.fixture
def good(tmp_path: Path) -> Path:
    return written_run(tmp_path)


def altered(good: Path, *statements: str) -> Path:
    file = good.with_name("hostile.journal")
    shutil.copy(good, file)
    with closing(sqlite3.connect(file, isolation_level=None)) as database:
        database.execute("PRAGMA journal_mode = DELETE").fetchall()
        database.execute("PRAGMA writable_schema = ON")
        for statement in statements:
            database.execute(statement)
    return file


@pytest.mark.parametrize("statements", HOSTILE.values(), ids=HOSTILE)
def test_a_file_that_declares_anything_but_a_journal_is_neither_read_nor_written(
    good: Path, statements: tuple[str, ...]
) -> None:
    file = altered(good, *statements)
    before = file.read_bytes()
    with pytest.raises(DefinitionError):
        read(file)
    with pytest.raises(DefinitionError):
        Journal.open(file, seal=GENESIS)
    assert main(["verify", str(file)]) in (1, 2)
    assert main(["replay", str(file)]) == main(["run", "--resume", str(file), "--no-operator"]) == 2
    assert file.read_bytes() == before


def interior(size: int, child: int) -> bytes:
    """A page of a table's tree that names one child five hundred times (sqlite.org/fileformat2.html, section 1.6)."""
    page, cell = bytearray(size), size - 8
    struct.pack_into(">BHHHBI", page, 0, 5, 0, 500, cell, 0, child)
    for number in range(500):
        struct.pack_into(">H", page, 12 + 2 * number, cell)
    struct.pack_into(">IB", page, cell, child, 127)
    return bytes(page)


def folded(good: Path, table: str, depth: int = 8) -> Path:
    """A journal of some pages in which a table has 500^8 rows."""
    picture = b"a picture"
    hashed = hashlib.sha256(picture).hexdigest()
    file = altered(good, f"INSERT INTO blobs VALUES ('{hashed}', 'image/png', x'{picture.hex()}')")
    with closing(sqlite3.connect(file)) as database:
        (size,), (pages,) = (database.execute(f"PRAGMA {each}").fetchone() for each in ("page_size", "page_count"))
        (root,) = database.execute(f"SELECT rootpage FROM sqlite_schema WHERE name = '{table}'").fetchone()
    raw, at = bytearray(file.read_bytes()), (root - 1) * size
    leaf = raw[at : at + size]
    raw[at : at + size] = interior(size, pages + 1)
    for number in range(1, depth):
        raw += interior(size, pages + number + 1)
    raw += leaf
    struct.pack_into(">I", raw, 28, pages + depth)
    file.write_bytes(raw)
    return file


LOOKS: dict[str, Callable[[Record], object]] = {
    "rows": lambda record: sum(1 for _ in record.raw()),
    "blobs": lambda record: sum(1 for _ in record.blobs()),
    "pictures": lambda record: sum(1 for _ in record.pictures()),
}


@pytest.mark.parametrize("look", LOOKS)
def test_a_file_whose_pages_are_in_many_places_is_read_once(good: Path, look: str) -> None:
    file = folded(good, "rows" if look == "rows" else "blobs")
    assert file.stat().st_size < 100_000
    assert any("in several places" in fault.sentence for fault in verify(file))
    with Record(file) as record, pytest.raises(DefinitionError, match="in several places"):
        LOOKS[look](record)


def test_rows_that_share_their_text_state_no_more_than_the_file_holds(good: Path) -> None:
    """The cells of a leaf, each with a number of its own, name the same pages for the rest of their text."""
    file = altered(good, "DELETE FROM rows", f"INSERT INTO rows VALUES (1, 'note', '{'x' * (49 * 4092 + 478)}', '')")
    with closing(sqlite3.connect(file)) as database:
        (size,) = database.execute("PRAGMA page_size").fetchone()
        (root,) = database.execute("SELECT rootpage FROM sqlite_schema WHERE name = 'rows'").fetchone()
    raw, at = bytearray(file.read_bytes()), (root - 1) * size
    (cell,) = struct.unpack_from(">H", raw, at + 8)
    whole = raw[at + cell : at + size]  # the length in three bytes, the number in one, the beginning, the next page
    for number in range(1, 6):
        place = size - number * len(whole)
        raw[at + place : at + place + len(whole)] = whole[:3] + bytes([number]) + whole[4:]
        struct.pack_into(">H", raw, at + 8 + 2 * (number - 1), place)
    struct.pack_into(">HH", raw, at + 3, 5, size - 5 * len(whole))
    file.write_bytes(raw)
    with Record(file) as record, pytest.raises(DefinitionError, match="in several places"):
        assert [row[0] for row in record.raw()] == [1, 2, 3, 4, 5]
