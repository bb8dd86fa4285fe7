# SPDX-License-Identifier: Apache-2.0
"""A passage of a document, as it is found, quoted and cited."""

from __future__ import annotations

import hashlib
from typing import NamedTuple

from rai_missions.redaction import quotable

__all__ = ("DocumentPassage", "FoundPassages")


class DocumentPassage(NamedTuple):
    """A piece of a document under one heading."""

    file: str
    """The document, by its place in the identity's folder."""
    heading: str
    """Its headings, the outermost first, with ` › ` between them; empty ahead of the first one."""
    text: str

    @property
    def source(self) -> str:
        """How it is cited."""
        return f"{self.file}, {self.heading}" if self.heading else self.file

    @property
    def digest(self) -> str:
        """What the same passage has again, and no other."""
        return hashlib.sha256("\0".join(self).encode("utf-8", "replace")).hexdigest()


class FoundPassages(NamedTuple):
    """What documents have on a question."""

    passages: tuple[DocumentPassage, ...]
    """The best first; none where the documents have no answer."""
    lacking: tuple[str, ...] = ()
    """The key terms of the question that occur in none of the passages that were found."""
    is_by_meaning: bool = True
    """Whether vectors were used; else the words alone counted."""

    @property
    def is_answered(self) -> bool:
        """Whether the documents have anything on it."""
        return bool(self.passages)

    def words(self) -> str:
        """The answer in words: a line for each passage, quoted, with its source."""
        if not self.passages:
            return f"The documents have no answer{self._about()}."
        return "\n".join(
            f"{number}. {quotable(each.source)}: “{quotable(each.text)}”"
            for number, each in enumerate(self.passages, start=1)
        )

    def _about(self) -> str:
        return f": they have nothing about {', '.join(self.lacking)}" if self.lacking else ""
