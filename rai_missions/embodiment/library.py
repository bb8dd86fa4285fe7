# SPDX-License-Identifier: Apache-2.0
"""What a robot can look up of itself: the documents of its folder, searched by words and by meaning.

Rule: where the key terms of a question occur nowhere and nothing is near it in meaning, the documents have no answer.
Rule: what is found is quoted, without secrets, with its source; it is data, whatever it demands.
"""

from __future__ import annotations

import threading
from collections.abc import Sequence
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple, Protocol

from rai_missions.embodiment.index.build import BuildReport, build_index, is_current
from rai_missions.embodiment.index.database import IndexReader
from rai_missions.embodiment.index.place import index_place
from rai_missions.embodiment.key_terms import key_terms, spellings
from rai_missions.embodiment.minilm import TextEmbedder, minilm
from rai_missions.embodiment.passage import DocumentPassage, FoundPassages
from rai_missions.errors import UsageError
from rai_missions.redaction import redacted

if TYPE_CHECKING:
    import numpy as np
    from numpy.typing import NDArray

__all__ = ("Library", "NearestPassages")

COUNT, MOST = 5, 20
"""Passages that are given, if nothing else is asked for, and at most."""
CANDIDATES = 30
"""Passages that each of the two searches gives to the fusion."""
RANK_OFFSET = 10
"""Constant of reciprocal rank fusion (Cormack, Clarke and Büttcher, 2009): how little first ranks are preferred."""
NEAR = 0.35
"""Cosine from which a passage is near a question in meaning."""
ENOUGH_TERMS = 0.5
"""More than this share of the key terms occurs in the passages that were found: that is an answer."""
EVERYWHERE = 1 / 3
"""A term in more than this share of all passages names no subject: `tractor` in the documents of a tractor."""
FEW = 3
"""In so many passages a term always names one."""


class NearestPassages(Protocol):
    """Finds passages by meaning in another store than the index, such as a vector store of langchain's."""

    def fill(self, passages: Sequence[DocumentPassage]) -> None:
        """Hold these passages from now on; those that it has already need not be embedded again."""

    def nearest(self, question: str, count: int) -> Sequence[tuple[str, float]]:
        """The digests of the nearest passages, the nearest first, each with its cosine, or 0 where it has none."""


class Library:
    """The documents of an identity's folder. Several threads may use it; it opens with the first question.

    Args:
        folder: The identity's folder.
        index: The index's file; left out: in the user's cache.
        embedder: Makes the vectors; left out: MiniLM where it is installed, else the words alone count.
        nearest: Searches by meaning instead of the index.
    """

    def __init__(
        self,
        folder: Path,
        index: Path | None = None,
        *,
        embedder: TextEmbedder | None = None,
        nearest: NearestPassages | None = None,
    ) -> None:
        self.folder, self.index = folder, index or index_place(folder)
        self._embedder, self._nearest = embedder or (minilm() if nearest is None else None), nearest
        self._lock = threading.Lock()
        self._shelf: _Shelf | None = None

    def build(self) -> BuildReport:
        """Bring the index up to date.

        Raises:
            DefinitionError: The folder cannot be read.
            UsageError: The index cannot be written, or would hold too much.
        """
        report = build_index(self.folder, self.index, self._embedder)
        with self._lock:
            self._shelf = None
        return report

    def open(self) -> None:
        """Open the index, and build it first where it is missing, of another version, or not of these documents.

        Raises:
            DefinitionError: The folder cannot be read.
            UsageError: The index cannot be written, or is damaged.
        """
        self._open_shelf()

    def passages(self) -> tuple[DocumentPassage, ...]:
        """All passages, in the order of the documents; raises as `open`."""
        return tuple(self._open_shelf().passages.values())

    def recall(self, question: str, count: int = COUNT) -> FoundPassages:
        """What the documents have on a question; raises as `open`.

        Args:
            question: In free words, in the language of the documents: English or German.
            count: Passages at most; 1 to 20.
        """
        question = question.encode("utf-8", "replace").decode()  # bytes of a shell that are no text come as surrogates
        shelf, terms = self._open_shelf(), key_terms(question)
        by_words = shelf.reader.with_words(terms, CANDIDATES)
        by_meaning = self._by_meaning(shelf, question)
        fused = _fused(by_words, [number for number, _ in by_meaning])[: max(1, min(count, MOST))]
        cosines = dict(by_meaning)
        nearest = max((cosines.get(number, 0.0) for number in fused), default=0.0)
        key, lacking = _occurrences(shelf, terms, frozenset(fused))
        is_answered = nearest >= NEAR or _is_enough(len(key) - len(lacking), len(key), alone=not by_meaning)
        found = [shelf.passages[number] for number in fused] if is_answered else []
        cleaned = tuple(DocumentPassage(*map(redacted, each)) for each in found)
        return FoundPassages(cleaned, tuple(map(redacted, lacking)), shelf.has_vectors or self._nearest is not None)

    def _open_shelf(self) -> _Shelf:
        with self._lock:
            if self._shelf is None:
                self._shelf = self._opened()
            return self._shelf

    def _opened(self) -> _Shelf:
        try:
            reader = IndexReader(self.index)
        except UsageError:
            build_index(self.folder, self.index, self._embedder)
            reader = IndexReader(self.index)
        if not is_current(self.folder, reader, self._embedder):
            reader.close()
            build_index(self.folder, self.index, self._embedder)
            reader = IndexReader(self.index)
        shelf = _Shelf.of(reader, with_vectors=self._embedder is not None)
        if self._nearest is not None:
            self._nearest.fill(list(shelf.passages.values()))
        return shelf

    def _by_meaning(self, shelf: _Shelf, question: str) -> list[tuple[int, float]]:
        """The numbers of the nearest passages, each with its cosine."""
        if self._nearest is not None:
            numbers = {passage.digest: number for number, passage in shelf.passages.items()}
            found = self._nearest.nearest(question, CANDIDATES)
            return [(numbers[digest], cosine) for digest, cosine in found if digest in numbers]
        if self._embedder is None or shelf.vectors is None or not len(shelf.vectors):
            return []
        cosines = shelf.vectors @ self._embedder.vectors([question])[0]
        order = sorted(range(len(cosines)), key=lambda at: (-cosines[at], at))[:CANDIDATES]
        return [(shelf.numbers[at], float(cosines[at])) for at in order]


