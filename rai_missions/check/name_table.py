# SPDX-License-Identifier: Apache-2.0
"""The names there are of one sort, and which of them an unknown one was meant to be."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

from rai_missions.errors import suggestion

__all__ = ("NameTable",)

GUESSES = 40
"""Unknown names of a sort that are compared with all known ones; more take long with ten thousand states."""


class NameTable:
    """The names of one sort.

    Args:
        sort: What they name, in a word: `state`, `key`.
        known: The names.
        remedy: What to do where there is none at all: `declare it under /events`.
    """

    def __init__(self, sort: str, known: Iterable[str], remedy: str = "") -> None:
        self.sort, self.known, self.remedy = sort, dict.fromkeys(known), remedy
        self._guesses: dict[str, str | None] = {}

    def __contains__(self, name: object) -> bool:
        return name in self.known

    def meant(self, given: str) -> str | None:
        """The name itself if there is one, else the known one that it resembles."""
        if given in self.known:
            return given
        if given not in self._guesses:
            if len(self._guesses) >= GUESSES:
                return None
            close = difflib.get_close_matches(given, self.known, n=1, cutoff=0.6)
            self._guesses[given] = close[0] if close else None
        return self._guesses[given]

    def missing(self, given: str) -> str:
        """The sentence on a name that there is not."""
        meant = self.meant(given)
        if meant is not None:
            return f"no {self.sort} '{given}'; did you mean '{meant}'?"
        if self.known and given in self._guesses:
            return f"no {self.sort} '{given}'{suggestion(given, self.known)}"
        return f"no {self.sort} '{given}'" + (f"; {self.remedy}" if self.remedy else "")
