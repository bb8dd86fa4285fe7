# SPDX-License-Identifier: Apache-2.0
"""The wishes of a request, from its symbols: as they are, with the commas that speech leaves out, or several to choose.

Rule: where `or` is between whole wishes, a person chooses; none of them is read together with another.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import suppress

from rai_missions.planning.reading.grammar import clauses
from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.phrases import Clause, Unread
from rai_missions.planning.reading.symbols import Symbol

__all__ = ("wishes_of",)

AFTER: Mapping[str, frozenset[str]] = {
    "noun": frozenset({"the", "a", "any", "all", "colour", "noun", "put", "grasp"}),
    "colour": frozenset({"the", "a", "any", "all", "colour"}),
}
"""Kinds of symbols that end a phrase about a thing → those that begin another one, or a wish."""

Way = tuple[Sequence[Symbol], tuple[Clause, ...]]
"""The symbols of one of the wishes that are offered for choice, and their clauses."""


def wishes_of(found: Sequence[Symbol], words: Vocabulary) -> Iterator[Way]:
    """The clauses; where they are none as they are, those of words without a comma, as they are spoken, or several.

    Several are whole wishes with an `or` between them: `red on blue or green on yellow`.
    """
    try:
        yield found, _listed_wishes(found, words)
    except Unread:
        parts = _alternatives(found, words)
        if not parts:
            raise
        yield from parts


def _listed_wishes(found: Sequence[Symbol], words: Vocabulary) -> tuple[Clause, ...]:
    try:
        return clauses(found, words)
    except Unread:
        listed = list(_with_commas(found))
        if len(listed) == len(found):
            raise
        return clauses(listed, words)


def _alternatives(found: Sequence[Symbol], words: Vocabulary) -> list[Way]:
    """The wishes before and after the first `or` on both sides of which there are whole ones; empty where none is."""
    for at, symbol in enumerate(found):
        if symbol.kind == "or":
            with suppress(Unread):
                before = found[:at]
                return [(before, _listed_wishes(before, words)), *wishes_of(found[at + 1 :], words)]
    return []


def _with_commas(found: Sequence[Symbol]) -> Iterator[Symbol]:
    """A comma between two things that follow each other, and before the verb after one: `red blue green`."""
    for at, symbol in enumerate(found):
        after = AFTER.get(found[at - 1].kind, frozenset()) if at else frozenset[str]()
        if symbol.kind in after:
            yield Symbol(",", None, ",")
        yield symbol
