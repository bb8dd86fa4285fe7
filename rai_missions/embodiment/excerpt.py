# SPDX-License-Identifier: Apache-2.0
"""The part of a passage that answers a question: its sentences around the one that has most of the question's terms."""

from __future__ import annotations

import re
from collections.abc import Sequence
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
    score: int
    """Of its best sentence: 2 for each term of the question that is in it, 1 for one in another form."""


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
    terms = [spellings(term) for term in key_terms(question)]
    scores = [_score(sentence, terms) for sentence in each]
    first = last = scores.index(max(scores))
    while last + 1 < len(each) and len(" ".join(each[first : last + 2])) <= longest:
        last += 1
    while first and len(" ".join(each[first - 1 : last + 1])) <= longest:
        first -= 1
    shown = " ".join(each[first : last + 1])
    is_cut = len(shown) > longest or last + 1 < len(each)
    begin, end = "… " if first else "", " …" if is_cut else ""
    return Excerpt(f"{begin}{shown[:longest].rstrip()}{end}", max(scores))


def _score(sentence: str, terms: Sequence[Sequence[str]]) -> int:
    """The score of a sentence, by the spellings of each term."""
    words = frozenset(word.casefold() for word in WORD.findall(sentence))
    exact = sum(any(form.casefold() in words for form in forms) for forms in terms)
    return exact + sum(any(word.startswith(_stem(form)) for word in words for form in forms) for forms in terms)


def _stem(word: str) -> str:
    return word.casefold()[: max(SHORTEST_STEM, len(word) - ENDING)]
