# SPDX-License-Identifier: Apache-2.0
"""Towers from symbols: what they consist of, and which thing is at the bottom, in the middle or on top."""

from __future__ import annotations

from collections.abc import Iterator

from rai_missions.planning.reading.lexicon import Vocabulary
from rai_missions.planning.reading.noun_phrases import Cursor, noun_phrase, noun_phrases, ordered_phrases
from rai_missions.planning.reading.phrases import Clause, Phrase

__all__ = ("is_tower", "levels_of", "skip_several", "tower")

LEVELS: dict[str, int | None] = {"bottom": 0, "top": -1, "middle": None}
NOWHERE = 1_000
ENDS = ("", ".", ",", "then")
BEFORE = ("the", "a", "any", "all", "number", "generic", "other", "put")


def is_tower(cursor: Cursor) -> bool:
    """Whether a tower begins here: `stack …`, `a tower …`, `two towers …`, `from bottom to top …`."""
    ahead = 0
    while cursor.kind(ahead) in BEFORE:
        ahead += 1
    if cursor.kind(ahead) == "upward":
        return ahead == 0
    return cursor.kind(ahead) == "stack"


def tower(cursor: Cursor, lexicon: Vocabulary, first: tuple[Phrase, ...] = ()) -> list[Clause]:
    """The clauses of one tower, or of several.

    Args:
        cursor: At its first symbol.
        lexicon: For what is asked back.
        first: What it consists of, where that came before.

    Raises:
        Unread: It is not read for sure.
    """
    count = _skip_head(cursor)
    height = _height(cursor) if count > 1 else 0
    cursor.skip("with", ":", ",", "put")
    if cursor.kind() == "part":
        return _several(cursor, lexicon)
    if cursor.kind() == "upward" and not first:
        return [_upward(cursor, lexicon)]
    first = first or _in_turn(cursor) or noun_phrases(cursor)
    if count > 1 and cursor.kind() in ENDS:
        return _towers(first, count, height)
    if count != 1:
        raise lexicon.unread("order")  # `towers`: of what is each?
    if first and (ordered := _ordered(first, cursor)):
        return [Clause("stack", ordered)]
    if first and cursor.kind() == ":" and (ordered := ordered_phrases(cursor)):
        return [Clause("stack", first, levels=tuple((each, level) for level, each in enumerate(ordered)))]
    if first and (chain := _downward(cursor)):
        return [Clause("stack", first, levels=tuple((each, level) for level, each in enumerate(chain)))]
    if first and cursor.kind() == "relation":
        return _based(first, cursor, lexicon) or _chain(first, cursor, lexicon)
    cursor.skip("put")
    cursor.skip("each_other")
    members, levels = levels_of(first, cursor, lexicon)
    if not levels and first and cursor.kind() in ("and", ",") and cursor.kind(1) == "part":
        cursor.take()
        return [Clause("stack", first), *_several(cursor, lexicon)]
    return [Clause("stack", members, levels=levels)]


def _height(cursor: Cursor) -> int:
    """Past `of two`, `of three cubes each`: how many things each tower has; 0 where that is open."""
    begun = cursor.at
    if cursor.skip("with") and cursor.kind() == "number" and cursor.value().unit is None:
        height = int(cursor.take().value.value)
        is_noun = cursor.kind() == "noun" and cursor.value().is_many is not False
        cursor.skip(*(["noun", "all"] if is_noun else ["all"]))
        if cursor.kind() in (*ENDS, ":"):
            return height
    cursor.back_to(begun)
    return 0


def _towers(first: tuple[Phrase, ...], count: int, height: int) -> list[Clause]:
    """Several towers: of as many named things each, in their order, or to choose."""
    if height and len(first) == count * height and not any(map(_is_several, first)):
        return [Clause("stack", first[at : at + height]) for at in range(0, len(first), height)]
    return [Clause("towers", first, count=count, height=height)]


def skip_several(cursor: Cursor) -> int:
    """Past `two towers:` where a wish about things follows; how many they are, 0 where it is no such beginning."""
    begun = cursor.at
    count = _skip_head(cursor)
    if count > 1:
        _height(cursor)
    cursor.skip("with", ":", ",", "put")
    wish = cursor.at
    is_wish = count > 1 and bool(noun_phrases(cursor)) and cursor.kind() == "relation"
    cursor.back_to(wish if is_wish else begun)
    return count if is_wish else 0


def _skip_head(cursor: Cursor) -> int:
    """Past `a tower`, `two towers`, `stack`; how many towers they are, 0 where that is open."""
    begun = cursor.at
    cursor.skip(*BEFORE)
    cursor.skip("stack")
    head = cursor.symbols[begun : cursor.at]
    if counts := [int(symbol.value.value) for symbol in head if symbol.kind == "number"]:
        return counts[0]
    return 0 if any(symbol.value in ("many", "two") for symbol in head) else 1


def _in_turn(cursor: Cursor) -> tuple[Phrase, ...]:
    """`red, then blue, then green`, from below; empty where more is wished of the last, as in `…, then blue on red`."""
    begun = cursor.at
    found = ordered_phrases(cursor)
    if cursor.kind() not in ENDS:
        cursor.back_to(begun)
        return ()
    return found


