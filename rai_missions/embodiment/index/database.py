# SPDX-License-Identifier: Apache-2.0
"""The one door of `embodiment` to SQLite: an index is written whole, put in place at once, then only read.

Rule: the file that is read was never half written; one of another format is built again, and nothing in it is executed.
"""

from __future__ import annotations

import contextlib
import os
import sqlite3
import tempfile
import threading
import weakref
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any, NamedTuple, Self

from rai_missions.embodiment.passage import DocumentPassage
from rai_missions.errors import UsageError, irregular, make_folder_of

__all__ = ("IndexReader", "IndexedDocument", "IndexedPassage", "write_index")

APPLICATION = 0x52414949
"""`RAII` in the file's header."""
FORMAT = 2
"""The version of the tables and of how documents are cut: an index of another one is built again."""
SCHEMA = (
    "CREATE TABLE about (name TEXT PRIMARY KEY, value TEXT NOT NULL)",
    "CREATE TABLE documents (name TEXT PRIMARY KEY, sha256 TEXT NOT NULL, title TEXT NOT NULL, fault TEXT NOT NULL)",
    "CREATE TABLE passages (id INTEGER PRIMARY KEY, file TEXT NOT NULL, heading TEXT NOT NULL, text TEXT NOT NULL,"
    " vector BLOB)",
    "CREATE VIRTUAL TABLE words USING fts5(heading, text, content='passages', content_rowid='id',"
    " tokenize='porter unicode61 remove_diacritics 2')",
)
HEADING_WEIGHT, TEXT_WEIGHT = 2.0, 1.0
"""The weight of a word in a heading, and in the text (BM25)."""
LARGEST = 500_000_000
"""Bytes of an index."""
SQLITE, APPLICATION_AT = b"SQLite format 3\x00", slice(68, 72)
"""How a database begins, and where its header has the application (SQLite's file format, section 1.3)."""


class IndexedDocument(NamedTuple):
    """A file of the folder, as it was when it was read."""

    name: str
    sha256: str
    title: str
    fault: str
    """Why it was not read; empty if it was."""


class IndexedPassage(NamedTuple):
    """A passage with its number and its vector."""

    number: int
    passage: DocumentPassage
    vector: bytes | None
    """float32, of length one; None where there was no model."""


