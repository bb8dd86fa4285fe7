# SPDX-License-Identifier: Apache-2.0
"""A journal that is being written.

Rule: when `write` has returned, the row outlives the process. Only then may the step's effects be performed.
Rule: its lock is held from its opening to `close`. Its files may be closed meanwhile, and are open for a row.
"""

from __future__ import annotations

import datetime
import platform
import threading
import time
import uuid
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache
from itertools import chain
from pathlib import Path
from typing import Any, Self

from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError, UsageError
from rai_missions.given import given_path
from rai_missions.image import Image, media_type
from rai_missions.journal.codec import encode
from rai_missions.journal.json_values import to_json
from rai_missions.journal.lock import Lock, out_of_files
from rai_missions.journal.open_files import OPEN
from rai_missions.journal.rows import GENESIS, Blob, Header, Raw, chained, text_of, written_header
from rai_missions.journal.sqlite import BLOB, MORE, ROW, Connection, SqliteError
from rai_missions.journal.sqlite_writer import close_to_rest, end_of_opening, end_rest, open_again, open_to_write, widen
from rai_missions.redaction import logger

__all__ = ("Journal", "Witness", "versions")

log = logger(__name__)

CLOSE_S = 1.0
FIRST_MARK = 100_000_000
"""A journal that has so many bytes is mentioned in the log, and again at ten times as many."""
LOOK_ROWS = 100
"""Rows between two looks at the size of the journal."""
LAST = "SELECT number, hash FROM rows ORDER BY number DESC LIMIT 1"
Witness = Callable[[tuple[Raw, ...], tuple[Blob, ...]], None]
"""Is notified of rows once they are written, with the pictures that came with the last; must return at once, and never
raise."""


def versions() -> dict[str, str]:
    """The versions of Python, of the format and of this package, for a journal's header."""
    ours = _version()
    return {"python": platform.python_version(), "format": "1", **({"rai_missions": ours} if ours else {})}


@cache
def _version() -> str:
    """The version of this package, which takes 10 ms to find; empty where it is not installed."""
    from importlib.metadata import PackageNotFoundError, version  # slow to import

    with suppress(PackageNotFoundError):
        return version("rai-missions")
    return ""