def _ordered(first: tuple[Phrase, ...], cursor: Cursor) -> tuple[Phrase, ...]:
    """What came before in the order that ends it, from below: `…, from bottom to top`; empty where none ends it."""
    begun = cursor.at
    cursor.skip(",")
    if cursor.kind() == "upward":
        is_up = cursor.take().value == "up"
        if cursor.kind() in ENDS:
            return first if is_up else first[::-1]
    cursor.back_to(begun)
    return ()


def _based(first: tuple[Phrase, ...], cursor: Cursor, lexicon: Vocabulary) -> list[Clause]:
    """`stack the cubes on the tray`: one tower of several things, and what it stands on; empty where it is a chain."""
    begun, relation = cursor.at, cursor.take().value
    target = noun_phrase(cursor) if relation in ("on", "in") and (len(first) > 1 or _is_several(first[0])) else None
    if target is None or cursor.kind() == "relation":
        cursor.back_to(begun)
        return []
    members, levels = levels_of(first, cursor, lexicon)
    return [Clause("stack", members, target, levels=levels)]


def _is_several(phrase: Phrase) -> bool:
    return phrase.is_many or phrase.is_all or (phrase.count or 1) > 1


def _chain(first: tuple[Phrase, ...], cursor: Cursor, lexicon: Vocabulary) -> list[Clause]:
    """`stack red on blue on green`."""
    found, above = list[Clause](), first
    while cursor.kind() == "relation":
        relation, target = cursor.take().value, noun_phrase(cursor)
        if relation != "on" or target is None or (target.others and cursor.kind() == "relation"):
            raise lexicon.unread()
        found.append(Clause("on", above, target))
        above = (target,)
    return found


def _downward(cursor: Cursor) -> tuple[Phrase, ...]:
    """`… with red over blue over green at the base`, from below; empty where it is no chain of two or more."""
    begun, found = cursor.at, list[Phrase]()
    cursor.skip("with", ",", ":")
    while (phrase := noun_phrase(cursor)) is not None:
        found.append(phrase)
        if cursor.value() != "on" or not cursor.skip("relation"):
            break
    if cursor.kind() == "level" and cursor.value() == "bottom":
        cursor.take()
    are_things = all(each.kind == "things" and not each.is_container for each in found)
    if len(found) < 2 or not are_things or cursor.kind() not in (*ENDS, "and"):
        cursor.back_to(begun)
        return ()
    return tuple(reversed(found))


def _several(cursor: Cursor, lexicon: Vocabulary) -> list[Clause]:
    found = list[Clause]()
    while cursor.kind() == "part":
        cursor.take()
        cursor.skip("the")
        members = noun_phrases(cursor)
        if not members:
            raise lexicon.unread()
        found.append(Clause("stack", members))
        if cursor.kind() in ("and", ",") and cursor.kind(1) == "part":
            cursor.take()
    return found


def _upward(cursor: Cursor, lexicon: Vocabulary) -> Clause:
    is_up = cursor.take().value == "up"
    members = ordered_phrases(cursor)
    if len(members) < 2:
        raise lexicon.unread()
    return Clause("stack", members if is_up else members[::-1])


def levels_of(
    first: tuple[Phrase, ...], cursor: Cursor, lexicon: Vocabulary
) -> tuple[tuple[Phrase, ...], tuple[tuple[Phrase, int | None], ...]]:
    """What is left of the members, and what has a level from here on: `… with red at the bottom, green on top`."""
    members, placed = list(first), list[tuple[Phrase, int | None]]()
    if members and cursor.kind() == "level" and not _is_several(members[-1]):
        placed.append((members.pop(), LEVELS[cursor.take().value]))
    while True:
        before = cursor.at
        cursor.skip(",", "and", "with", "put", "then", "there")
        level = _level(cursor)
        cursor.skip(":")
        named = noun_phrases(cursor)
        level = _level(cursor) if level is NOWHERE else level
        is_next = _skip_below(cursor) or cursor.kind() in ENDS
        if len(named) == 1 and level is not NOWHERE:
            placed.append((named[0], level))
        elif named and placed and (level is not NOWHERE or is_next):
            between = named if level is NOWHERE else named[:-1]
            placed += [
                *_next_levels(between, placed[-1][1], lexicon),
                *((each, level) for each in named[len(between) :]),
            ]
        else:
            cursor.back_to(before)
            return tuple(members), tuple(placed)


def _skip_below(cursor: Cursor) -> bool:
    """Past words that name the level below, `… blue above it`; whether there were any."""
    is_above = cursor.kind() == "relation" and cursor.value() == "on" and cursor.kind(1) == "pronoun"
    if cursor.kind() == "there" and cursor.kind(1) in (*ENDS, "and"):
        return cursor.skip("there")  # `rot unten, blau drauf`
    return is_above and cursor.kind(2) in (*ENDS, "and") and cursor.skip("relation", "pronoun")


def _level(cursor: Cursor) -> int | None:
    return LEVELS[cursor.take().value] if cursor.kind() == "level" else NOWHERE


def _next_levels(named: tuple[Phrase, ...], last: int | None, lexicon: Vocabulary) -> Iterator[tuple[Phrase, int]]:
    if last is None or last < 0:
        raise lexicon.unread("order")
    yield from ((each, last + 1 + index) for index, each in enumerate(named))
