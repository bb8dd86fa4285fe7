# SPDX-License-Identifier: Apache-2.0
"""Exchanges from symbols: `red and blue`, `red with blue`, and more pairs in the same wish."""

from __future__ import annotations

from rai_missions.planning.reading.noun_phrases import Cursor, noun_phrases
from rai_missions.planning.reading.phrases import Clause, Phrase

__all__ = ("swaps",)


def swaps(cursor: Cursor, subjects: tuple[Phrase, ...]) -> list[Clause]:
    """The exchanges that begin with these things: `swap red with blue, and green with yellow`.

    Args:
        cursor: Past the things.
        subjects: Both, or the first of them.
    """
    if not cursor.skip("with", "for"):
        return [Clause("swap", subjects)]
    found = [Clause("swap", subjects + noun_phrases(cursor, most=1))]
    begun = cursor.at
    while cursor.skip(",", "and", "then"):
        one = noun_phrases(cursor, most=1)
        other = noun_phrases(cursor, most=1) if one and cursor.skip("with", "for") else ()
        if not other:
            break
        found.append(Clause("swap", one + other))
        begun = cursor.at
    cursor.back_to(begun)
    return found