class Journal:
    """Appends rows to a journal. Made by `create` or `open`; safe to use from several threads.

    Survives: the end of the process at any instant, `kill -9` included, loses no row that `write` has returned from.
    After a loss of power the journal is still whole, but rows of the last seconds may be missing at its end.
    """

    def __init__(self, path: Path, lock: Lock, *, new: bool, witness: Witness | None = None) -> None:
        self.path, self._lock, self._witness = path, lock, witness
        self._alone = threading.Lock()
        self._open, self._place = True, path.resolve()
        try:
            self._database: Connection | None = open_to_write(path, new=new)
        except SqliteError as error:
            cure = out_of_files() or f"{error}; name another file"
            raise UsageError(f"a journal cannot be written at {path}: {cure}") from None
        self._is_wide = self._is_new_log = False
        self._number, self._hash = -1, GENESIS
        self._looks_at, self._mark = LOOK_ROWS, _mark_above(self._place.stat().st_size)
        self.written = time.monotonic()

    @classmethod
    def create(cls, path: Path | str, header: Header, *, witness: Witness | None = None) -> Self:
        """A new journal with its row 0; its folder is made where there is none.

        Raises:
            UsageError: The file is there already, or none can be written there.
        """
        path = given_path(path, "a journal")
        OPEN.make_room(len(Lock.held) + 1)
        lock, journal = Lock(path, new=True), None
        try:
            journal = cls(path, lock, new=True, witness=witness)
            journal._append([("header", written_header(_filled(header)))])
            OPEN.opened(journal)
        except BaseException:
            if journal is not None:
                journal._close_files()
            lock.release()
            for left in (path, path.with_name(f"{path.name}-wal")):
                with suppress(OSError):  # a name that is too long is that of no file
                    left.unlink(missing_ok=True)
            raise
        return journal

    @classmethod
    def open(cls, path: Path | str, *, witness: Witness | None = None, seal: str | None = None) -> Self:
        """A journal that is there, to continue with.

        Args:
            seal: The hash of its last row, as `Record.seal` read it; left out, any will do.

        Raises:
            UsageError: There is none, or another process writes it, or has written on since it was read.
            DefinitionError: It is no journal of this format.
        """
        path = given_path(path, "a journal")
        OPEN.make_room(len(Lock.held) + 1)
        lock, journal = Lock(path, new=False), None
        try:
            journal = cls(path, lock, new=False, witness=witness)
            last = journal._opened().execute(LAST).fetchone()
            if last is not None:
                journal._number, journal._hash = last
            if seal is not None and journal._hash != seal:
                journal.close()
                raise UsageError(f"another process has continued with the run of {path} meanwhile; start once more")
            OPEN.opened(journal)
        except BaseException:
            if journal is not None:
                journal._close_files()
            lock.release()
            raise
        return journal

    def write(
        self, step: Step, *, since: float, quiet: Iterable[tuple[str, Any, float]] = (), performed: Iterable[int] = ()
    ) -> int:
        """Writes a step, and gives the number of its row.

        Args:
            step: What an event did.
            since: The engine's clock right before the event was taken, seconds.
            quiet: The blackboard writes that enabled nothing since the last row: key, value, stamp; newest of a key.
            performed: The numbers of steps whose effects were carried out. Each is confirmed by a row of its own before
                this one, or not at all: where it raises, they may be confirmed by themselves.

        Raises:
            ConnectorError: The row was not written: the disk is full or gone. Nothing of the step may be performed.
            UsageError: A value in it that a journal cannot hold, or the journal is closed.
        """
        pictures: dict[str, Image] = {}
        before = [[key, to_json(value), at] for key, value, at in quiet]
        content: dict[str, Any] = {"since": since, **({"before": before} if before else {})}
        content["step"] = encode(step, lambda image: _digest(image, pictures))
        confirmed = [_confirmation(number, "performed") for number in performed]
        return self._append([*confirmed, ("step", text_of(content))], pictures)

    def confirm(self, number: int, how: str) -> int:
        """Writes that the effects of a step, named by its number, were carried out; raises as `write` does."""
        return self._append([_confirmation(number, how)])

    def note(self, text: str, data: Any = None) -> int:
        """Writes something that a reader should know; raises as `write` does."""
        return self._append([("note", text_of({"text": text, "data": to_json(data)}))])

    def __enter__(self) -> Journal:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the writing; doing so twice changes nothing.

        While a row waits for a disk that hangs, the file is left to the end of the process.
        """
        if not self._alone.acquire(timeout=CLOSE_S):
            return
        try:
            if self._open:
                self._open = False
                self._close_files()
                self._lock.release()
        finally:
            self._alone.release()

    @property
    def is_at_rest(self) -> bool:
        """Whether the journal's files are closed until the next row."""
        return self._database is None

    def rest(self) -> None:
        """Close the files until the next row, unless one is being written; the lock stays, so no one else writes."""
        if not self._alone.acquire(blocking=False):
            return
        try:
            OPEN.closed(self)
            if self._database is not None:
                database, self._database, self._is_wide = self._database, None, False
                with suppress(SqliteError):
                    self._end_opening(database)
                close_to_rest(database, self._place)
        finally:
            self._alone.release()

    def _close_files(self) -> None:
        OPEN.closed(self)
        if self._database is not None:
            with suppress(SqliteError):  # a disk that is full or gone: the rows are in the log, which reading knows
                self._end_opening(self._database)
                self._database.close()
        elif self._lock.is_of(self._place):
            end_rest(self._place)

    def _opened(self) -> Connection:
        """The files, open.

        Raises:
            ConnectorError: What has the name now is not what this journal has written.
        """
        if self._database is not None:
            return self._database
        OPEN.make_room(len(Lock.held))
        if not self._lock.is_of(self._place):
            raise ConnectorError(f"the journal {self.path} cannot be written: another file has its name, or none")
        database = open_again(self._place)
        try:
            last = database.execute(LAST).fetchone() or (-1, GENESIS)
            if last != (self._number, self._hash):
                raise ConnectorError(f"the journal {self.path} cannot be written: its rows were altered meanwhile")
        except BaseException:
            database.close()
            raise
        self._database, self._is_new_log = database, True
        OPEN.opened(self)
        return database

    def _end_opening(self, database: Connection) -> None:
        if self._is_new_log:
            self._is_new_log = False
            end_of_opening(database)

    def _append(self, contents: Iterable[tuple[str, str]], pictures: Mapping[str, Image] = {}) -> int:
        """Write rows, all or none, and give the number of the last.

        Args:
            contents: Of each its kind and its content.
            pictures: What comes with the last, by SHA-256.
        """
        blobs = tuple(
            (name, media_type(image.encoding, image.width, image.height), image.data)
            for name, image in pictures.items()
        )
        with self._alone:
            number, digest, rows = self._number, self._hash, list[Raw]()
            for kind, text in contents:
                number += 1
                digest = chained(digest, number, kind, text)
                rows.append((number, kind, text, digest))
            statement = ROW + MORE * (len(rows) - 1)
            lost = f"row {number} is lost" if len(rows) == 1 else f"rows {rows[0][0]} to {number} are lost"
            self._run([*((BLOB, blob) for blob in blobs), (statement, [*chain(*rows)])], lost)
            self._number, self._hash = number, digest
            if number >= self._looks_at:
                self._look_at_size(number)
            if self._witness is not None:
                self._witness(tuple(rows), blobs)
        return number

    def _look_at_size(self, number: int) -> None:
        """A run that is left alone for days, or cannot end, is not to fill a disk unnoticed."""
        self._looks_at = number + LOOK_ROWS
        with suppress(OSError):  # it has no name any more, which is no reason to lose a row
            size = self._place.stat().st_size
            if size >= self._mark:
                log.warning("the journal %s has %d MB; it grows as long as the run lasts", self.path, size // 10**6)
                self._mark = _mark_above(size)

    def _run(self, statements: list[tuple[str, Sequence[Any]]], lost: str) -> None:
        """All or nothing; a single statement is a transaction by itself."""
        if not self._open:
            raise UsageError(f"the journal {self.path} is closed; open it again to write")
        database: Connection | None = None
        try:
            database = self._opened()
            if not self._is_wide and any(statement is BLOB for statement, _ in statements):
                self._is_wide = True
                widen(database)
            if len(statements) > 1:
                database.execute("BEGIN")
            for statement, values in statements:
                database.execute(statement, values)
            if len(statements) > 1:
                database.execute("COMMIT")
            self._end_opening(database)
        except SqliteError as error:
            with suppress(SqliteError):
                if database is not None:
                    database.rollback()
            why = out_of_files() or error
            raise ConnectorError(f"the journal {self.path} cannot be written: {why}; {lost}") from error
        self.written = time.monotonic()


def _mark_above(size: int) -> int:
    """The next size at which a journal is mentioned."""
    mark = FIRST_MARK
    while mark <= size:
        mark *= 10
    return mark


def _filled(header: Header) -> Header:
    return header._replace(
        run=header.run or uuid.uuid4().hex,
        started=header.started or datetime.datetime.now(datetime.UTC).isoformat(timespec="milliseconds"),
        versions=versions() | dict(header.versions),
    )


def _confirmation(number: int, how: str) -> tuple[str, str]:
    """Kind and content of the row that reports what became of a step's effects."""
    return "confirmation", text_of({"number": number, "how": how})


def _digest(image: Image, pictures: dict[str, Image]) -> str:
    try:
        digest = image.digest
    except Exception:  # noqa: BLE001 - every reader meets the same fault; the step is not lost for a picture
        return ""
    pictures[digest] = image
    return digest