class IndexReader:
    """An index that is read. Several threads may use it. Its file is closed with it, at the latest when it is let go.

    Args:
        path: Its file.

    Raises:
        UsageError: There is none, or it is of another format; states how to build it.
    """

    def __init__(self, path: Path) -> None:
        self.path, self._lock = path, threading.Lock()
        if irregular(path) or not path.is_file() or path.stat().st_size > LARGEST:
            raise UsageError(f"there is no index at {path}; build it: rai-missions whoami build FOLDER")
        self._connection = sqlite3.connect(
            f"{path.absolute().as_uri()}?mode=ro&immutable=1", uri=True, check_same_thread=False
        )
        weakref.finalize(self, self._connection.close)
        try:
            self._prepare()
        except (sqlite3.Error, UnicodeDecodeError) as error:
            self.close()
            raise UsageError(
                f"{path} is no index of this version ({error}); build it again: rai-missions whoami build FOLDER"
            ) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file."""
        self._connection.close()

    def about(self) -> Mapping[str, str]:
        """What the index holds of itself: `embedder`."""
        return dict(self._rows("SELECT name, value FROM about"))

    def documents(self) -> tuple[IndexedDocument, ...]:
        """The documents, in the order of their names."""
        return tuple(IndexedDocument(*row) for row in self._rows("SELECT * FROM documents ORDER BY name"))

    def passages(self, file: str | None = None) -> tuple[IndexedPassage, ...]:
        """The passages in their order, of one document or of all."""
        rows = self._rows(
            "SELECT id, file, heading, text, vector FROM passages WHERE ? IS NULL OR file = ? ORDER BY id", file, file
        )
        return tuple(IndexedPassage(row[0], DocumentPassage(*row[1:4]), row[4]) for row in rows)

    def with_words(self, terms: Sequence[str], count: int) -> list[int]:
        """The numbers of the passages with the most of the terms (BM25), the best first."""
        if not terms:
            return []
        rows = self._rows(
            f"SELECT rowid FROM words WHERE words MATCH ?"
            f" ORDER BY bm25(words, {HEADING_WEIGHT}, {TEXT_WEIGHT}), rowid LIMIT ?",
            " OR ".join(map(_quoted, terms)),
            count,
        )
        return [row[0] for row in rows]

    def with_term(self, term: str) -> frozenset[int]:
        """The numbers of all passages in which a term occurs, in whatever form (Porter's stemming)."""
        return frozenset(row[0] for row in self._rows("SELECT rowid FROM words WHERE words MATCH ?", _quoted(term)))

    def _prepare(self) -> None:
        connection = self._connection
        connection.execute("PRAGMA trusted_schema = OFF")
        connection.execute("PRAGMA query_only = ON")
        application = connection.execute("PRAGMA application_id").fetchone()[0]
        version = connection.execute("PRAGMA user_version").fetchone()[0]
        if (application, version) != (APPLICATION, FORMAT):
            raise sqlite3.DatabaseError(f"format {version} of {application:#x}, not {FORMAT} of {APPLICATION:#x}")
        declared = {row[0] for row in connection.execute("SELECT sql FROM sqlite_master WHERE type != 'index'")}
        if (
            not set(SCHEMA) <= declared
            or connection.execute("SELECT count(*) FROM sqlite_master WHERE type IN ('trigger', 'view')").fetchone()[0]
        ):
            raise sqlite3.DatabaseError("it declares other tables")

    def _rows(self, query: str, *values: object) -> list[Any]:
        try:
            with self._lock:
                return self._connection.execute(query, values).fetchall()
        except (sqlite3.Error, UnicodeDecodeError) as error:
            raise UsageError(
                f"the index {self.path} is damaged ({error}); build it again: rai-missions whoami build FOLDER"
            ) from None


def write_index(
    path: Path, about: Mapping[str, str], documents: Iterable[IndexedDocument], passages: Iterable[IndexedPassage]
) -> None:
    """Write an index and put it in its place; who reads the old one keeps reading it.

    Raises:
        UsageError: It cannot be written there, or would take the place of a file that is no index.
    """
    made = ""
    try:
        if sort := irregular(path):
            raise UsageError(f"the index cannot be written to {path}: that is {sort}; name a file with --index FILE")
        if not _is_ours(path):
            raise UsageError(
                f"{path} is no index, and stays as it is; name another place with --index FILE, or delete it"
            )
        make_folder_of(path)
        handle, made = tempfile.mkstemp(prefix=f".{path.name}.", dir=path.parent)
        os.close(handle)
        _fill(made, about, documents, passages)
        os.replace(made, path)
    except (OSError, sqlite3.Error) as error:
        why = getattr(error, "strerror", None) or error
        raise UsageError(
            f"the index cannot be written to {path}: {why}; name another place with --index FILE"
        ) from None
    finally:
        if made:
            with contextlib.suppress(OSError):
                os.unlink(made)


def _is_ours(path: Path) -> bool:
    """Whether an index may be put there: no file has content there, or it begins as an index of any version does."""
    if irregular(path) or not path.is_file():
        return True  # missing, or what cannot be replaced
    with path.open("rb") as file:
        head = file.read(APPLICATION_AT.stop)
    return not head or (head.startswith(SQLITE) and int.from_bytes(head[APPLICATION_AT], "big") == APPLICATION)


def _fill(
    file: str, about: Mapping[str, str], documents: Iterable[IndexedDocument], passages: Iterable[IndexedPassage]
) -> None:
    with contextlib.closing(sqlite3.connect(file, isolation_level=None)) as connection:
        connection.execute("PRAGMA journal_mode = OFF")
        connection.execute(f"PRAGMA application_id = {APPLICATION}")
        connection.execute(f"PRAGMA user_version = {FORMAT}")
        connection.execute("BEGIN")
        for statement in SCHEMA:
            connection.execute(statement)
        connection.executemany("INSERT INTO about VALUES (?, ?)", sorted(about.items()))
        connection.executemany("INSERT INTO documents VALUES (?, ?, ?, ?)", documents)
        connection.executemany(
            "INSERT INTO passages VALUES (?, ?, ?, ?, ?)",
            ((each.number, *each.passage, each.vector) for each in passages),
        )
        connection.execute("INSERT INTO words(words) VALUES ('rebuild')")
        connection.execute("COMMIT")
    with open(file, "rb") as written:
        os.fsync(written.fileno())


def _quoted(term: str) -> str:
    """A term as FTS5 takes it: a phrase, in which nothing is an operator."""
    return '"' + term.replace('"', '""') + '"'
