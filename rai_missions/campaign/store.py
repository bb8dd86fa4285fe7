# SPDX-License-Identifier: Apache-2.0
"""The results of a campaign: one SQLite file with its scenes, labels, questions, pictures and cells.

Rule: one process writes, and its lock dies with it; what a call that adds has returned from survives the end of the
process at any instant. A reader changes nothing.
"""

from __future__ import annotations

import fcntl
import json
import os
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import closing, contextmanager
from pathlib import Path
from typing import Any, NamedTuple, Self, get_args

from rai_missions.campaign.records import (
    CellRecord,
    CellStatus,
    LabelRecord,
    PictureRecord,
    QuestionRecord,
    SceneRecord,
)
from rai_missions.errors import UsageError, irregular, make_folder_of, meant_file

__all__ = ("DroppedUse", "LostParts", "ResultStore")

APPLICATION = 0x52414943
"""`RAIC` in the file's header."""
FORMAT = 1


class DroppedUse(NamedTuple):
    """What cells have used that are not in the store any more: no budget forgets that."""

    calls: int = 0
    tokens: int = 0
    cost: float = 0.0
    """As for a cell."""


class LostParts(NamedTuple):
    """What a store has from an earlier run of the campaign, and does not hold any more."""

    labels: bool = False
    """The labels are of another source."""
    embodiments: tuple[str, ...] = ()
    """What these show has changed, so the questions under them have."""


RECORDS: Mapping[str, type[Any]] = {
    "scene": SceneRecord,
    "label": LabelRecord,
    "question": QuestionRecord,
    "picture": PictureRecord,
    "cell": CellRecord,
}
KEYS: Mapping[str, tuple[str, ...]] = {
    "scene": ("scene",), "label": ("scene", "option"), "question": ("scene", "embodiment"),
    "picture": ("scene", "name"), "cell": ("cell",),
}  # fmt: skip
SORTS = {
    "seed": "INTEGER", "png": "BLOB", "permitted": "INTEGER", "best": "INTEGER", "prompt_tokens": "INTEGER",
    "completion_tokens": "INTEGER", "calls": "INTEGER", "latency_s": "REAL", "cost": "REAL",
}  # fmt: skip
STATUSES = ", ".join(f"'{each}'" for each in get_args(CellStatus))


def _made(table: str, record: type[Any]) -> str:
    sorts = SORTS if table != "question" else {}
    columns = [f"{name} {sorts.get(name, 'TEXT')}" for name in record._fields]
    check = [f"CHECK (status IN ({STATUSES}))"] if table == "cell" else []
    key = f"PRIMARY KEY ({', '.join(KEYS[table])})"
    return f"CREATE TABLE {table} ({', '.join([*columns, key, *check])}) WITHOUT ROWID"


TABLES = {
    "meta": "CREATE TABLE meta (key TEXT PRIMARY KEY, value TEXT) WITHOUT ROWID",
    **{table: _made(table, record) for table, record in RECORDS.items()},
}
DELETE = "DELETE FROM cell WHERE cell = ? RETURNING calls, prompt_tokens + completion_tokens, cost"
DROPPED = "dropped"
NO_PLACE = (sqlite3.SQLITE_CANTOPEN, sqlite3.SQLITE_READONLY, sqlite3.SQLITE_IOERR, sqlite3.SQLITE_FULL)
"""How SQLite reports that it finds no place for its lock: no file can be made in the folder, or the disk is full."""


