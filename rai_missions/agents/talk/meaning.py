# SPDX-License-Identifier: Apache-2.0
"""The likeness of sentences by their meaning, as vectors; by their words until the vectors of the examples are made.

Rule: a dialogue waits for one sentence's vector at most; those of the examples are made on a thread of their own. The
program's end waits for one of these: a thread that comes back from onnxruntime after it aborts the process.
"""

from __future__ import annotations

import weakref
from collections.abc import Sequence
from threading import Event
from typing import Any

from rai_missions.connectors.worker import Worker
from rai_missions.conversation.grammar.likeness import Likeness, WordLikeness
from rai_missions.embodiment.minilm import TextEmbedder, minilm

__all__ = ("MeaningLikeness", "likeness_in")

SCALE = 0.5 / 0.55
"""From a cosine of 0.55 on two sentences are about the same, which is 0.5 of a likeness."""
MOST_VECTORS = 10_000
"""Examples whose vectors are remembered; the options of each question bring new ones."""
LANGUAGE = "en"
"""The language of the sentences that MiniLM was trained with."""


class MeaningLikeness:
    """Compares sentences by their vectors, as a `Likeness`.

    Args:
        embedder: Makes the vectors.
    """

    def __init__(self, embedder: TextEmbedder) -> None:
        self._embedder, self._words, self._worker = embedder, WordLikeness(), Worker("meaning", limit=1)
        self._vectors: dict[str, Any] = {}
        self._is_ending = Event()
        weakref.finalize(self, _end, self._is_ending, self._worker)

    def scores(self, text: str, examples: Sequence[str]) -> Sequence[float]:
        """As `Likeness`."""
        vectors = self._vectors
        new = [each for each in dict.fromkeys(examples) if each not in vectors]
        if new:
            self._worker.post(lambda: self._learn(new))
            return self._words.scores(text, examples)
        own = self._embedder.vectors([text])[0]
        return [SCALE * float(vectors[each] @ own) for each in examples]

    def close(self, within_s: float | None = None) -> None:
        """Make no more vectors of examples, once those that were begun are made."""
        self._worker.close(within_s)

    def _learn(self, examples: Sequence[str]) -> None:
        made = dict[str, Any]()
        for each in examples:
            if self._is_ending.is_set():
                return
            made[each] = self._embedder.vectors([each])[0]
        kept = self._vectors if len(self._vectors) + len(made) <= MOST_VECTORS else {}
        self._vectors = kept | made


def _end(is_ending: Event, worker: Worker) -> None:
    """What is done as the program ends, or the likeness is forgotten."""
    is_ending.set()
    worker.close()


def likeness_in(language: str) -> Likeness:
    """By meaning where MiniLM is installed and knows the language, else by words."""
    model = minilm() if language == LANGUAGE else None
    return WordLikeness() if model is None else MeaningLikeness(model)
