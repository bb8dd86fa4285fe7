# SPDX-License-Identifier: Apache-2.0
"""A journal's file opened to be read, also while another process writes it, or after it was killed.

Rule: reading changes nothing, not even the folder.
"""

from __future__ import annotations

import os
import shutil
import sqlite3
import tempfile
from contextlib import suppress
from pathlib import Path

from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.journal.lock import Lock, file_id, in_place_of
from rai_missions.journal.sqlite import APPLICATION, FORMAT, LONGEST_BYTES, SCHEMA, log_of, uri_of
from rai_missions.redaction import cut

__all__ = ("JournalReader", "NoJournal", "Unbegun", "open_to_read")

WAL_HEADER, WAL_FRAME = 32, 24
"""Bytes of the header of a write-ahead log, and of each of its frames next to its page."""
DAMAGED = "the journal is damaged: a part of its file is missing or was overwritten; give a whole copy of it"
TRIES = 20
"""How often a journal that is being written is copied before its reader gives up."""


class NoJournal(DefinitionError):
    """A file that is something else than a journal which this program reads."""


class Unbegun(NoJournal):
    """A file without a row, as anyone who dies while it makes a journal leaves it."""


def open_to_read(path: Path) -> JournalReader:
    """A connection to what is in a journal now, also while another process writes it or after it was killed.

    Raises:
        UsageError: There is no such file, or it may not be read.
        DefinitionError: It is no journal of this format.
    """
    try:
        if not path.is_file():
            raise UsageError(f"no journal at {path}: {in_place_of(path)}")
        if not os.access(path, os.R_OK):
            raise UsageError(f"the journal {path} cannot be read: permission denied")
        connection = _opened(path.resolve())
    except OSError as error:
        place = error.filename2 or error.filename or path  # its log, or the copy that is made of both
        raise UsageError(f"the journal {path} cannot be read: {error.strerror}: {place}") from None
    except sqlite3.Error as error:
        if _code(error) in (sqlite3.SQLITE_FULL, sqlite3.SQLITE_IOERR):
            where = f"the disk of it, or of its copy in {tempfile.gettempdir()}, is full or at fault"
            raise UsageError(f"the journal {path} cannot be read: {error}: {where}") from None
        raise _not_a_journal(error, path) from None
    try:
        connection.setlimit(sqlite3.SQLITE_LIMIT_LENGTH, LONGEST_BYTES)
        connection.execute("PRAGMA trusted_schema=OFF")
        check_is_journal(connection, path)
    except BaseException:
        connection.close()
        raise
    return connection


def _code(error: Exception) -> int:
    """SQLite's primary code; 0 where it gives none."""
    return int(getattr(error, "sqlite_errorcode", 0)) & 0xFF


def _not_a_journal(error: Exception, path: Path) -> DefinitionError:
    if _code(error) == sqlite3.SQLITE_CORRUPT:
        return DefinitionError([Fault("", DAMAGED)], str(path))
    return NoJournal([Fault("", f"no journal: {error}; give a file that a run has written")], str(path))


def check_is_journal(connection: sqlite3.Connection, path: Path) -> None:
    """Whether a file is a journal of this format, and nothing else: no view or trigger that would run on reading.

    Raises:
        DefinitionError: It is not.
    """
    try:
        application = connection.execute("PRAGMA application_id").fetchone()[0]
        version = connection.execute("PRAGMA user_version").fetchone()[0]
        found = connection.execute("SELECT type, name, tbl_name, ifnull(sql, '') FROM sqlite_schema").fetchall()
    except (sqlite3.Error, UnicodeDecodeError) as error:
        raise _not_a_journal(error, path) from None
    if not found and application in (0, APPLICATION):
        sentence = "no journal of a run: its process died making it, and a new one is to be started; "
        sentence += f"or its rows are in '{log_of(path).name}', which was not brought along: give both files"
        raise Unbegun([Fault("", sentence)], str(path))
    if application != APPLICATION:
        sentence = "a SQLite file, but no journal; give a file that a run has written"
        raise NoJournal([Fault("", sentence)], str(path))
    if version != FORMAT:
        sentence = f"a journal of format {version}; this program reads format {FORMAT}"
        raise NoJournal([Fault("", sentence)], str(path))
    if sorted(found, key=str) != sorted(SCHEMA, key=str):
        names = sorted(cut(name if sort == "table" else f"{sort} {name}", 60) for sort, name, _, made in found if made)
        sentence = f"its tables are not those of a journal: {', '.join(names[:10]) or 'none'}"
        raise DefinitionError([Fault("", sentence)], str(path))


