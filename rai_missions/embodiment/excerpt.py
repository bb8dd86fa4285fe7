# SPDX-License-Identifier: Apache-2.0
"""The part of a passage that answers a question: its sentences around the one that has most of the question's terms."""

from __future__ import annotations

import re
from typing import NamedTuple

from rai_missions.embodiment.key_terms import key_terms, spellings

__all__ = ("Excerpt", "excerpt")

SENTENCE = re.compile(r"(?<=[.!?])\s+|\n+")
WORD = re.compile(r"[^\W_]+")
LONGEST = 220
"""Characters of an excerpt; a longer sentence is cut."""
SHORTEST_STEM, ENDING = 4, 3
"""Two words are forms of one if they begin alike, but for an ending of so many letters."""


class Excerpt(NamedTuple):
    """A part of a passage, word for word."""

    text: str
    """With `…` where something was left out."""
    terms: int
    """How many of the question's terms it has."""


def excerpt(text: str, question: str, longest: int = LONGEST) -> Excerpt:
    """The sentences of a text that answer a question best.

    Args:
        text: A passage.
        question: In free words.
        longest: Characters at most, without the marks of what was left out.
    """
    each = [sentence for sentence in SENTENCE.split(text.strip()) if sentence]
    if not each:
        return Excerpt("", 0)
    stems = [[_stem(word) for word in spellings(term)] for term in key_terms(question)]
    counts = [_count(sentence, stems) for sentence in each]
    first = last = counts.index(max(counts))
    while last + 1 < len(each) and len(" ".join(each[first : last + 2])) <= longest:
        last += 1
    while first and len(" ".join(each[first - 1 : last + 1])) <= longest:
        first -= 1
    shown = " ".join(each[first : last + 1])
    is_cut = len(shown) > longest or last + 1 < len(each)
    begin, end = "… " if first else "", " …" if is_cut else ""
    return Excerpt(f"{begin}{shown[:longest].rstrip()}{end}", max(counts))


def _count(sentence: str, stems: list[list[str]]) -> int:
    """How many of the terms a sentence has."""
    words = [word.casefold() for word in WORD.findall(sentence)]
    return sum(any(word.startswith(stem) for word in words for stem in forms) for forms in stems)


def _stem(word: str) -> str:
    return word.casefold()[: max(SHORTEST_STEM, len(word) - ENDING)]
