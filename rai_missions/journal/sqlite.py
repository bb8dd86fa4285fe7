# SPDX-License-Identifier: Apache-2.0
"""The one door to SQLite: a journal's file is made, locked, opened for writing and opened for reading here.

Rule: reading changes nothing, not even the folder; one process writes, and its lock dies with it.
"""

from __future__ import annotations

import errno
import fcntl
import os
import resource
import shutil
import sqlite3
import tempfile
from abc import ABC, abstractmethod
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Self

from rai_missions.errors import DefinitionError, Fault, UsageError, irregular, make_folder_of
from rai_missions.redaction import cut

__all__ = (
    "BLOB",
    "FILES",
    "FORMAT",
    "LONGEST_BYTES",
    "MORE",
    "ROW",
    "Closable",
    "Connection",
    "JournalReader",
    "Lock",
    "NoJournal",
    "SqliteError",
    "Unbegun",
    "close_to_rest",
    "end_of_opening",
    "end_rest",
    "log_of",
    "may_open",
    "open_again",
    "open_to_read",
    "open_to_write",
    "out_of_files",
    "widen",
    "writing_at",
)  # fmt: skip

SqliteError = sqlite3.Error
Connection = sqlite3.Connection

APPLICATION = 0x5241494D
"""`RAIM` in the file's header: what reports a journal from other SQLite files."""
FORMAT = 1
COLUMNS = {
    "rows": "number INTEGER PRIMARY KEY, kind TEXT NOT NULL, content TEXT NOT NULL, hash TEXT NOT NULL",
    "blobs": "sha256 TEXT PRIMARY KEY, media_type TEXT NOT NULL, bytes BLOB NOT NULL",
}
ROW = "INSERT INTO rows VALUES (?, ?, ?, ?)"
MORE = ", (?, ?, ?, ?)"
"""Another row in the same statement, which is a transaction by itself."""
BLOB = "INSERT OR IGNORE INTO blobs VALUES (?, ?, ?)"
TABLES = {name: f"CREATE TABLE {name} ({columns})" for name, columns in COLUMNS.items()}
SCHEMA = sorted(
    [
        *(("table", name, name, made) for name, made in TABLES.items()),
        ("index", "sqlite_autoindex_blobs_1", "blobs", ""),
    ]
)
"""All that a journal's file declares. A trigger may have the name of a table, so the sort counts as well."""
LONGEST_BYTES = 64 * 1024 * 1024
"""No row and no picture is longer: neither written nor read."""
WAL_HEADER, WAL_FRAME = 32, 24
"""Bytes of the header of a write-ahead log, and of each of its frames next to its page."""
FILES = 3
"""Of a journal that is made: its lock, its database and the log."""
REST_BYTES = 16
"""The length of the log of a journal at rest: less than the header of one that has rows."""
DAMAGED = "the journal is damaged: a part of its file is missing or was overwritten; give a whole copy of it"
FEW_PAGES, MANY_PAGES = 4, -2_000
"""SQLite's `cache_size`: four pages hold what appending a row touches; 2,000 kB, its default, hold a picture."""
CHECKPOINT_PAGES = 1_000
"""SQLite's default: of a log so long the content is moved into the file."""
FEW_STATEMENTS = 1
"""Statements that a writing connection keeps compiled, at 1 kB each: that of a row. Making a journal has a dozen."""
TRIES = 20
"""How often a journal that is being written is copied before its reader gives up."""


class Closable(ABC):
    """What is closed at the end of a `with`."""

    @abstractmethod
    def close(self) -> None:
        """End it; doing so twice changes nothing."""

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()


class NoJournal(DefinitionError):
    """A file that is something else than a journal which this program reads."""


class Unbegun(NoJournal):
    """A file without a row, as anyone who dies while it makes a journal leaves it."""


@contextmanager
def writing_at(path: Path, what: str = "a journal") -> Iterator[None]:
    """Raise what the system refuses while a file is written as an error that names the file.

    Args:
        path: The file.
        what: What it is, with its article.

    Raises:
        UsageError: It cannot be written.
    """
    try:
        yield
    except OSError as error:
        raise UsageError(f"{what} cannot be written at {path}: {error.strerror}; name another file") from None


