# SPDX-License-Identifier: Apache-2.0
"""What a row is, in predicates: all on the line between the two things that are farthest from each other.

Rule: the order is the one that they have along that line, so a row that is made reads as one that is there.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from itertools import combinations, permutations
from typing import Any

from rai_missions.planning.scene import Thing

__all__ = ("ROW", "row")

ROW = frozenset({"between", "next_to"})
"""The predicates of a row."""


def row(things: Sequence[Thing], *, first: str | None = None, last: str | None = None) -> Iterator[dict[str, Any]]:
    """The predicates of a row of things, as plain data; two are next to each other.

    Args:
        things: Two or more, where they are now.
        first: The one at the left end, where that is given.
        last: The one at the right end.
    """
    is_from_left = bool(first or last)
    first, *middle, last = (each.name for each in _along(things, first, last))
    if is_from_left:
        yield {"left_of": [first, last]}
    if not middle:
        yield {"next_to": [first, last]}
    for at, name in enumerate(middle):
        yield {"between": [name, first, last]}
        if at:
            yield {"between": [name, middle[at - 1], last]}


def _along(things: Sequence[Thing], first: str | None, last: str | None) -> list[Thing]:
    """The things in their order along the line between the ends, or the two that are farthest from each other."""
    pairs = [
        pair
        for pair in (permutations if first or last else combinations)(things, 2)
        if first in (None, pair[0].name) and last in (None, pair[1].name)
    ]
    one, other = max(pairs, key=lambda pair: math.dist(*map(_centre, pair)))
    x, y = other.x - one.x, other.y - one.y
    inner = [each for each in things if each not in (one, other)]
    return [one, *sorted(inner, key=lambda each: (each.x - one.x) * x + (each.y - one.y) * y), other]


def _centre(thing: Thing) -> tuple[float, float]:
    return thing.x, thing.y
