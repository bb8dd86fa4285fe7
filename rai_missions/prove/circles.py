# SPDX-License-Identifier: Apache-2.0
"""Circles in which time alone leads a mission, while nothing is reported.

Rule: time is fair. What waits for time gets it in the end, unless it begins to wait again and again. So a circle is one
for ever only where nothing waits all the way round that is not taken in it.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterable, Sequence

from rai_missions.check.scc import knots
from rai_missions.prove.state_graph import StateGraph

__all__ = ("circling",)

Steps = dict[int, list[tuple[int, int]]]
"""State → the states to which time alone leads, each with the number of what waits on."""


def circling(space: StateGraph) -> list[int]:
    """The states through which time alone leads a silent run again and again, ascending."""
    steps = _endless(space)
    sets = space.sets
    parts = knots({number: [target for target, _ in after] for number, after in steps.items()})
    found = [each for part in parts for each in part if _is_for_ever(part, steps, space.waiting, sets)]
    return sorted(found)


def _endless(space: StateGraph) -> Steps:
    """The steps between states from which time alone never has to come to rest."""
    steps, before = defaultdict[int, list[tuple[int, int]]](list), defaultdict[int, list[int]](list)
    for source, target, kept in space.silent():
        steps[source].append((target, kept))
        before[target].append(source)
    left = {number: len(after) for number, after in steps.items()}
    waiting = deque(number for number in before if number not in left)
    while waiting:
        for source in before[waiting.popleft()]:
            left[source] -= 1
            if not left[source]:
                waiting.append(source)
    return {number: [each for each in steps[number] if left.get(each[0])] for number, many in left.items() if many}


def _is_for_ever(part: Iterable[int], steps: Steps, waiting: Sequence[int], sets: list[frozenset[str]]) -> bool:
    """Whether a run can stay among these states for ever though all that waits for time gets it."""
    states = set(part)
    inner = {kept for number in states for target, kept in steps[number] if target in states}
    if not inner:
        return False
    all_the_way = [sets[waiting[number]] if _is_known(number, waiting) else frozenset[str]() for number in states]
    return not frozenset.intersection(*all_the_way, *(sets[kept] for kept in inner))


def _is_known(number: int, waiting: Sequence[int]) -> bool:
    """Whether a state was left, so that it is known what waits for time in it."""
    return number < len(waiting) and waiting[number] >= 0
