# SPDX-License-Identifier: Apache-2.0
"""How much a sentence sounds like a claim: a linear score of its words, with weights that were learned.

The weights are a logistic regression over sentences of people and of models (`scripts/claim_weights.py`). A sentence is
its features: runs of up to three words, and of three and four letters within a word. Each counts by its rarity, the
logarithm of the share of sentences without it (inverse document frequency), so that rare words decide more.
Rule: the same sentence has the same score everywhere; nothing is learned while a robot runs.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import NamedTuple

__all__ = ("FOLDER", "MOST_IN_DOUBT", "MOST_OF_CLAUSE", "ClaimWeights", "claim_weights", "features")

FOLDER = Path(__file__).parent / "claim_weights"
MOST, MOST_OF_ABILITY = 0.5, 1.5
"""Above these scores a sentence is a claim even where the rules find nothing. An ability sounds like
a claim: `I can carry boxes to the barn`.
"""
MOST_OF_CLAUSE = 1.0
"""Above this score a clause by itself is a claim, where the rules doubt the sentence."""
MOST_IN_DOUBT = 0.0
"""Above this score such a clause is a claim where the rules doubt the clause itself: more like claims than not."""
LEAST_WORDS, LEAST_LETTERS = 1 / 3, 0.8
"""Shares of a sentence's words, and of its runs of letters, that are known of a language; with fewer of both it is of
another one.
"""
MOST_WORDS = 3
LETTERS = (3, 4)
CAPITALS = re.compile(r"(?<=\s)[A-ZÄÖÜ]\w+")
"""Names, and German nouns, of which a language has no end; not the first word."""
TOKEN = re.compile(r"[^\W\d_]+(?:['’][^\W\d_]+)?|\d+(?:[.,]\d+)*|[?!.,;:%]")


class ClaimWeights(NamedTuple):
    """What a language's features weigh."""

    weights: Mapping[str, tuple[int, int]]
    """Of each feature its weight times its rarity, and its rarity, both in the same parts of one."""
    least: float
    """Up to this score a sentence that the rules doubt is no claim; what is unknown scores 0 or so."""
    learned_from: str
    """The SHA-256 of the sentences that it was learned from."""

    def score(self, text: str) -> float:
        """How much a sentence sounds like a claim; the more, the higher.

        Args:
            text: The sentence, without marks of layout.
        """
        known = [self.weights[each] for each in features(text) if each in self.weights]
        return sum(weight for weight, _ in known) / (math.hypot(*(rarity for _, rarity in known)) or 1)

    def is_language_of(self, text: str) -> bool:
        """Whether a sentence is of the language: enough of its words, or of its runs of letters, are known.

        Args:
            text: The sentence, without marks of layout.
        """
        words = _words(CAPITALS.sub("", text))
        names = [f"w{each}" for each in words if each[0].isalpha()]
        return self._share(names) > LEAST_WORDS or self._share(set(_runs_of_letters(words))) >= LEAST_LETTERS

    def _share(self, names: Collection[str]) -> float:
        return sum(each in self.weights for each in names) / max(len(names), 1)

    def is_claim(self, text: str, *, is_ability: bool = False) -> bool:
        """Whether a sentence scores as a claim even where the rules find nothing.

        Args:
            text: The sentence, without marks of layout.
            is_ability: Whether it states what the robot can do.
        """
        return self.score(text) > (MOST_OF_ABILITY if is_ability else MOST)

    def is_harmless(self, text: str, clauses: Iterable[str]) -> bool:
        """Whether a sentence that the rules doubt scores as no claim, and none of its clauses by itself as one.

        Args:
            text: The sentence, without marks of layout.
            clauses: What it is made of: harmless words do not cover a claim among them.
        """
        return self.score(text) <= self.least and not any(self.score(each) > MOST_OF_CLAUSE for each in clauses)


@cache
def claim_weights(code: str) -> ClaimWeights:
    """The weights of a language, by its code; one without a file knows no word, so each doubt is a claim."""
    file = FOLDER / f"{code}.json"
    if not file.exists():
        return ClaimWeights({}, -math.inf, "")
    return ClaimWeights(**json.loads(file.read_text(encoding="utf-8")))


def features(text: str) -> frozenset[str]:
    """What a sentence is to a score: a run of words begins with `w`, one of letters with `c`; a number is `#`."""
    words = _words(text)
    return frozenset((*_runs_of_words(["^", *words, "$"]), *_runs_of_letters(words)))


def _words(text: str) -> list[str]:
    """The words, numbers and signs of a text, each number as `#`."""
    return ["#" if each[0].isdigit() else each for each in TOKEN.findall(text.lower().replace("’", "'"))]


def _runs_of_words(words: Sequence[str]) -> Iterator[str]:
    for length in range(1, MOST_WORDS + 1):
        for at in range(len(words) - length + 1):
            yield f"w{' '.join(words[at : at + length])}"


def _runs_of_letters(words: Sequence[str]) -> Iterator[str]:
    for word in words:
        bounded = f"^{word}$"
        for length in LETTERS:
            for at in range(len(bounded) - length + 1):
                yield f"c{bounded[at : at + length]}"
