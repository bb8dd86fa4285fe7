# SPDX-License-Identifier: Apache-2.0
"""A document cut into passages of one heading each, short enough to be quoted and long enough to be understood."""

from __future__ import annotations

import re
from collections.abc import Iterator

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
        for text in _packed(redacted(section.text)):
            yield DocumentPassage(name, " › ".join(section.heading), text)


def _packed(text: str) -> Iterator[str]:
    """Pieces put together as long as they fit."""
    kept = ""
    for piece in _pieces(text):
        if kept and len(kept) + len(piece) + 1 > LONGEST_PASSAGE:
            yield kept
            kept = ""
        kept = f"{kept}\n{piece}" if kept else piece
    if kept:
        yield kept


def _pieces(text: str) -> Iterator[str]:
    """Paragraphs; of one that is too long its sentences, several as long as they fit."""
    for paragraph in text.split("\n\n"):
        if len(paragraph) <= LONGEST_PASSAGE:
            yield paragraph
            continue
        kept = ""
        for sentence in SENTENCE_END.split(paragraph):
            if kept and len(kept) + len(sentence) + 1 > LONGEST_PASSAGE:
                yield kept
                kept = ""
            kept = f"{kept} {sentence}" if kept else sentence
            *full, kept = _divided(kept)
            yield from full
        yield kept


def _divided(text: str) -> list[str]:
    """A text without an end of a sentence, between its words."""
    if len(text) <= LONGEST_SENTENCE:
        return [text]
    words, lines = text.split(" "), [""]
    for word in words:
        for part in WORD_PART.findall(word):
            if lines[-1] and len(lines[-1]) + len(part) + 1 > LONGEST_SENTENCE:
                lines.append("")
            lines[-1] = f"{lines[-1]} {part}" if lines[-1] else part
    return lines
