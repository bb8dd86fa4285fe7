# SPDX-License-Identifier: Apache-2.0
"""The likeness of sentences by their meaning, as vectors; by their words until the vectors of the examples are made.

Rule: a dialogue waits for one sentence's vector at most; those of the examples are made on a thread of their own.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from rai_missions.connectors.worker import Worker
from rai_missions.conversation.likeness import Likeness, WordLikeness
from rai_missions.embodiment.minilm import TextEmbedder, minilm

__all__ = ("MeaningLikeness", "likeness_in")

SCALE = 0.5 / 0.55
"""From a cosine of 0.55 on two sentences are about the same, which is 0.5 of a likeness."""
LANGUAGE = "en"
"""Of the sentences that MiniLM was trained with."""


class MeaningLikeness:
    """Compares sentences by their vectors, as a `Likeness`.

    Args:
        embedder: Makes the vectors.
    """

    def __init__(self, embedder: TextEmbedder) -> None:
        self._embedder, self._words, self._worker = embedder, WordLikeness(), Worker("meaning", limit=1)
        self._vectors: dict[str, Any] = {}

    def scores(self, text: str, examples: Sequence[str]) -> Sequence[float]:
        """As `Likeness`."""
        new = [each for each in dict.fromkeys(examples) if each not in self._vectors]
        if new:
            self._worker.post(lambda: self._learn(new))
            return self._words.scores(text, examples)
        own = self._embedder.vectors([text])[0]
        return [SCALE * float(self._vectors[each] @ own) for each in examples]

    def close(self, within_s: float | None = None) -> None:
        """Make no more vectors of examples, once those that were begun are made."""
        self._worker.close(within_s)

    def _learn(self, examples: Sequence[str]) -> None:
        self._vectors |= dict(zip(examples, self._embedder.vectors(examples), strict=True))


def likeness_in(language: str) -> Likeness:
    """By meaning where MiniLM is installed and knows the language, else by words."""
    model = minilm() if language == LANGUAGE else None
    return WordLikeness() if model is None else MeaningLikeness(model)