class ResultStore:
    """The store of one campaign; a context manager.

    Args:
        path: The SQLite file; made where there is none.
        writes: Whether this process is to write; else the file must be there, and any number of processes may read.

    Raises:
        UsageError: Another process writes it, it is no store of a campaign, or it cannot be opened.
    """

    def __init__(self, path: Path | str, *, writes: bool = False) -> None:
        self.path, self._lock = Path(path), -1
        is_new = not self.path.exists()
        if is_new and not writes:
            raise UsageError(
                f"no results at {self.path}: there is no such file{meant_file(self.path, self.path.suffix)}"
            )
        if not is_new and (sort := irregular(self.path)):
            raise UsageError(f"no results at {self.path}: that is {sort}")
        if writes:
            self._lock = _locked(self.path)
        try:
            self._db = _opened(self.path, writes=writes)
        except BaseException:
            self._unlock()
            raise

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Close the file; doing so twice changes nothing."""
        self._db.close()
        self._unlock()  # last: closing any descriptor of a file drops the locks that SQLite has on it

    def _unlock(self) -> None:
        if self._lock >= 0:
            os.close(self._lock)
            self._lock = -1

    # -- what is added ---------------------------------------------------------------------------------------------

    def add(self, records: Iterable[NamedTuple]) -> None:
        """Add records of any tables in one transaction; one whose key is there replaces what was there."""
        with self._transaction():
            self._write(records)

    def _write(self, records: Iterable[NamedTuple]) -> None:
        by_table: dict[str, list[NamedTuple]] = {}
        for record in records:
            by_table.setdefault(TABLE_OF[type(record)], []).append(record)
        for table, rows in by_table.items():
            marks = ", ".join("?" * len(RECORDS[table]._fields))
            self._db.executemany(f"INSERT OR REPLACE INTO {table} VALUES ({marks})", rows)

    def begin(self, scenes: Iterable[SceneRecord], values: Mapping[str, Any], *, outdated: LostParts) -> None:
        """Note what a campaign is about. Of a scene whose data changed, labels, questions and pictures are dropped.

        Args:
            scenes: The campaign's scenes.
            values: As for `set_meta`.
            outdated: What else of the store does not hold any more.
        """
        given, before = list(scenes), {each.scene: each for each in self.scenes()}
        changed = [(each.scene,) for each in given if each.data != before.get(each.scene, each).data]
        with self._transaction():
            for table in ("label", "question", "picture"):
                self._db.executemany(f"DELETE FROM {table} WHERE scene = ?", changed)
            if outdated.labels:
                self._db.execute("DELETE FROM label")
                self._db.execute("UPDATE cell SET verdict = NULL, best = NULL")
            self._db.executemany(
                "DELETE FROM question WHERE embodiment = ?", [(each,) for each in outdated.embodiments]
            )
            self._write_meta(values)
            self._write(given)

    def set_meta(self, values: Mapping[str, Any]) -> None:
        """Note values of JSON types about the campaign."""
        with self._transaction():
            self._write_meta(values)

    def _write_meta(self, values: Mapping[str, Any]) -> None:
        rows = [(key, json.dumps(value, sort_keys=True)) for key, value in values.items()]
        self._db.executemany("INSERT OR REPLACE INTO meta VALUES (?, ?)", rows)

    def drop(self, keys: Iterable[str]) -> None:
        """Take cells out by their keys; what they have used is counted on in `dropped`."""
        used = self.dropped
        with self._transaction():
            for key in keys:
                gone = self._db.execute(DELETE, (key,)).fetchall()
                for amounts in gone:
                    used = DroppedUse(*(one + more for one, more in zip(used, amounts, strict=True)))
            if used != DroppedUse():
                self._db.execute("INSERT OR REPLACE INTO meta VALUES (?, ?)", (DROPPED, json.dumps(used)))

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """All of it, or nothing.

        Raises:
            UsageError: The disk is full, or takes nothing.
        """
        try:
            with self._db:
                self._db.execute("BEGIN IMMEDIATE")
                yield
        except sqlite3.OperationalError as error:
            raise UsageError(
                f"results cannot be written at {self.path}: {error}; what was stored before is kept, and the same"
                " command continues from there"
            ) from None
        except sqlite3.DatabaseError as error:
            raise self._damage(error) from None

    def _damage(self, error: sqlite3.DatabaseError) -> Exception:
        """What to raise for a fault of SQLite: one of the file's contents has its path, one of ours is as it is."""
        if isinstance(error, sqlite3.IntegrityError | sqlite3.ProgrammingError):
            return error
        what = "cannot be read" if isinstance(error, sqlite3.OperationalError) else "is damaged"
        return UsageError(f"{self.path} {what}: {error}; take a copy from before, or name another file")

    # -- what is read ----------------------------------------------------------------------------------------------

    def _read(self, query: str, *given: str) -> Iterator[Any]:
        """The rows that a query finds.

        Raises:
            UsageError: The file is damaged.
        """
        try:
            yield from self._db.execute(query, given)
        except sqlite3.DatabaseError as error:
            raise self._damage(error) from None

    @property
    def meta(self) -> dict[str, Any]:
        """What is noted about the campaign."""
        return {key: json.loads(value) for key, value in self._read("SELECT key, value FROM meta")}

    @property
    def dropped(self) -> DroppedUse:
        """What was used by cells that were taken out."""
        return DroppedUse(*self.meta.get(DROPPED, ()))

    def scenes(self) -> Iterator[SceneRecord]:
        """By name."""
        return map(SceneRecord._make, self._read("SELECT * FROM scene ORDER BY scene"))

    def labels(self) -> dict[str, dict[str, str]]:
        """Scene → option → verdict."""
        found: dict[str, dict[str, str]] = {}
        for scene, option, verdict in self._read("SELECT scene, option, verdict FROM label"):
            found.setdefault(scene, {})[option] = verdict
        return found

    def label_records(self) -> Iterator[LabelRecord]:
        """By scene and option, with the details."""
        return map(LabelRecord._make, self._read("SELECT * FROM label ORDER BY scene, option"))

    def questions(self) -> Iterator[QuestionRecord]:
        """By scene and embodiment."""
        return map(QuestionRecord._make, self._read("SELECT * FROM question ORDER BY scene, embodiment"))

    def pictures(self, scene: str) -> dict[str, bytes]:
        """The pictures of a scene: name → PNG."""
        return dict(self._read("SELECT name, png FROM picture WHERE scene = ?", scene))

    def cells(self) -> Iterator[CellRecord]:
        """By mission, scene, model, embodiment and order: the same table whatever order they were answered in."""
        order = "mission, scene, model, embodiment, option_order, cell"
        return map(CellRecord._make, self._read(f"SELECT * FROM cell ORDER BY {order}"))

    def done(self) -> set[str]:
        """The keys of the cells that need not be asked again: answered, or the model gave no answer."""
        return {key for (key,) in self._read("SELECT cell FROM cell WHERE status != 'failed'")}

    def keys(self) -> dict[str, list[str]]:
        """Key → mission, scene, model, embodiment and order of options, of every cell."""
        columns = "cell, mission, scene, model, embodiment, option_order"
        return {key: names for key, *names in self._read(f"SELECT {columns} FROM cell")}

    def shown(self) -> set[tuple[str, str]]:
        """Scene and embodiment of every question that is here."""
        return set(self._read("SELECT scene, embodiment FROM question"))

    def ends(self) -> dict[str, tuple[str, str]]:
        """Key → status and error, of every cell."""
        return {key: (status, error) for key, status, error in self._read("SELECT cell, status, error FROM cell")}


