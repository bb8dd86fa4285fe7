# SPDX-License-Identifier: Apache-2.0
"""An index is built from a folder: what has not changed since the last time is neither read nor embedded again.

Rule: a document that cannot be read is reported and left out; all others are in the index.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import NamedTuple

from rai_missions.embodiment.chunks import passages_of
from rai_missions.embodiment.folder import PICTURES, IdentityFolder
from rai_missions.embodiment.index.database import IndexedDocument, IndexedPassage, IndexReader, write_index
from rai_missions.embodiment.minilm import TextEmbedder
from rai_missions.embodiment.passage import DocumentPassage
from rai_missions.embodiment.readers import FORMATS
from rai_missions.embodiment.reading_process import ReadingProcess
from rai_missions.errors import Fault, UsageError
from rai_missions.redaction import Redaction

__all__ = ("BuildReport", "build_index", "is_current")

MOST_DOCUMENTS = 200
MOST_PASSAGES = 20_000
"""Passages of all documents together: a search looks at the vectors of all of them."""


class BuildReport(NamedTuple):
    """What a build did."""

    documents: int
    passages: int
    read: tuple[str, ...]
    """The documents that were read now, new or changed, and are in the index."""
    embedded: int
    """Passages whose vectors were made."""
    faults: tuple[Fault, ...]
    """The documents that are not in the index, each with its remedy."""
    has_vectors: bool
    others: tuple[str, ...]
    """Files of formats that are no documents, but for pictures."""


def build_index(folder: Path, path: Path, embedder: TextEmbedder | None) -> BuildReport:
    """Bring the index of a folder's documents up to date.

    Args:
        folder: The identity's folder.
        path: The index.
        embedder: Makes the vectors; None: full text only.

    Raises:
        DefinitionError: The folder cannot be read.
        UsageError: The index cannot be written, or holds too much.
    """
    files = _opened(folder)
    name = embedder.name if embedder is not None else ""
    earlier, is_same = _earlier(path, name)
    found: list[IndexedDocument] = []
    kept: dict[str, Sequence[tuple[DocumentPassage, bytes | None]]] = {}
    read: list[str] = []
    with ReadingProcess() as process:
        for file in files.files:
            document = earlier[file][0] if file in earlier else None
            if document is None or document.fault or document.sha256 != _digest_of(files, file):
                document, kept[file] = _read(files, file, process)
                if not document.fault:
                    read.append(file)
            else:
                kept[file] = earlier[file][1]
            found.append(document)
    rows = [each for passages in kept.values() for each in passages]
    if len(rows) > MOST_PASSAGES:
        raise UsageError(
            f"the documents have {len(rows)} passages; at most {MOST_PASSAGES} are searched: leave some out"
        )
    known = {each: vector for _, passages in earlier.values() for each, vector in passages if vector and is_same}
    vectors, count = _vectors([passage for passage, _ in rows], embedder, known)
    numbered = [
        IndexedPassage(at, row[0], vector) for at, (row, vector) in enumerate(zip(rows, vectors, strict=True), 1)
    ]
    write_index(path, {"embedder": name}, found, numbered)
    faults = tuple(Fault(f"/{each.name}", each.fault) for each in found if each.fault)
    others = tuple(each for each in files.others if not each.lower().endswith(PICTURES))
    return BuildReport(len(found) - len(faults), len(rows), tuple(read), count, faults, embedder is not None, others)


def is_current(folder: Path, reader: IndexReader, embedder: TextEmbedder | None) -> bool:
    """Whether an index holds the documents of a folder as they are now, with the vectors that this machine can make."""
    files = _opened(folder)
    if embedder is not None and reader.about().get("embedder") != embedder.name:
        return False
    known = {each.name: each.sha256 for each in reader.documents()}
    return known == {file: _digest_of(files, file) for file in files.files}


def _opened(folder: Path) -> IdentityFolder:
    return IdentityFolder(
        folder, {ending: each.largest for ending, each in FORMATS.items()}, most=MOST_DOCUMENTS, inner=True
    )


Known = Mapping[str, tuple[IndexedDocument, Sequence[tuple[DocumentPassage, bytes | None]]]]


def _earlier(path: Path, embedder: str) -> tuple[Known, bool]:
    """What the last build knew, by document, and whether its vectors are still of use."""
    try:
        with IndexReader(path) as reader:
            known = {
                each.name: (each, tuple((row.passage, row.vector) for row in reader.passages(each.name)))
                for each in reader.documents()
            }
            return known, bool(embedder) and reader.about().get("embedder") == embedder
    except UsageError:
        return {}, False


def _read(
    files: IdentityFolder, file: str, process: ReadingProcess
) -> tuple[IndexedDocument, Sequence[tuple[DocumentPassage, bytes | None]]]:
    digest = ""
    try:
        data = files.data(file)
        digest = _digest(data)
        document = process.read(file, data)
    except ValueError as error:
        return IndexedDocument(file, digest, "", str(error)), ()
    return IndexedDocument(file, digest, document.title, ""), tuple(
        (each, None) for each in passages_of(file, document)
    )


def _digest_of(files: IdentityFolder, file: str) -> str:
    """The digest of a file of the folder; empty for one that cannot be read, as in the index."""
    try:
        return _digest(files.data(file))
    except ValueError:
        return ""


def _digest(data: bytes) -> str:
    """The digest of a document without known secrets: once one in it becomes known, the document is read again."""
    with suppress(UnicodeDecodeError):  # a format that is no text, or a fault that the reader reports
        data = Redaction().known(data.decode()).encode()
    return hashlib.sha256(data).hexdigest()


def _vectors(
    passages: Sequence[DocumentPassage], embedder: TextEmbedder | None, known: Mapping[DocumentPassage, bytes]
) -> tuple[list[bytes | None], int]:
    """A vector for each passage, and how many of them were made now."""
    if embedder is None:
        return [None for _ in passages], 0
    fresh = [each for each in dict.fromkeys(passages) if each not in known]
    made = embedder.vectors([f"{each.heading}\n{each.text}" for each in fresh])
    whole = {**known, **{each: vector.tobytes() for each, vector in zip(fresh, made, strict=True)}}
    return [whole[each] for each in passages], len(fresh)
