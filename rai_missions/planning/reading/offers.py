# SPDX-License-Identifier: Apache-2.0
"""What is read of a request that is not read as a whole: without the words that are not known, or some of its parts.

Rule: it is offered for a person to confirm; a part that is left out changes nothing of the others.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

from rai_missions.planning.goal import Goal
from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.symbols import Symbol

__all__ = ("goals_of_rest", "is_offered")

MOST_PARTS = 6
"""Parts of a request of which some may be read without the others."""
OFFERED = frozenset({"unknown_word", "negated", "unread"})
"""Reasons to ask back after which an offer is made."""
NEVER = frozenset({"asked", "forbidden"})
"""Kinds of symbols with which no part of a request is offered."""
DIVIDING = (",", ".", "and", "then", ":")

Part = tuple[Symbol, ...]


def is_offered(reason: str, found: Sequence[Symbol], words: Vocabulary) -> bool:
    """Whether a part of a request may be offered.

    Not of a question, of what is forbidden, of signs of no language, or with a word that turns what it is about, such
    as `only` and `unless`.
    """
    unknown = [symbol.text for symbol in found if symbol.kind == "unknown"]
    is_plain = all(map(str.isalpha, unknown)) and words.turning.isdisjoint(unknown)
    return reason in OFFERED and is_plain and not any(symbol.kind in NEVER for symbol in found)


def goals_of_rest(
    found: Sequence[Symbol], words: Vocabulary, goals_of: Callable[[Sequence[Symbol]], tuple[Goal, ...]]
) -> tuple[Goal, ...]:
    """The goals of what is read of a request; none where that is nothing.

    Args:
        found: The symbols of the request.
        words: Of its language.
        goals_of: The goals that symbols may mean; none where they are not read.
    """
    for way in _ways(tuple(found), words):
        if goals := goals_of(way):
            return goals
    kept, waiting = Part(), Part()
    goals = tuple[Goal, ...]()
    for part in _parts(found):
        ways = (part, *_ways(part, words))
        for way in (*((*waiting, *each) for each in ways if waiting), *ways):
            if read := goals_of((*kept, *way)):
                kept, waiting, goals = (*kept, *way), Part(), read
                break
        else:
            waiting = (*waiting, *part)
    return goals


def _ways(part: Part, words: Vocabulary) -> Iterator[Part]:
    """A part with what its unknown words may be by one letter, then without them, and what is longest between them."""
    unknown = [at for at, symbol in enumerate(part) if symbol.kind == "unknown"]
    if not unknown:
        return
    yield tuple(_nearest(symbol, words) for symbol in part)
    if words.cutting.isdisjoint(part[at].text for at in unknown):
        yield tuple(symbol for symbol in part if symbol.kind != "unknown")
    between = [part[begun + 1 : end] for begun, end in pairwise([-1, *unknown, len(part)])]
    yield max(between, key=len)


def _nearest(symbol: Symbol, words: Vocabulary) -> Symbol:
    sense = words.nearest(symbol.text) if symbol.kind == "unknown" else None
    return Symbol(sense.kind, sense.value, symbol.text) if sense is not None else symbol


def _parts(found: Sequence[Symbol]) -> list[Part]:
    """The symbols between the signs that may divide wishes, each part with the sign before it; none of too many."""
    starts = [0, *(at for at, symbol in enumerate(found) if at and symbol.kind in DIVIDING), len(found)]
    parts = [tuple(found[begun:end]) for begun, end in pairwise(starts)]
    return parts if len(parts) <= MOST_PARTS else []
