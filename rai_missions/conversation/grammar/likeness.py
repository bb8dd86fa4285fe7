# SPDX-License-Identifier: Apache-2.0
"""How like a sentence is to examples: by the words that they share, or by whatever else a program brings.

Rule: a likeness only ranks what is offered; nothing is ordered by it.
"""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from functools import lru_cache
from typing import NamedTuple, Protocol

__all__ = ("Likeness", "WordLikeness")

BEGINNING = 4
"""Letters of a word that count."""
MOST_TABLES = 64
"""Sets of examples whose words are remembered."""


class Likeness(Protocol):
    """Compares a sentence with examples."""

    def scores(self, text: str, examples: Sequence[str]) -> Sequence[float]:
        """The likeness to each example: from 0.5 on they are about the same, and 1 is equal."""


class WordTable(NamedTuple):
    """The words of examples, each with its rarity."""

    rarity: dict[str, float]
    bags: tuple[frozenset[str], ...]


class WordLikeness:
    """The words that two texts share, each by its rarity: the cosine of both."""

    def scores(self, text: str, examples: Sequence[str]) -> Sequence[float]:
        """As `Likeness`."""
        table = _table(tuple(examples))
        words = _bag(text)
        own = math.sqrt(sum(table.rarity.get(word, 1.0) ** 2 for word in words))
        return [_cosine(words & bag, bag, own, table.rarity) for bag in table.bags]


def _cosine(shared: frozenset[str], bag: frozenset[str], own: float, rarity: dict[str, float]) -> float:
    size = math.sqrt(sum(rarity[word] ** 2 for word in bag))
    return sum(rarity[word] ** 2 for word in shared) / (own * size) if shared and size else 0.0


def _bag(text: str) -> frozenset[str]:
    """The beginnings of the words, which most forms of a word share."""
    return frozenset(word[:BEGINNING] for word in text.split())


@lru_cache(maxsize=MOST_TABLES)
def _table(examples: tuple[str, ...]) -> WordTable:
    bags = tuple(_bag(each) for each in examples)
    count = Counter(word for bag in bags for word in bag)
    rarity = {word: math.log(1.0 + len(bags) / often) for word, often in count.items()}
    most = max(rarity.values(), default=1.0)
    return WordTable({word: each / most for word, each in rarity.items()}, bags)
