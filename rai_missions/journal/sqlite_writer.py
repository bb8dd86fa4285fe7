# SPDX-License-Identifier: Apache-2.0
"""A journal's file made, opened to be written, and left at rest."""

from __future__ import annotations

import os
import sqlite3
from contextlib import suppress
from pathlib import Path

from rai_missions.journal.sqlite import APPLICATION, FORMAT, LONGEST_BYTES, TABLES, Connection, log_of, uri_of
from rai_missions.journal.sqlite_reader import open_to_read

__all__ = ("close_to_rest", "end_of_opening", "end_rest", "open_again", "open_to_write", "widen")

REST_BYTES = 16
"""The length of the log of a journal at rest: less than the header of one that has rows."""
FEW_PAGES, MANY_PAGES = 4, -2_000
"""SQLite's `cache_size`: four pages hold what appending a row touches; 2,000 kB, its default, hold a picture."""
CHECKPOINT_PAGES = 1_000
"""SQLite's default: of a log so long the content is moved into the file."""
FEW_STATEMENTS = 1
"""Statements that a writing connection keeps compiled, at 1 kB each: that of a row. Making a journal has a dozen."""


def open_to_write(path: Path, *, new: bool) -> Connection:
    """A connection whose every commit survives the end of the process, though not always a loss of power.

    Write-ahead log with `synchronous=NORMAL`: a commit is in the system's hands when it returns, and on the disk at
    the next checkpoint. Locking is exclusive, so there is no file of shared memory.
    """
    if not new:
        open_to_read(path).close()  # whatever is no journal is left as it is
    return _connected(path, new=new)


def open_again(path: Path) -> Connection:
    """What `open_to_write` gives, of a journal at rest; the disk is not waited for until `end_of_opening`.

    SQLite waits for the disk once the header of a log is written, so that what the log had before is not taken for
    its content after a loss of power. At rest it had nothing. As many journals as there are may be opened at once.
    """
    is_new = _length(log_of(path)) <= REST_BYTES
    connection = _connected(path, new=False)
    if is_new:
        _set(connection, "synchronous=OFF", "wal_autocheckpoint=0")
    return connection


def end_of_opening(connection: Connection) -> None:
    """The log has its header: what is moved from it into the file waits for the disk."""
    _set(connection, "synchronous=NORMAL", f"wal_autocheckpoint={CHECKPOINT_PAGES}")


def _connected(path: Path, *, new: bool) -> Connection:
    connection = sqlite3.connect(
        uri_of(path, "rw"),
        uri=True,
        isolation_level=None,
        check_same_thread=False,
        timeout=0,
        cached_statements=FEW_STATEMENTS,
    )
    try:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LONGEST_BYTES)
        _set(connection, "locking_mode=EXCLUSIVE", "journal_mode=WAL", "synchronous=NORMAL", "trusted_schema=OFF")
        if new:
            marks = [f"PRAGMA application_id={APPLICATION}", f"PRAGMA user_version={FORMAT}"]
            connection.executescript("; ".join(["BEGIN", *marks, *TABLES.values(), "COMMIT"]))
        _set(connection, f"cache_size={FEW_PAGES}", "shrink_memory")  # what is set aside already is for 20 pages
    except BaseException:
        connection.close()
        raise
    return connection


def _set(connection: Connection, *pragmas: str) -> None:
    """Set what a connection is to do.

    As a script, for which Python's lock is given up once a pragma. `execute` does so six times, and a thread that
    writes rows waits for the lock each time, behind all runs of the process.
    """
    connection.executescript("".join(f"PRAGMA {pragma};" for pragma in pragmas))


def close_to_rest(connection: Connection, path: Path) -> None:
    """Close the files of a journal that keeps its writer: all rows are in the file itself from now on.

    Where there is no log, a reader takes the file for one that stays as it is. So a log is left, of some bytes that
    SQLite takes for none (sqlite.org/fileformat2.html, section 4.1: a header has 32), and no two are alike.
    """
    with suppress(sqlite3.Error):  # a disk that is full or gone: the rows are in the log, which stays then
        connection.close()
    with suppress(OSError):
        descriptor = os.open(log_of(path), os.O_WRONLY | os.O_CREAT | os.O_EXCL, 0o644)
        try:
            os.write(descriptor, os.urandom(REST_BYTES))
        finally:
            os.close(descriptor)


def end_rest(path: Path) -> None:
    """Take away the log that `close_to_rest` left; one that has rows stays."""
    log = log_of(path)
    if _length(log) <= REST_BYTES:
        with suppress(OSError):
            log.unlink()


def _length(log: Path) -> int:
    """The length of a log in bytes; 0 where there is none."""
    try:
        return log.stat().st_size
    except OSError:
        return 0


def widen(connection: Connection) -> None:
    """Give a connection that writes pictures SQLite's own amount of memory; a picture takes longer without."""
    _set(connection, f"cache_size={MANY_PAGES}")
