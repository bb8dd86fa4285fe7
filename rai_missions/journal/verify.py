# SPDX-License-Identifier: Apache-2.0
"""Whether a journal is the one that was written: every fault at once, each with its row.

Rule: no one reads a journal whose chain is broken; a run that is half believed is worse than none.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from rai_missions.errors import DefinitionError, Fault
from rai_missions.image import media_type
from rai_missions.journal.json_values import pictures_in
from rai_missions.journal.reader import Record
from rai_missions.journal.rows import GENESIS, JournalRow, Raw, StepRow, chained
from rai_missions.journal.sqlite_reader import NoJournal, Unbegun
from rai_missions.redaction import cut_repr

__all__ = ("checked", "opened", "read", "verify")

MOST_FAULTS = 100


def read(path: Path | str) -> Record:
    """Open a journal and verify its chain of hashes; neither the file nor its folder is changed.

    Raises:
        UsageError: There is no such file, or it may not be read.
        DefinitionError: It is no journal, or it was altered: every fault with its row.
    """
    record = Record(path)
    faults = _collected(_chain_faults(record))
    if faults:
        is_empty = next(record.raw(), None) is None
        record.close()
        raise (Unbegun if is_empty else DefinitionError)(faults, str(path))
    return record


def opened(path: Path | str) -> Record:
    """Open a journal and verify its row 0; `checked` verifies the rest.

    Raises:
        UsageError: There is no such file, or it may not be read.
        DefinitionError: It is no journal, or its row 0 is not what was written: every fault with its row.
    """
    record = Record(path)
    first = next(record.raw(), None)
    if first is None or first[0] != 0 or _altered(first, GENESIS):
        faults = _collected(_chain_faults(record))
        record.close()
        raise (Unbegun if first is None else DefinitionError)(faults, str(path))
    return record


def checked(record: Record) -> Iterator[JournalRow]:
    """The rows of a journal that was opened, not read: each is verified before it is given.

    Raises:
        DefinitionError: The chain does not hold: every fault with its row.
    """
    expected, before = 0, GENESIS
    for raw in record.raw():
        if raw[0] != expected or _altered(raw, before):
            break
        if expected:
            yield record.row(raw)
        expected, before = expected + 1, raw[3]
    else:
        if expected:
            return
    raise DefinitionError(_collected(_chain_faults(record)), str(record.path))


def verify(path: Path | str) -> tuple[Fault, ...]:
    """All that is wrong with a journal: its chain, rows that hold no value, steps out of order, pictures, the file.

    Raises:
        UsageError: There is no such file, or it may not be read.
        DefinitionError: It is no journal of this format.
    """
    try:
        record = Record(path)
    except NoJournal:
        raise
    except DefinitionError as error:
        return error.faults
    with record:
        return _collected(_all_faults(record))


def _all_faults(record: Record) -> Iterator[Fault]:
    yield from _chain_faults(record)
    yield from _row_faults(record)
    yield from _blob_faults(record)
    for sentence in record.damage():
        yield Fault("", f"the file is damaged: {sentence}")


def _chain_faults(record: Record) -> Iterator[Fault]:
    expected, before = 0, GENESIS
    for raw in record.raw():
        number = raw[0]
        if number != expected:
            yield Fault(f"row {expected}", f"missing: row {number} comes next; rows were taken out after the run")
        elif sentence := _altered(raw, before):
            yield Fault(f"row {number}", f"{sentence}; the journal was altered after the run")
        if number == 0:
            yield from _header_faults(record)
        expected, before = number + 1, str(raw[3])
    if expected == 0:
        yield Fault("row 0", "missing: the journal is empty, as of a process that died making it; start a new run")


def _altered(raw: Raw, before: str) -> str:
    number, kind, content, digest = raw
    if not (isinstance(kind, str) and isinstance(content, str) and isinstance(digest, str)):
        return "its parts are not text"
    if chained(before, number, kind, content) != digest:
        return f"its hash '{digest:.12}…' is not that of its content and the row before"
    return ""


def _header_faults(record: Record) -> tuple[Fault, ...]:
    try:
        _ = record.header
    except DefinitionError as error:
        return error.faults
    return ()


def _row_faults(record: Record) -> Iterator[Fault]:
    seq = 0
    for raw in record.raw():
        try:
            row = record.row(raw) if raw[0] else None
        except DefinitionError as error:
            yield from error.faults
            continue
        if isinstance(row, StepRow):
            if row.step.seq <= seq:
                yield Fault(f"row {row.row}", f"step {row.step.seq} comes after step {seq}; the numbers of steps grow")
            seq = row.step.seq


def _blob_faults(record: Record) -> Iterator[Fault]:
    shown, kept = _shown(record), set[str]()
    for digest, kind, _ in record.pictures():
        kept.add(digest)
        try:
            record.blob(digest)
        except DefinitionError as error:
            yield from error.faults
        if digest in shown and kind not in shown[digest].types:
            row, types = shown[digest]
            sentence = f"it is kept as {cut_repr(kind, 80)}, and row {row} has it as {sorted(types)[0]!r}"
            yield Fault(f"picture {digest:.12}…", f"{sentence}; the journal was altered after the run")
    for digest in sorted(shown.keys() - kept):
        sentence = f"row {shown[digest].row} has it, and its bytes are missing; they were taken out after the run"
        yield Fault(f"picture {digest:.12}…", sentence)


class StoredPicture(NamedTuple):
    """A picture whose bytes a journal keeps, as its rows state."""

    row: int
    """The first that has it."""
    types: set[str]
    """As what, by the rows that have it."""


def _shown(record: Record) -> dict[str, StoredPicture]:
    """Hash → a picture that a question has shown; a row that cannot be read is a fault of its own."""
    found: dict[str, StoredPicture] = {}
    for number, _, content, _ in record.raw():
        if not isinstance(content, str) or "sha256" not in content:
            continue
        with suppress(ValueError, KeyError, TypeError, RecursionError):
            for picture in pictures_in(json.loads(content)):
                kind = media_type(picture["encoding"], picture["width"], picture["height"])
                found.setdefault(str(picture["sha256"]), StoredPicture(number, set())).types.add(kind)
    return found


def _collected(faults: Iterator[Fault]) -> tuple[Fault, ...]:
    """The faults as far as they can be found, in a bounded number."""
    found: list[Fault] = []
    try:
        for fault in faults:
            found.append(fault)
            if len(found) == MOST_FAULTS:
                found.append(Fault("", f"there are more faults; these are the first {MOST_FAULTS}"))
                break
    except DefinitionError as error:
        found += error.faults
    return tuple(found)
