# SPDX-License-Identifier: Apache-2.0
"""A document cut into passages of one heading each, short enough to be quoted and long enough to be understood."""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator

from rai_missions.embodiment.document import TextDocument
from rai_missions.embodiment.passage import DocumentPassage
from rai_missions.redaction import redacted

__all__ = ("passages_of",)

LONGEST_PASSAGE = 700
"""Characters of a passage, as near as sentences allow."""
LONGEST_SENTENCE = 1_400
"""A longer one is divided between words."""
WORD_PART = re.compile(rf".{{1,{LONGEST_SENTENCE}}}")
SENTENCE_END = re.compile(r"(?<=[.!?;:])\s+")


def passages_of(name: str, document: TextDocument) -> Iterator[DocumentPassage]:
    """The passages of a document, in its order. Secrets are hidden first: half of one would be known by no shape.

    Args:
        name: The document's file, as it is cited.
        document: What was read from it.
    """
    for section in document.sections:
        for text in _packed(_pieces(redacted(section.text)), "\n"):
            yield DocumentPassage(name, " › ".join(section.heading), text)


def _packed(pieces: Iterable[str], joint: str, longest: int = LONGEST_PASSAGE) -> Iterator[str]:
    """Pieces put together as long as they fit; one that is too long stays by itself."""
    kept = ""
    for piece in pieces:
        if kept and len(kept) + len(piece) + 1 > longest:
            yield kept
            kept = ""
        kept = f"{kept}{joint}{piece}" if kept else piece
    if kept:
        yield kept


def _pieces(text: str) -> Iterator[str]:
    """Paragraphs; of one that is too long its sentences, several as long as they fit."""
    for paragraph in text.split("\n\n"):
        if len(paragraph) <= LONGEST_PASSAGE:
            yield paragraph
        else:
            sentences = SENTENCE_END.split(paragraph)
            yield from _packed((part for sentence in sentences for part in _divided(sentence)), " ")


def _divided(text: str) -> Iterator[str]:
    """A text that is too long between its words, and a word that is too long anywhere."""
    words = (part for word in text.split(" ") for part in WORD_PART.findall(word))
    return _packed(words, " ", LONGEST_SENTENCE)