TABLE_OF: Mapping[type[Any], str] = {record: table for table, record in RECORDS.items()}


def _locked(path: Path) -> int:
    """The right to write: held by one process, given back by its end, however it ends."""
    try:
        make_folder_of(path)
        descriptor = os.open(path, os.O_RDWR | os.O_CREAT, 0o644)
    except OSError as error:
        raise UsageError(f"results cannot be written at {path}: {error.strerror}; name another file") from None
    try:
        fcntl.flock(descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        os.close(descriptor)
        raise UsageError(f"{path} is being written by another campaign; wait for its end or name another") from None
    return descriptor


def _opened(path: Path, *, writes: bool) -> sqlite3.Connection:
    """A connection to a store; the tables of a new one are made in one transaction."""
    if _mark(path) not in ((None, 0, APPLICATION) if writes else (None, APPLICATION)):
        raise UsageError(f"{path} is no store of a campaign; name another file")
    db = _connected(path, "mode=rw" if writes else "mode=ro")
    if not writes and not _is_readable(db):
        db.close()
        wal = path.with_name(f"{path.name}-wal")
        if wal.exists() and wal.stat().st_size:
            raise UsageError(f"{path} has a part in {wal.name}; open it once where files can be written, or copy both")
        db = _connected(path, "immutable=1")
    try:
        if writes and not db.execute("SELECT count(*) FROM sqlite_master").fetchone()[0]:
            _begin(db)
        if db.execute("PRAGMA application_id").fetchone()[0] != APPLICATION:
            raise UsageError(f"{path} is no store of a campaign; name another file")
        if (found := db.execute("PRAGMA user_version").fetchone()[0]) != FORMAT:
            raise UsageError(f"{path} is a store of format {found}; this version reads {FORMAT}")
        if writes:
            db.execute("PRAGMA journal_mode=WAL").fetchall()
            db.execute("PRAGMA synchronous=NORMAL").fetchall()
    except sqlite3.DatabaseError as error:
        db.close()
        if error.sqlite_errorcode & 0xFF in (sqlite3.SQLITE_IOERR, sqlite3.SQLITE_FULL):
            what = "results cannot be written at" if writes else "results cannot be read at"
            raise UsageError(f"{what} {path}: {error}; make room, or name another file") from None
        raise UsageError(f"{path} is no store of a campaign: {error}") from None
    except BaseException:
        db.close()
        raise
    return db


def _mark(path: Path) -> int | None:
    """The `application_id` of a SQLite file, which is left as it is; None for another file.

    SQLite itself looks: closing any other descriptor of a file would drop the locks that it has on it here.
    """
    with closing(_connected(path, "immutable=1")) as db:
        try:
            return int(db.execute("PRAGMA application_id").fetchone()[0])
        except sqlite3.DatabaseError:
            return None


def _connected(path: Path, how: str) -> sqlite3.Connection:
    uri = f"{path.resolve().as_uri()}?{how}"
    try:
        return sqlite3.connect(uri, uri=True, isolation_level=None, timeout=30, check_same_thread=False)
    except sqlite3.Error as error:
        raise UsageError(f"{path} cannot be opened: {error}") from None


def _is_readable(db: sqlite3.Connection) -> bool:
    """Whether the file can be read in the way in which it was opened, whatever it holds."""
    try:
        db.execute("SELECT count(*) FROM sqlite_master").fetchone()
    except sqlite3.OperationalError as error:
        return error.sqlite_errorcode & 0xFF not in NO_PLACE
    except sqlite3.DatabaseError:
        return True
    return True


def _begin(db: sqlite3.Connection) -> None:
    db.execute("BEGIN IMMEDIATE")
    for made in TABLES.values():
        db.execute(made)
    db.execute(f"PRAGMA application_id={APPLICATION}")
    db.execute(f"PRAGMA user_version={FORMAT}")
    db.execute("COMMIT")
