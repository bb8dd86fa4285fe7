# SPDX-License-Identifier: Apache-2.0
"""How much a sentence sounds like a claim: a linear score of its words, with weights that were learned.

The weights are a logistic regression over sentences of people and of models (`scripts/claim_weights.py`). A sentence is
its features: runs of up to three words, and of three and four letters within a word; its form, which is runs of two to
five words, of which each that is not frequent is its last letters alone; and each two of its frequent words. So a
sentence about unknown things has the form of others: `you can … your … now`. Each feature counts by its rarity, the
logarithm of the share of sentences without it (inverse document frequency), so that rare words decide more.
Rule: the same sentence has the same score everywhere; nothing is learned while a robot runs.
"""

from __future__ import annotations

import json
import math
import re
from collections.abc import Container, Iterable, Iterator, Mapping, Sequence
from functools import cache
from itertools import combinations
from pathlib import Path
from typing import NamedTuple

__all__ = (
    "FOLDER",
    "FREQUENT",
    "MOST_IN_DOUBT",
    "MOST_OF_CLAUSE",
    "MOST_OF_KNOWN",
    "ClaimWeights",
    "claim_weights",
    "features",
    "words_of",
)

FOLDER = Path(__file__).parent / "claim_weights"
MOST, MOST_OF_KNOWN = -1.0, 3.0
"""Above these scores a sentence is a claim even where the rules find nothing. An ability and a sentence of the world
sound like claims: `I can carry boxes to the barn`, `the sea is deep`.
"""
MOST_OF_CLAUSE = 1.0
"""Above this score a clause by itself is a claim, where the rules doubt the sentence."""
MOST_IN_DOUBT = 0.0
"""Above this score such a clause is a claim where the rules doubt the clause itself: more like claims than not."""
LEAST_KNOWN = 0.5
"""The share of a sentence's words that are known of a language; with no more than this it is of another one."""
FREQUENT = 300
"""The words of a language that its forms have whole: the first of those that are known."""
WORDS, FORM = (1, 2, 3), (2, 3, 4, 5)
LETTERS = (3, 4)
ENDING = 2
"""Letters of a word that is not frequent, in a form."""
MOST_PAIRED = 14
"""Frequent words and signs of a sentence that are paired."""
CAPITALS = re.compile(r"(?<=\s)[A-ZÄÖÜ]\w+")
"""Names, and German nouns, of which a language has no end; not the first word."""
TOKEN = re.compile(r"[^\W\d_]+(?:['’][^\W\d_]+)?|\d+(?:[.,]\d+)*|[?!.,;:%]")


class ClaimWeights(NamedTuple):
    """What a language's features weigh."""

    weights: Mapping[str, tuple[int, int]]
    """Of each feature its weight times its rarity, and its rarity, both in the same parts of one."""
    known: frozenset[str]
    """The language's words."""
    frequent: frozenset[str]
    """The words that a form has whole."""
    least: float
    """Up to this score a sentence that the rules doubt is no claim; what is unknown scores 0 or so."""
    learned_from: str
    """The SHA-256 of the sentences that it was learned from."""

    def score(self, text: str) -> float:
        """How much a sentence sounds like a claim; the more, the higher.

        Args:
            text: The sentence, without marks of layout.
        """
        known = [self.weights[each] for each in features(text, self.frequent) if each in self.weights]
        return sum(weight for weight, _ in known) / (math.hypot(*(rarity for _, rarity in known)) or 1)

    def is_language_of(self, text: str) -> bool:
        """Whether a sentence is of the language: more than half of its words are known.

        Args:
            text: The sentence, without marks of layout.
        """
        words = [each for each in words_of(CAPITALS.sub("", text)) if each[0].isalpha()]
        return sum(each in self.known for each in words) > LEAST_KNOWN * len(words)

    def is_claim(self, text: str, *, is_known: bool = False) -> bool:
        """Whether a sentence scores as a claim even where the rules find nothing.

        Args:
            text: The sentence, without marks of layout.
            is_known: Whether it states what the robot can do, or is of the world.
        """
        return self.score(text) > (MOST_OF_KNOWN if is_known else MOST)

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
        return ClaimWeights({}, frozenset(), frozenset(), -math.inf, "")
    content = json.loads(file.read_text(encoding="utf-8"))
    words = content.pop("words")
    return ClaimWeights(**content, known=frozenset(words), frequent=frozenset(words[:FREQUENT]))


def features(text: str, frequent: Container[str]) -> frozenset[str]:
    """What a sentence is to a score; a number is `#`.

    Args:
        text: The sentence.
        frequent: Words that its form has whole.

    Returns:
        Runs of words begin with `w`, those of its form with `s`, of letters with `c`, pairs of frequent words with `p`.
    """
    tokens = TOKEN.findall(text.replace("’", "'"))
    words = [_word(each) for each in tokens]
    form = [_form(each, frequent, is_first=not at) for at, each in enumerate(tokens)]
    paired = combinations([each for each in form if each[0] not in "-N,"][:MOST_PAIRED], 2)
    return frozenset(
        (
            *_runs_of_words("w", words, WORDS),
            *_runs_of_words("s", form, FORM),
            *_runs_of_letters(words),
            *(f"p{first} {second}" for first, second in paired),
        )
    )


def words_of(text: str) -> list[str]:
    """The words, numbers and signs of a text, each number as `#`."""
    return [_word(each) for each in TOKEN.findall(text.replace("’", "'"))]


def _word(token: str) -> str:
    return "#" if token[0].isdigit() else token.lower()


def _form(token: str, frequent: Container[str], *, is_first: bool) -> str:
    """A frequent word or a sign as it is, a name or noun as `N`, any other word as its last letters."""
    word = _word(token)
    if word in frequent or not word[0].isalpha():
        return word
    return "N" if token[0].isupper() and not (is_first or token.isupper()) else f"-{word[-ENDING:]}"


def _runs_of_words(mark: str, words: Sequence[str], lengths: Sequence[int]) -> Iterator[str]:
    bounded = ["^", *words, "$"]
    for length in lengths:
        for at in range(len(bounded) - length + 1):
            yield f"{mark}{' '.join(bounded[at : at + length])}"


def _runs_of_letters(words: Sequence[str]) -> Iterator[str]:
    for word in words:
        bounded = f"^{word}$"
        for length in LETTERS:
            for at in range(len(bounded) - length + 1):
                yield f"c{bounded[at : at + length]}"
