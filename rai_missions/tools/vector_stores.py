# SPDX-License-Identifier: Apache-2.0
"""A robot's documents in langchain's forms: a retriever, a vector store to read, and a search in any other store."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import TYPE_CHECKING, Any

from langchain_core.callbacks import CallbackManagerForRetrieverRun
from langchain_core.documents import Document
from langchain_core.embeddings import Embeddings
from langchain_core.retrievers import BaseRetriever
from langchain_core.vectorstores import VectorStore

from rai_missions.embodiment.library import Library
from rai_missions.embodiment.minilm import MiniLM
from rai_missions.embodiment.passage import DocumentPassage
from rai_missions.errors import UsageError

if TYPE_CHECKING:
    from rai_missions.embodiment.minilm import TextEmbedder

__all__ = ("LibraryRetriever", "LibraryVectorStore", "PassageStore", "TextEmbeddings")

MOST_SEARCHED = 2_000
"""Entries of another store that are looked at for one question, where others than ours come first."""
FIXED = "the passages come from the identity's folder: change its documents, and build the index again"


def as_document(passage: DocumentPassage) -> Document:
    """A passage as langchain has it; `metadata` cites it."""
    about = {"source": passage.source, "file": passage.file, "heading": passage.heading}
    return Document(passage.text, id=passage.digest, metadata=about)


class LibraryRetriever(BaseRetriever):
    """Retrieves what a robot's documents have on a question; nothing where they have no answer."""

    library: Any
    """A `Library`."""
    count: int = 5

    def _get_relevant_documents(self, query: str, *, run_manager: CallbackManagerForRetrieverRun) -> list[Document]:
        return [as_document(each) for each in self.library.recall(query, self.count).passages]


class LibraryVectorStore(VectorStore):
    """A robot's documents as a vector store that is read; what has no answer gives no document.

    Args:
        library: The documents.
    """

    def __init__(self, library: Library) -> None:
        self._library = library

    def similarity_search(self, query: str, k: int = 5, **kwargs: Any) -> list[Document]:
        """The passages on a question, the best first; at most 20."""
        return [as_document(each) for each in self._library.recall(query, k).passages]

    def get_by_ids(self, ids: Sequence[str], /) -> list[Document]:
        """The passages of these digests, those that there are."""
        wanted = set(ids)
        return [as_document(each) for each in self._library.passages() if each.digest in wanted]

    def add_texts(
        self,
        texts: Iterable[str],
        metadatas: list[dict[str, Any]] | None = None,
        *,
        ids: list[str] | None = None,
        **kwargs: Any,
    ) -> list[str]:
        """Raises `UsageError`: the documents are files."""
        raise UsageError(FIXED)

    @classmethod
    def from_texts(
        cls, texts: list[str], embedding: Embeddings, metadatas: list[dict[str, Any]] | None = None, **kwargs: Any
    ) -> LibraryVectorStore:
        """Raises `UsageError`: the documents are files."""
        raise UsageError(FIXED)


class PassageStore:
    """Any vector store of langchain's, searched instead of the index's vectors: the `nearest` of a `Library`.

    Args:
        store: Takes texts with ids; passages that it has already are not added again.
        cosine: The store's own score as a cosine, by which a question may have an answer whose words it does not
            share; left out: the words alone decide that.
    """

    def __init__(self, store: VectorStore, cosine: Callable[[float], float] | None = None) -> None:
        self._store, self._cosine = store, cosine
        self._held = frozenset[str]()

    def fill(self, passages: Sequence[DocumentPassage]) -> None:
        """As `NearestPassages`."""
        by_digest = {each.digest: each for each in passages}
        known = {each.id for each in self._store.get_by_ids(list(by_digest))}
        self._held = frozenset(by_digest)
        fresh = [each for digest, each in by_digest.items() if digest not in known]
        if fresh:
            documents = [as_document(each) for each in fresh]
            self._store.add_documents(documents, ids=[each.digest for each in fresh])

    def nearest(self, question: str, count: int) -> Sequence[tuple[str, float]]:
        """As `NearestPassages`; what else the store holds is passed over by its digest, however near it is."""
        wanted = count
        while True:
            every = self._searched(question, wanted)
            found = [each for each in every if each[0] in self._held]
            if len(found) >= min(count, len(self._held)) or len(every) < wanted or wanted >= MOST_SEARCHED:
                return found[:count]
            wanted *= 4

    def _searched(self, question: str, count: int) -> list[tuple[str, float]]:
        if self._cosine is None:
            return [(each.id or "", 0.0) for each in self._store.similarity_search(question, k=count)]
        found = self._store.similarity_search_with_score(question, k=count)
        return [(each.id or "", self._cosine(score)) for each, score in found]


class TextEmbeddings(Embeddings):
    """The vectors of this project for langchain's stores.

    Args:
        embedder: What makes them; left out: MiniLM.

    Raises:
        UsageError: A part of MiniLM is not installed; states what to install.
    """

    def __init__(self, embedder: TextEmbedder | None = None) -> None:
        self._embedder = embedder or MiniLM()

    def embed_documents(self, texts: list[str]) -> list[list[float]]:
        """A vector of length one for each text."""
        return [[float(each) for each in row] for row in self._embedder.vectors(texts)]

    def embed_query(self, text: str) -> list[float]:
        """The vector of a question."""
        return self.embed_documents([text])[0]