class Lock:
    """The right to write a journal: held by one process, given back by its end, however it ends.

    Two readings of one file in one process share SQLite's own locks, and closing any descriptor of the file would drop
    them; that is why anyone who reads in the process that writes reads through this descriptor.

    Raises:
        UsageError: Someone else has it, or the file cannot be opened for writing.
    """

    held: dict[tuple[int, int], int] = {}  # noqa: RUF012 - one table a process is the point
    """(device, inode) → descriptor, of the journals this process writes."""

    def __init__(self, path: Path, *, new: bool) -> None:
        if not new and irregular(path):
            raise UsageError(f"no journal at {path}: {_instead(path)}")
        if new:
            with writing_at(path):
                make_folder_of(path)
        try:
            if not new and _identity(path) in self.held:
                raise UsageError(f"{path} is being written by this process already; close that journal first")
            self.descriptor = os.open(path, os.O_RDWR | (os.O_CREAT | os.O_EXCL if new else 0), 0o644)
        except FileExistsError:
            if sort := irregular(path):
                raise UsageError(f"a journal cannot be written at {path}: that is {sort}; name another file") from None
            raise UsageError(
                f"{path} is there already, and a journal is never overwritten; name another file"
            ) from None
        except OSError as error:
            cure = out_of_files() or f"{error.strerror}; name another file"
            raise UsageError(f"a journal cannot be written at {path}: {cure}") from None
        try:
            fcntl.flock(self.descriptor, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except OSError:
            os.close(self.descriptor)
            raise UsageError(
                f"{path} is being written by another process; wait for its end or name another file"
            ) from None
        self._key = _identity(path)
        self.held[self._key] = self.descriptor

    def is_of(self, path: Path) -> bool:
        """Whether the file that has a name now is the one that is locked."""
        try:
            return _identity(path) == self._key
        except OSError:
            return False

    def release(self) -> None:
        """Give it back; doing so twice changes nothing."""
        if self.held.pop(self._key, None) is not None:
            os.close(self.descriptor)


def _instead(path: Path) -> str:
    """What there is where a journal was expected."""
    sort = irregular(path)
    return f"that is {sort}" if sort else "there is no such file"


def _identity(path: Path) -> tuple[int, int]:
    found = path.stat()
    return found.st_dev, found.st_ino


def open_to_write(path: Path, *, new: bool) -> sqlite3.Connection:
    """A connection whose every commit survives the end of the process, though not always a loss of power.

    Write-ahead log with `synchronous=NORMAL`: a commit is in the system's hands when it returns, and on the disk at
    the next checkpoint. Locking is exclusive, so there is no file of shared memory.
    """
    if not new:
        open_to_read(path).close()  # whatever is no journal is left as it is
    return _connected(path, new=new)


def open_again(path: Path) -> sqlite3.Connection:
    """What `open_to_write` gives, of a journal at rest; the disk is not waited for until `end_of_opening`.

    SQLite waits for the disk once the header of a log is written, so that what the log had before is not taken for
    its content after a loss of power. At rest it had nothing. As many journals as there are may be opened at once.
    """
    is_new = _length(log_of(path)) <= REST_BYTES
    connection = _connected(path, new=False)
    if is_new:
        _set(connection, "synchronous=OFF", "wal_autocheckpoint=0")
    return connection


def end_of_opening(connection: sqlite3.Connection) -> None:
    """The log has its header: what is moved from it into the file waits for the disk."""
    _set(connection, "synchronous=NORMAL", f"wal_autocheckpoint={CHECKPOINT_PAGES}")


def _connected(path: Path, *, new: bool) -> sqlite3.Connection:
    connection = sqlite3.connect(
        _uri(path, "rw"),
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


def _set(connection: sqlite3.Connection, *pragmas: str) -> None:
    """Set what a connection is to do.

    As a script, for which Python's lock is given up once a pragma. `execute` does so six times, and a thread that
    writes rows waits for the lock each time, behind all runs of the process.
    """
    connection.executescript("".join(f"PRAGMA {pragma};" for pragma in pragmas))


def close_to_rest(connection: sqlite3.Connection, path: Path) -> None:
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
    """Of a log, in bytes; 0 where there is none."""
    try:
        return log.stat().st_size
    except OSError:
        return 0


def widen(connection: sqlite3.Connection) -> None:
    """Give a connection that writes pictures SQLite's own amount of memory; a picture takes longer without."""
    _set(connection, f"cache_size={MANY_PAGES}")


def out_of_files() -> str:
    """The cure where this process may not open the files of a journal; empty where it may."""
    if may_open(FILES):
        return ""
    most = resource.getrlimit(resource.RLIMIT_NOFILE)[0]
    return f"this process may open {most} files, and a journal takes one to three; raise `ulimit -n`"


def may_open(count: int) -> bool:
    """Whether this process may open so many files more."""
    opened: list[int] = []
    try:
        for _ in range(count):
            opened.append(os.open(os.devnull, os.O_RDONLY))
    except OSError as error:
        return error.errno != errno.EMFILE
    finally:
        for descriptor in opened:
            os.close(descriptor)
    return True


def open_to_read(path: Path) -> JournalReader:
    """A connection to what is in a journal now, also while another process writes it or after it was killed.

    Raises:
        UsageError: There is no such file, or it may not be read.
        DefinitionError: It is no journal of this format.
    """
    try:
        if not path.is_file():
            raise UsageError(f"no journal at {path}: {_instead(path)}")
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


def log_of(path: Path) -> Path:
    """Where SQLite writes what is not yet in a journal's file itself."""
    return path.with_name(f"{path.name}-wal")


def _opened(path: Path) -> JournalReader:
    log = log_of(path)
    if not (log.is_file() and _head(log) and log.resolve().parent == path.parent):  # a link leads elsewhere
        place = _uri(path, "ro") + "&immutable=1"
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
        descriptor = Lock.held.get(_identity(path))
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


def _uri(path: Path, mode: str) -> str:
    return f"{path.resolve().as_uri()}?mode={mode}"
