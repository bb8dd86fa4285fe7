# SPDX-License-Identifier: Apache-2.0
"""What is read of a request that is not read as a whole: without the words that are not known, or some of its parts.

Rule: it is offered for a person to confirm, and lacks no thing and no place that the request names.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

from rai_missions.planning.goal import Goal
from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.symbols import DIVIDING, Symbol, kind_at, up_to

__all__ = ("goals_of_rest", "is_offered")

MOST_PARTS = 6
"""Parts of a request of which some may be read without the others."""
OFFERED = frozenset({"unknown_word", "negated", "unread"})
"""Reasons to ask back after which an offer is made."""
NEVER = frozenset({"asked", "forbidden"})
"""Kinds of symbols with which no part of a request is offered."""
ASKING = frozenset({
    "noun", "colour", "relation", "each_other", "level", "rank", "everything", "rest", "stack", "left_to_right",
})  # fmt: skip
"""Kinds of symbols without which an offer would lack something of the request."""

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
        words: The words of its language.
        goals_of: The goals that symbols may mean; none where they are not read.
    """
    for way in _complete(tuple(found), words):
        if goals := goals_of(way):
            return goals
    kept, waiting = Part(), Part()
    goals = tuple[Goal, ...]()
    for part in _parts(found):
        ways = [part, *_complete(part, words)]
        joined = [(*waiting, *each) for each in ways] if waiting else []
        for at, way in enumerate((*joined, *ways)):
            if read := goals_of((*kept, *way)):
                if at >= len(joined) and _lacks(waiting, ()):
                    return ()
                kept, waiting, goals = (*kept, *way), Part(), read
                break
        else:
            waiting = (*waiting, *part)
    return () if _lacks(waiting, ()) else goals


def _complete(part: Part, words: Vocabulary) -> Iterator[Part]:
    """The ways to read a part of which none lacks a thing or a place."""
    yield from (way for way in _ways(part, words) if not _lacks(part, way))


def _lacks(part: Part, way: Part) -> bool:
    """Whether words about things and places are left out of a part; what is negated may be left out."""
    if any(symbol.kind == "no" for symbol in part):
        return False
    asked, kept = (Counter(each.kind for each in every if each.kind in ASKING) for every in (part, way))
    left_out = any(each.kind == "unknown" for each in part) and not any(each.kind == "unknown" for each in way)
    return bool(asked - kept) or (left_out and any(_may_ask(part, at) for at in range(len(part))))


def _may_ask(part: Part, at: int) -> bool:
    """Whether an unknown word may be a thing, `a quux on the tray`, or what is to be done: `quux the apple`."""
    if part[at].kind != "unknown":
        return False
    before, after = kind_at(part, at - 1) or ",", kind_at(part, at + 1) or ","
    clause = part[at : up_to(part, at, DIVIDING)]
    is_thing = before in ("the", "a", "all") and after in (*DIVIDING, "relation")
    is_verb = before in DIVIDING and after in ("the", "a", "all", "noun", "colour")
    return is_thing or (is_verb and not any(each.kind in ("relation", "each_other", "there") for each in clause))


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