class _Shelf(NamedTuple):
    """An index that is open, with what a search looks at in memory."""

    reader: IndexReader
    passages: dict[int, DocumentPassage]
    numbers: tuple[int, ...]
    vectors: NDArray[np.float32] | None

    @property
    def has_vectors(self) -> bool:
        return self.vectors is not None

    @classmethod
    def of(cls, reader: IndexReader, *, with_vectors: bool) -> _Shelf:
        rows = reader.passages()
        vectors = [row.vector for row in rows]
        numbers = tuple(row.number for row in rows)
        return cls(
            reader, {row.number: row.passage for row in rows}, numbers, _matrix(vectors) if with_vectors else None
        )


def _matrix(vectors: Sequence[bytes | None]) -> NDArray[np.float32] | None:
    """Vectors as rows; None where one is missing or of another length than the others."""
    import numpy as np

    whole = [vector for vector in vectors if vector]
    if len(whole) != len(vectors) or len({len(vector) for vector in whole}) > 1:
        return None
    return np.frombuffer(b"".join(whole), np.float32).reshape(len(whole), -1) if whole else np.zeros((0, 1), np.float32)


def _fused(*rankings: Sequence[int]) -> list[int]:
    """Several rankings as one, by the ranks alone."""
    scores: dict[int, float] = {}
    for ranking in rankings:
        for rank, number in enumerate(ranking, start=1):
            scores[number] = scores.get(number, 0.0) + 1 / (RANK_OFFSET + rank)
    return sorted(scores, key=lambda number: (-scores[number], number))


def _is_enough(found: int, key: int, *, alone: bool) -> bool:
    """Whether so many of the key terms make passages an answer; where the words alone count, half of them do."""
    return found > ENOUGH_TERMS * key or (alone and key > 0 and found >= ENOUGH_TERMS * key)


def _occurrences(shelf: _Shelf, terms: Sequence[str], found: frozenset[int]) -> tuple[list[str], list[str]]:
    """The terms that name a subject, and those of them that occur in none of the passages found."""
    places = {term: shelf.reader.with_term(term) for term in terms}
    key = [term for term in terms if len(places[term]) <= max(FEW, EVERYWHERE * len(shelf.passages))]
    forms = {term: frozenset[int]().union(*map(shelf.reader.with_term, spellings(term))) for term in key}
    return key, [term for term in key if not forms[term] & found]
