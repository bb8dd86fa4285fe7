# SPDX-License-Identifier: Apache-2.0
"""A journal that is read.

Rule: what is read comes back as the values that were written, or as a `DefinitionError` that names the row.
"""

from __future__ import annotations

import hashlib
import math
import weakref
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, TypeVar

from rai_missions.engine.step import Step
from rai_missions.errors import DefinitionError, Fault, UsageError
from rai_missions.given import given_path
from rai_missions.journal.rows import Blob, Confirmation, Header, JournalRow, Note, Raw, StepRow, parsed, read_header
from rai_missions.journal.sqlite import SqliteError
from rai_missions.journal.sqlite_reader import open_to_read
from rai_missions.redaction import cut

__all__ = ("Record",)

Made = TypeVar("Made")
BAD = (ValueError, TypeError, KeyError, AttributeError, OverflowError, RecursionError)
"""What a row that is none raises on its way to a value."""


class Record:
    """What was in a journal when it was opened. A context manager.

    Made by `read`, which checks it first; opened by itself, nothing is known of it but that it is a journal.

    Raises:
        UsageError: There is no such file, or it may not be read.
        DefinitionError: It is no journal of this format.
    """

    def __init__(self, path: Path | str) -> None:
        self.path = given_path(path, "a journal")
        self._database = open_to_read(self.path)
        self._close = weakref.finalize(self, self._database.close)
        (pages,), (size,) = (next(self._found(f"PRAGMA {each}")) for each in ("page_count", "page_size"))
        self._size = pages * size

    @property
    def header(self) -> Header:
        """Row 0."""
        _, kind, content, _ = next(self.raw(), (0, "", "{}", ""))
        return self._made(0, "header", lambda: read_header(kind, content, self._fetch))

    @property
    def seal(self) -> str:
        """The hash of the last row. Noted elsewhere, it proves later that no row was taken away or added."""
        return next(
            (str(digest) for (digest,) in self._found("SELECT hash FROM rows ORDER BY number DESC LIMIT 1")), ""
        )

    @property
    def cut(self) -> int:
        """Bytes at its end that belong to a row which was not written whole; they are left out."""
        return self._database.cut

    def rows(self) -> Iterator[JournalRow]:
        """The steps, confirmations and notes, in the order in which they were written.

        Raises:
            DefinitionError: A row that is none of them.
        """
        return (self.row(raw) for raw in self.raw() if raw[0])

    def entries(self) -> Iterator[StepRow]:
        """The steps, each with what the engine knew right before: what a replay needs."""
        return (row for row in self.rows() if isinstance(row, StepRow))

    def steps(self) -> Iterator[Step]:
        """The steps, equal to those that were written."""
        return (row.step for row in self.entries())

    def confirmations(self) -> dict[int, str]:
        """Number of a step → how its effects were carried out; the last word counts."""
        return {row.number: row.how for row in self.rows() if isinstance(row, Confirmation)}

    def notes(self) -> tuple[Note, ...]:
        """The notes, in order."""
        notes = (self.row(raw) for raw in self.raw() if raw[1] == "note")
        return tuple(row for row in notes if isinstance(row, Note))

    def last(self) -> StepRow | None:
        """The last step; a run that was not cut short ended with its `outcome`."""
        found = next(self._found("SELECT * FROM rows WHERE kind = 'step' ORDER BY number DESC LIMIT 1"), None)
        row = self.row(found) if found else None
        return row if isinstance(row, StepRow) else None

    def raw(self, after: int | None = None) -> Iterator[Raw]:
        """Every row as it is, unread; those behind a number, where one is given."""
        where, numbers = ("", ()) if after is None else ("WHERE number > ?", (after,))
        query = f"SELECT number, kind, content, hash FROM rows {where} ORDER BY number"
        return self._once(self._found(query, *numbers), at=2)

    def row(self, raw: Raw) -> JournalRow:
        """A row's value.

        Raises:
            DefinitionError: It has none.
        """
        number, kind, content, _ = raw
        return self._made(number, kind, lambda: parsed(number, kind, content, self._fetch))

    def blob(self, digest: str) -> bytes:
        """The bytes of a SHA-256.

        Raises:
            UsageError: They are not kept here.
            DefinitionError: They are not what was kept.
        """
        found = next(self._found("SELECT bytes FROM blobs WHERE sha256 = ?", digest), None)
        if found is None:
            raise UsageError(f"the journal {self.path} holds no bytes with the hash '{digest}'")
        data = found[0]
        if not isinstance(data, bytes) or hashlib.sha256(data).hexdigest() != digest:
            sentence = "its bytes do not have the hash under which they are kept; the journal was altered after the run"
            raise DefinitionError([Fault(f"picture {digest:.12}…", sentence)], str(self.path))
        return data

    def blobs(self) -> Iterator[str]:
        """The hashes of the bytes that are kept."""
        for _, digest in self._once(self._found("SELECT rowid, sha256 FROM blobs ORDER BY rowid"), at=1):
            yield str(digest)

    def pictures(self) -> Iterator[Blob]:
        """The bytes that are kept, as they are in the file."""
        query = "SELECT rowid, bytes, sha256, media_type FROM blobs ORDER BY rowid"
        for _, data, digest, media_type in self._once(self._found(query), at=1):
            yield str(digest), str(media_type), data

    def damage(self) -> Iterator[str]:
        """What SQLite finds wrong with the file."""
        for (sentence,) in self._found("PRAGMA integrity_check(10)"):
            if sentence != "ok":
                yield str(sentence)

    def __enter__(self) -> Record:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    def close(self) -> None:
        """Ends the reading; the bytes of pictures that no one asked for are out of reach then."""
        self._close()

    def _found(self, query: str, *values: Any) -> Iterator[Any]:
        """The rows of a query.

        Raises:
            DefinitionError: The file is damaged where they are.
        """
        try:
            for row in self._database.execute(query, values):  # noqa: UP028 - `yield from` would close the cursor
                yield row
        except (SqliteError, UnicodeDecodeError) as error:
            sentence = f"the file is damaged, and cannot be read to its end: {cut(error, 200)}"
            raise DefinitionError([Fault("", sentence)], str(self.path)) from None

    def _once(self, rows: Iterator[Any], *, at: int) -> Iterator[Any]:
        """Rows whose numbers come first, each read once: a page of the file may be made to be in many places.

        Args:
            rows: By their numbers.
            at: Where in a row that is of which a file holds no more than it has bytes.

        Raises:
            DefinitionError: The file reports more than it holds.
        """
        left, before = self._size, -math.inf
        for row in rows:
            left -= len(row[at]) if isinstance(row[at], str | bytes) else 0
            if row[0] <= before or left < 0:
                sentence = (
                    "the file is damaged: a part of it is reported to be in several places; give a whole copy of it"
                )
                raise DefinitionError([Fault("", sentence)], str(self.path))
            before = row[0]
            yield row

    def _fetch(self, ref: str, digest: str) -> Callable[[], bytes]:
        def fetched() -> bytes:
            if not digest:
                raise UsageError(f"the journal {self.path} keeps pictures that a question showed, and not '{ref}'")
            return self.blob(digest)

        return fetched

    def _made(self, number: int, kind: Any, make: Callable[[], Made]) -> Made:
        try:
            return make()
        except BAD as error:
            fault = Fault(f"row {number}", f"no {cut(kind, 20)} can be read here: {cut(error, 200)}")
            raise DefinitionError([fault], str(self.path)) from None
