# SPDX-License-Identifier: Apache-2.0
"""Whether a goal has what the words of arranging in a request ask for: `stack` needs one thing on another.

Rule: it holds the reading to the request from the other side than `grounding`, which asks whether the goal was said:
here nothing that was said may be missing, or things that lie on the desk already would be a stack.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rai_missions.planning.goal import Goal, OnTop
from rai_missions.planning.reading.rows import ROW
from rai_missions.planning.reading.symbols import Symbol
from rai_missions.planning.scene import DESK

__all__ = ("left_out",)

ANY = frozenset({"on", "in", "at", "left_of", "between", "next_to", "grouped", "apart", "swapped"})
GROUPS = frozenset({"grouped", "next_to", "in"})
SORTED = frozenset({"grouped", "apart", "in", "on", "left_of"})
NEEDED: Mapping[tuple[str, str], frozenset[str]] = {
    ("stack", ""): frozenset({"on"}),
    ("stack", "many"): frozenset({"on"}),
    ("each_other", "stack"): frozenset({"on"}),
    ("upward", "up"): frozenset({"on"}),
    ("upward", "down"): frozenset({"on"}),
    ("group", ""): GROUPS,
    ("each_other", "group"): frozenset({"grouped"}),
    ("each_other", "next_to"): GROUPS | ROW,
    ("apart", ""): frozenset({"apart"}),
    ("each_other", "apart"): frozenset({"apart"}),
    ("sort", ""): SORTED,
    ("by", "colour"): SORTED,
    ("by", "type"): SORTED,
    ("left_to_right", "left"): frozenset({"left_of"}),
    ("left_to_right", "right"): frozenset({"left_of"}),
    ("put", "line"): ROW | {"left_of"},
    ("each_other", "row"): ROW | {"left_of"},
    ("put", "arrange"): ANY,
}
"""Kind and value of a word → the predicates of which the goal has one; to lie on the desk is none of them."""


def left_out(found: Iterable[Symbol], goal: Goal) -> str:
    """The first word of arranging that no predicate of the goal answers; empty where there is none.

    Args:
        found: The symbols of the request.
        goal: What was read.
    """
    wanted = {each.word for each in goal.all if not (isinstance(each, OnTop) and each.on[1] == DESK)}
    for symbol in found:
        needed = NEEDED.get((symbol.kind, symbol.value)) if isinstance(symbol.value, str) else None
        if needed is not None and not needed & wanted:
            return symbol.text
    return ""
