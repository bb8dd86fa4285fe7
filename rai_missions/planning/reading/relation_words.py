# SPDX-License-Identifier: Apache-2.0
"""Which relations the words of a request may mean: `on` needs a word of putting on or of a tower.

Rule: words of a relation are evidence for its predicates, whatever is between; a negation takes all evidence away.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rai_missions.planning.reading.rows import ROW
from rai_missions.planning.reading.symbols import DIVIDING, RANKS, Symbol

__all__ = ("relations_in",)

EXCHANGE = frozenset({"on", "in", "at", "swapped"})
"""What a swap is rewritten to."""
KINDS: Mapping[str, frozenset[str]] = {
    "stack": frozenset({"on"}),
    "upward": frozenset({"on"}),
    "level": frozenset({"on"}),
    "swap": EXCHANGE,
    "group": frozenset({"grouped"}),
    "sort": frozenset({"grouped", "apart"}),
    "by": frozenset({"grouped", "apart"}),
    "apart": frozenset({"apart"}),
    "left_to_right": frozenset({"left_of"}),
    "side": frozenset({"at", "left_of", "shifted"}),
    "axis": frozenset({"at"}),
    "place": frozenset({"at"}),
    "(": frozenset({"at"}),
    "away": frozenset({"in"}),
    "fill": frozenset({"in"}),
    "there": frozenset({"in", "on"}),
    "empty": frozenset({"on"}),
    "unstack": frozenset({"on"}),
    "holds": frozenset({"in"}),
    ":": frozenset({"in"}),
    "=": frozenset({"in"}),
    "stays": frozenset({"at", "shifted"}),
    "keep": frozenset({"at", "shifted"}),
}
"""Kinds of symbols → the predicates that they may mean."""
VALUES: Mapping[str, frozenset[str]] = {
    "on": frozenset({"on", "in"}),
    "in": frozenset({"in"}),
    "to": frozenset({"in", "at", "on"}),
    "off": frozenset({"on"}),
    "under": frozenset({"on"}),
    "left_of": frozenset({"left_of"}),
    "right_of": frozenset({"left_of"}),
    "behind": frozenset({"behind"}),
    "in_front_of": frozenset({"behind"}),
    "between": frozenset({"between"}),
    "next_to": frozenset({"next_to"}),
    "apart": frozenset({"apart"}),
    "place_of": EXCHANGE | {"shifted"},
    "swap": EXCHANGE,
    "stack": frozenset({"on"}),
    "group": frozenset({"grouped"}),
    "unstack": frozenset({"on"}),
    "row": ROW | {"left_of"},
    "line": ROW,
}
"""Values of `relation`, `each_other` and `put` → the predicates that they may mean; on a tray is in it."""


def relations_in(found: Iterable[Symbol]) -> frozenset[str]:
    """The words of the predicates that a text may mean.

    Args:
        found: The symbols of the text.
    """
    meant, before, sides = frozenset[str](), ",", set[str]()
    for symbol in found:
        is_first, before = before in DIVIDING, symbol.kind
        if is_first and symbol.is_container:
            meant |= {"in"}  # `bin the tomato`
        if symbol.kind == "no":
            return frozenset()
        meant |= KINDS.get(symbol.kind, frozenset())
        sides |= {symbol.value} if symbol.kind in RANKS else set()
        if symbol.kind in ("relation", "each_other", "put"):
            meant |= VALUES.get(symbol.value, frozenset())
    return meant | {"left_of"} if {"left", "right"} <= sides else meant
