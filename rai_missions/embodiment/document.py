# SPDX-License-Identifier: Apache-2.0
"""A document as text under headings, and how a reader puts one together.

Rule: what a person does not see on the page is no text: control characters and characters without width are dropped.
"""

from __future__ import annotations

import re
import unicodedata
from typing import NamedTuple

from rai_missions.redaction import cut

__all__ = ("Outline", "Section", "TextDocument", "visible")

LONGEST_TEXT = 2_000_000
"""Characters of a document."""
MOST_SECTIONS = 5_000
LONGEST_HEADING = 200
LEVELS = 6
IGNORABLE = re.compile("[\u034f\u115f\u1160\u17b4\u17b5\u180b-\u180f\u3164\ufe00-\ufe0f\uffa0\U000e0100-\U000e01ef]")
"""Letters and marks that no font draws: what Unicode has as Default_Ignorable_Code_Point outside category C."""


class Section(NamedTuple):
    """A part of a document under one heading."""

    heading: tuple[str, ...]
    """The headings above it, the outermost first; empty ahead of the first one."""
    text: str
    """Its paragraphs, with an empty line between them."""


class TextDocument(NamedTuple):
    """A document that was read."""

    title: str
    """Its own title; empty where it has none."""
    sections: tuple[Section, ...]


class Outline:
    """Collects headings and paragraphs in the order of a document.

    Args:
        title: The document's own title, where it is known.
    """

    def __init__(self, title: str = "") -> None:
        self.title = _short(title)
        self._above: list[tuple[int, str]] = []
        self._paragraphs: list[str] = []
        self._sections: list[Section] = []
        self._length = 0

    def heading(self, level: int, text: str) -> None:
        """Begin a section; a heading without text is none.

        Raises:
            ValueError: The document has too many sections.
        """
        name = _short(text)
        if not name:
            return
        self._end_section()
        depth = max(1, min(level, LEVELS))
        self._above = [(each, above) for each, above in self._above if each < depth] + [(depth, name)]

    def paragraph(self, text: str) -> None:
        """Add a paragraph, on one line.

        Raises:
            ValueError: The document is too long.
        """
        if shown := visible(text):
            self._length += len(shown)
            if self._length > LONGEST_TEXT:
                raise ValueError(f"holds more than {LONGEST_TEXT} characters of text; split it")
            self._paragraphs.append(shown)

    def document(self) -> TextDocument:
        """All that was collected.

        Raises:
            ValueError: There is no text at all.
        """
        self._end_section()
        if not self._sections:
            raise ValueError("holds no text; a scanned page needs text recognition (OCR) first")
        return TextDocument(self.title or next(iter(self._sections[0].heading), ""), tuple(self._sections))

    def _end_section(self) -> None:
        if self._paragraphs:
            self._sections.append(Section(tuple(name for _, name in self._above), "\n\n".join(self._paragraphs)))
            self._paragraphs = []
        if len(self._sections) > MOST_SECTIONS:
            raise ValueError(f"has more than {MOST_SECTIONS} sections; split it")


def _short(heading: str) -> str:
    name = visible(heading)
    return name if len(name) <= LONGEST_HEADING else cut(name, LONGEST_HEADING)


def visible(text: str) -> str:
    """A text on one line, as a person sees it."""
    drawn = IGNORABLE.sub("", text)
    shown = "".join(_shown(character) for character in drawn) if not text.isprintable() or not text.isascii() else text
    return " ".join(shown.split())


def _shown(character: str) -> str:
    kind = unicodedata.category(character)
    if kind in ("Zs", "Zl", "Zp") or character in "\t\n\r\f\v":
        return " "
    return "" if kind[0] == "C" else character
