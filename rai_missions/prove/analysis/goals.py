# SPDX-License-Identifier: Apache-2.0
"""A few goals, sights and requests that represent all: what guards ask of a goal can turn out in every combination.

Two goals are enough: in a step a goal can be replaced by one other, and what is seen, or was asked for, stays as it
is. That two goals have nothing in common leaves what is asked of each of them free.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Iterator, Mapping
from itertools import product
from typing import Any

from rai_missions.guards.goal import judged
from rai_missions.guards.view import Truth
from rai_missions.planning.examples import GOALS, PAIRS, REQUESTS, ways

__all__ = ("NO_GOAL", "first_of_each", "requests", "sights")

NO_GOAL: Mapping[str, Any] = {}
"""A goal of which nothing is known."""
Json = dict[str, Any]
TEXTS = (*REQUESTS, " and ".join(REQUESTS), "something else")
"""Requests for each goal, for both and for none."""


def sights(goals: Collection[Mapping[str, Any]], aspects: Collection[str]) -> list[Json]:
    """What may be seen: each combination of what these aspects of these goals can be, once."""
    listed = [aspect for aspect in sorted(aspects) if aspect != "said"]
    pairs = [pair for pair, goal in zip(PAIRS, GOALS, strict=True) if goal in goals]
    places = [[*ways(*pair, x=0.4 + 0.2 * place)] for place, pair in enumerate(pairs)]
    found = ({"things": [thing for way in chosen for thing in way], "gripper": "empty"} for chosen in product(*places))
    texts = TEXTS if "said" in aspects else ()

    def judged_so(seen: Any) -> Iterator[Truth]:
        for goal in goals:
            yield from (judged(aspect, goal, seen) for aspect in listed)
            yield from (judged("said", goal, seen, text) for text in texts)

    return first_of_each(found, lambda seen: tuple(judged_so(seen)))


def requests(goals: Collection[Mapping[str, Any]]) -> list[str]:
    """What may be asked for: each of these goals or none, and both."""
    return first_of_each(TEXTS, lambda text: tuple([judged("said", goal, None, text) for goal in goals]))


def first_of_each(values: Iterable[Any], found_out: Callable[[Any], Any]) -> list[Any]:
    """The first of all values about which the same is found out."""
    first: dict[Any, Any] = {}
    for value in values:
        first.setdefault(found_out(value), value)
    return list(first.values())