class JournalReader(sqlite3.Connection):
    """A journal that is open to be read."""

    cut = 0
    """Bytes at the end of its log that belong to a row which was not written whole."""


def _cut(log: Path, frames: int) -> int:
    """The bytes behind a log's valid frames that the same writer has left (sqlite.org/fileformat2.html, section 4.1).

    What is left of an earlier writing of the log has other salts, and is nothing that was cut.
    """
    with log.open("rb") as file:
        head = file.read(WAL_HEADER)
        end = WAL_HEADER + frames * (WAL_FRAME + int.from_bytes(head[8:12]))
        file.seek(end)
        frame = file.read(WAL_FRAME)
    salts = head[16:24]
    return max(0, log.stat().st_size - end) if salts.startswith(frame[8:16]) else 0


def _opened(path: Path) -> JournalReader:
    log = log_of(path)
    if not (log.is_file() and _head(log) and log.resolve().parent == path.parent):  # a link leads elsewhere
        place = uri_of(path, "ro") + "&immutable=1"
        return sqlite3.connect(place, uri=True, isolation_level=None, check_same_thread=False, factory=JournalReader)
    if not path.stat().st_size:  # SQLite would throw the log away
        raise DefinitionError([Fault("", DAMAGED)], str(path))
    with tempfile.TemporaryDirectory(prefix="rai_missions-") as folder:
        copy = Path(folder) / "journal"
        _copy(path, log, copy)
        connection = sqlite3.connect(copy, isolation_level=None, check_same_thread=False, factory=JournalReader)
        try:  # once the log is folded in, the open descriptor is all that is needed, and the copy is gone at the end
            frames = connection.execute("PRAGMA wal_checkpoint(PASSIVE)").fetchone()[1]
            connection.cut = _cut(Path(f"{copy}-wal"), max(0, frames))
            connection.execute("PRAGMA journal_mode=DELETE").fetchall()
            connection.execute("PRAGMA query_only=ON")
        except BaseException:
            connection.close()
            raise
        return connection


def _copy(path: Path, log: Path, copy: Path) -> None:
    """Copies a journal and its log as of one moment.

    While the log's header stays the same, whatever a checkpoint moves into the file is still in the log as well; so a
    file copied before its log is whole again once the log is read over it (sqlite.org/fileformat2.html, section 4).
    """
    for _ in range(TRIES):
        Path(f"{copy}-wal").unlink(missing_ok=True)  # of a try before
        before = _head(log)
        descriptor = Lock.held.get(file_id(path))
        if descriptor is None:
            shutil.copyfile(path, copy)
        else:
            _copy_from(descriptor, copy)
        with suppress(FileNotFoundError):
            shutil.copyfile(log, f"{copy}-wal")
        if before == _head(log):
            return
    raise UsageError(f"{path} is being written too fast to be read; read it when the run has ended")


def _copy_from(descriptor: int, copy: Path) -> None:
    with copy.open("wb") as target:
        while piece := os.pread(descriptor, 1 << 20, target.tell()):
            target.write(piece)


def _head(log: Path) -> bytes:
    try:
        with log.open("rb") as file:
            return file.read(32)
    except FileNotFoundError:
        return b""
