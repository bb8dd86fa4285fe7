# SPDX-License-Identifier: Apache-2.0
"""A journal as a file: renamed, so that another run may have its name, and copied row by row.

Rule: no row is lost by a renaming: the log of SQLite is folded in first, and a journal that is being written stays.
Rule: a copy has the rows as they were written, hashes and all; nothing is corrected, so a fault in them shows.
"""

from __future__ import annotations

import os
from collections.abc import Iterable
from contextlib import suppress
from pathlib import Path

from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.journal.lock import Lock, writing_at
from rai_missions.journal.rows import Blob, Raw
from rai_missions.journal.sqlite import BLOB, ROW, SqliteError, log_of
from rai_missions.journal.sqlite_reader import Unbegun
from rai_missions.journal.sqlite_writer import open_to_write
from rai_missions.journal.verify import read

__all__ = ("copied", "free_name", "make_way", "set_aside")


def make_way(path: Path) -> Path | None:
    """Move a journal that has a name aside, so that another may have it; gives its new name, None where there was none.

    Raises:
        UsageError: Another process writes it, its log cannot be folded in, or no file can have that name.
        DefinitionError: It is no journal, or it was altered.
    """
    with writing_at(path):
        is_there = path.is_file()
    if not is_there:
        return None
    try:
        return set_aside(path)
    except DefinitionError as error:
        left = Fault("", "this file is left as it is, and no journal is written in its place; name another")
        raise DefinitionError([*error.faults, left], error.source) from None


def free_name(path: Path) -> Path:
    """The first name next to a file that no file has: `run.1.journal` for `run.journal`.

    Nor may a log be left there, of a journal that was deleted: SQLite would take its rows for those of the next one.
    """
    names = (path.with_suffix(f".{number}{path.suffix}") for number in range(1, 10_000))
    return next(name for name in names if not os.path.lexists(name) and not os.path.lexists(log_of(name)))


def set_aside(path: Path, to: Path | None = None) -> Path:
    """Rename a journal, or a file in which one was begun; gives its new name.

    Args:
        path: Where it is.
        to: Its new name; by default the first that is free once no other process may move it.

    Raises:
        UsageError: Another process writes it, or its log cannot be folded in.
        DefinitionError: It is no journal, or it was altered.
    """
    lock = Lock(path, new=False)
    try:
        with suppress(Unbegun):  # no row is in it, so none can be lost
            read(path).close()
            _fold_in(path)
        return path.rename(to or free_name(path))
    finally:
        lock.release()


def _fold_in(path: Path) -> None:
    """SQLite does so when anyone who writes closes the file, and takes the log away."""
    log = log_of(path)
    if not log.exists():
        return
    with suppress(SqliteError):
        open_to_write(path, new=False).close()
    if log.exists():
        raise UsageError(f"what {log.name} holds cannot be written into {path}, so it is not moved aside; name another")


def copied(path: Path, parts: Iterable[Raw | Blob], source: str) -> None:
    """Write a new journal.

    Args:
        path: Where; must not be there.
        parts: Rows, in any order, and pictures.
        source: Where they come from, for an error.

    Raises:
        DefinitionError: A row that no journal holds, or two of one number.
        UsageError: It cannot be written there.
    """
    lock, number = Lock(path, new=True), -1
    try:
        database = open_to_write(path, new=True)
        try:
            database.execute("BEGIN")
            for part in parts:
                number = part[0] if isinstance(part[0], int) else number
                database.execute(ROW if isinstance(part[0], int) else BLOB, part)
            database.execute("COMMIT")
        except (SqliteError, OverflowError, UnicodeError) as error:
            raise DefinitionError([Fault(f"row {number}", f"no journal has such a row: {error}")], source) from None
        finally:
            database.close()
    finally:
        lock.release()
