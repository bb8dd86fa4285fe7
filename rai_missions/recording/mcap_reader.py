# SPDX-License-Identifier: Apache-2.0
"""The file that is read: the one place that knows mcap's reader.

Rule: a file is read record by record and never by its index, which a killed process has not written.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator
from pathlib import Path
from typing import IO, Any

import zstandard
from mcap.exceptions import EndOfFile
from mcap.records import Attachment, Channel, Chunk, DataEnd, Message, Metadata
from mcap.stream_reader import StreamReader, breakup_chunk

from rai_missions.errors import DefinitionError, Fault
from rai_missions.journal import Blob, Raw, copied
from rai_missions.recording.encoder import JOURNAL_TOPIC
from rai_missions.recording.file import MAGIC
from rai_missions.recording.recording import FORMAT
from rai_missions.redaction import cut_repr

__all__ = ("restore",)

HEAD = struct.Struct("<BQ")
"""How each record begins: what it is, and how many bytes follow."""
MOST_BYTES = 256 << 20
"""No record that a recording writes is longer."""
MOST_ROWS_BYTES, ROWS_RATIO = 1 << 30, 100
"""What the journal in a recording may hold: so much, or so many times the recording's own bytes, if that is more.

Each of its rows brings a hash, which cannot be packed.
"""
MOST_UNPACKED, UNPACKED_RATIO = 4 << 30, 2_000
"""What a recording may unpack to, as above."""


def restore(path: Path, journal: Path) -> str:
    """Write the journal that a recording holds, and state what a reader should know of it.

    Raises:
        DefinitionError: It is no recording of a run, or it is damaged.
    """
    seen = _FilePass(path)
    copied(journal, seen.parts(), str(path))
    if not seen.is_ours:
        what = "an MCAP file, but no recording of a mission" if seen.is_mcap else "no MCAP file"
        raise DefinitionError([Fault("", f"{what}; give one that `rai-missions run --record` has written")], str(path))
    if seen.is_whole:
        return ""
    if not seen.rows:
        raise DefinitionError([Fault("", "the recording is cut off before the first row of its journal")], str(path))
    return f"{path} is cut off: its recording was killed or the disk was full; it is read up to row {seen.rows - 1}"


class _FilePass:
    """One reading of a file, from its beginning to its end or to where it was cut off."""

    def __init__(self, path: Path) -> None:
        self._path = path
        self.is_mcap = self.is_ours = self.is_whole = False
        self.rows = 0
        self._journal: set[int] = set()
        self._room = 0
        """Bytes that the journal may still take."""

    def parts(self) -> Iterator[Raw | Blob]:
        """The journal's rows and pictures."""
        with self._path.open("rb") as file:
            end = _whole_until(file)
            self.is_mcap, self._room = end > 0, max(MOST_ROWS_BYTES, ROWS_RATIO * end)
            try:
                yield from self._read(file, end)
            except DefinitionError:
                raise
            except Exception as fault:  # noqa: BLE001 - whatever mcap and its decompressors raise on bytes that are none
                raise self._damaged(file.tell(), fault) from None

    def _read(self, file: IO[bytes], end: int) -> Iterator[Raw | Blob]:
        if not end:
            return
        file.seek(0)
        for record in _records(file, end):
            if isinstance(record, Metadata) and record.name == "rai_missions":
                self._know(record.metadata)
            elif isinstance(record, Channel) and record.topic == JOURNAL_TOPIC:
                self._journal.add(record.id)
            elif isinstance(record, Attachment) and self.is_ours:
                yield record.name, record.media_type, record.data
            elif isinstance(record, Message) and record.channel_id in self._journal:
                yield self._row(record.data)
            elif isinstance(record, DataEnd):
                self.is_whole = True
                return

    def _know(self, words: dict[str, str]) -> None:
        if (number := words.get("format")) != FORMAT:
            sentence = f"a recording of format {number}; this program reads format {FORMAT}"
            raise DefinitionError([Fault("", sentence)], str(self._path))
        self.is_ours = True

    def _row(self, data: bytes) -> Raw:
        self._room -= len(data)
        if self._room < 0:
            raise ValueError("it unpacks to a journal that is far larger than a recording of its size holds")
        row = json.loads(data)
        number, *texts = (row[name] for name in ("row", "kind", "content", "hash"))
        if type(number) is not int or not all(isinstance(text, str) for text in texts):
            raise ValueError("a row of its journal is none")
        self.rows = max(self.rows, number + 1)
        return number, texts[0], texts[1], texts[2]

    def _damaged(self, at: int, fault: Exception) -> DefinitionError:
        sentence = f"the recording is damaged before byte {at}: {str(fault) or type(fault).__name__}"
        return DefinitionError([Fault("", sentence)], str(self._path))


class _Whole:
    """A file as far as its records are whole."""

    def __init__(self, file: IO[bytes], end: int) -> None:
        self._file, self._end = file, end

    @property
    def is_read(self) -> bool:
        return self._file.tell() >= self._end

    def read(self, size: int) -> bytes:
        return self._file.read(min(size, self._end - self._file.tell()))


def _records(file: IO[bytes], end: int) -> Iterator[Any]:
    """The records before `end`, which is where one ends; chunks are checked and opened."""
    whole, left = _Whole(file, end), max(MOST_UNPACKED, UNPACKED_RATIO * end)
    reader: Any = StreamReader(whole, emit_chunks=True, validate_crcs=True, record_size_limit=MOST_BYTES)
    try:
        for record in reader.records:
            if isinstance(record, Chunk):
                left -= _checked_size(record)
                if left < 0:
                    raise ValueError("it unpacks to far more than a recording of its size holds")
                yield from breakup_chunk(record, validate_crc=True)
            else:
                yield record
    except EndOfFile:
        if not whole.is_read:
            raise


def _checked_size(chunk: Chunk) -> int:
    """A few bytes can be packed so that they fill the memory: the size that they claim is checked first.

    Returns:
        How many bytes are in it.

    Raises:
        ValueError: It is too much, or a packing that no recording has.
    """
    if chunk.compression not in ("", "zstd"):
        raise ValueError(f"a chunk is packed with {cut_repr(chunk.compression, 20)}; recordings are packed with zstd")
    sizes: list[int] = [chunk.uncompressed_size]
    if chunk.compression:
        sizes.append(zstandard.frame_content_size(chunk.data))
    if max(sizes) > MOST_BYTES:
        raise ValueError(f"a chunk of {max(sizes)} bytes; the most are {MOST_BYTES}")
    return max(sizes)


def _whole_until(file: IO[bytes]) -> int:
    """Where the last whole record ends; 0 if it is no MCAP file."""
    if file.read(len(MAGIC)) != MAGIC:
        return 0
    at, size = len(MAGIC), os.fstat(file.fileno()).st_size
    while at + HEAD.size <= size:
        file.seek(at)
        _, length = HEAD.unpack(file.read(HEAD.size))
        if at + HEAD.size + length > size:
            break
        at += HEAD.size + length
    return at
