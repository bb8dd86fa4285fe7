# SPDX-License-Identifier: Apache-2.0
"""Rows from symbols: what they consist of, the order from a side, and which things are at the ends."""

from __future__ import annotations

from dataclasses import replace

from rai_missions.planning.reading.noun_phrases import Cursor, noun_phrases, ordered_phrases
from rai_missions.planning.reading.phrases import Clause, Phrase
from rai_missions.planning.reading.symbols import BETWEEN

__all__ = ("ordered_row", "row_of", "sides_of")

SIDES = ("left_to_right", "counted_from")
"""Kinds of symbols that give the side from which a row is listed."""
ENDS = {"left": 0, "right": -1}
"""Ranks of the ends of a row → their place in it."""
CLOSING = ("", *BETWEEN)


def row_of(cursor: Cursor, subjects: tuple[Phrase, ...]) -> Clause:
    """A row of things, with the order or the ends that may be given here."""
    return ordered_row(cursor, subjects) or Clause("row", subjects, levels=_ends(cursor))


def ordered_row(cursor: Cursor, whole: tuple[Phrase, ...], *, is_named: bool = True) -> Clause | None:
    """`…: red, then blue, then green`, from a side that is given; without one it is offered from the left.

    Args:
        cursor: Past the words that ask for a row.
        whole: What the row consists of, where that came before.
        is_named: Whether a row is asked for already; else the side has to be given.

    Returns:
        None where no order is given; the cursor stays.
    """
    begun = cursor.at
    sides = _side(cursor)
    found = ordered_phrases(cursor)
    is_listed = bool(sides) or any(each.kind in (":", "then") for each in cursor.symbols[begun : cursor.at])
    cursor.skip(*(["level"] if cursor.value() == "top" else []))  # `…, and yellow last`
    cursor.skip(",", ".")
    sides += _side(cursor)
    if len(found) < 2 or not ((is_listed and is_named) or sides) or len(sides) > 1 or cursor.kind() not in CLOSING:
        cursor.back_to(begun)
        return None
    is_other = len(whole) == 1 and whole[0].kind != "pronoun"
    if len(whole) > 1 and len(whole) != len(found):
        cursor.back_to(begun)
        return None
    found = found[::-1] if sides == ["right"] else found
    return Clause("in_order", found, whole[0] if is_other else None, is_open=not sides)


def sides_of(subjects: tuple[Phrase, ...]) -> Clause | None:
    """`The cubes on the left, the fruit on the right`: those left of these; None where both sides are not given."""
    groups, begun = dict[str, tuple[Phrase, ...]](), 0
    for at, each in enumerate(subjects):
        if each.rank is not None and each.rank.is_after and each.rank.measure not in groups:
            groups[each.rank.measure] = (*subjects[begun:at], replace(each, rank=None))
            begun = at + 1
    if begun < len(subjects) or groups.keys() != ENDS.keys():
        return None
    return Clause("left_of", groups["left"], ends=groups["right"])


def _side(cursor: Cursor) -> list[str]:
    """The side from which the row is listed, if it is given here."""
    begun = cursor.at
    cursor.skip(",", ":")
    if cursor.kind() in SIDES:
        return [cursor.take().value]
    cursor.back_to(begun)
    return []


def _ends(cursor: Cursor) -> tuple[tuple[Phrase, int | None], ...]:
    """`… with red on the far left and blue on the far right`: the things at the ends of a row, if given."""
    begun = cursor.at
    cursor.skip(",", "with", "and", "then", "put")
    found = noun_phrases(cursor)
    ends = {each.rank.measure: each for each in found if each.rank is not None and each.rank.is_after}
    if not ends or len(ends) < len(found) or not ends.keys() <= ENDS.keys() or cursor.kind() not in CLOSING:
        cursor.back_to(begun)
        return ()
    return tuple((replace(each, rank=None), ENDS[side]) for side, each in ends.items())
