# SPDX-License-Identifier: Apache-2.0
"""Circles in which time alone leads a mission, while nothing is reported.

Rule: time is fair. What waits for time gets it in the end, unless it begins to wait again and again. So a circle is one
for ever only where nothing waits all the way round that is not taken in it.
"""

from __future__ import annotations

from collections import defaultdict, deque
from collections.abc import Iterator, Sequence

from rai_missions.check.scc import knots
from rai_missions.prove.state_graph import LENGTHENED, LISTED, StateGraph

__all__ = ("circling",)

Steps = dict[int, list[tuple[int, int]]]
"""State → the states to which time alone leads, each with the number of what waits on."""


def circling(space: StateGraph) -> list[int]:
    """The states through which time alone leads a silent run again and again, ascending."""
    sets = space.sets
    parts = _unlisted(_endless(space), sets)
    return sorted(number for steps in parts if _is_for_ever(steps, space.waiting, sets) for number in steps)


def _unlisted(steps: Steps, sets: list[frozenset[str]]) -> Iterator[Steps]:
    """The parts within which each state leads to each other, without what a list that comes to its end does not do.

    A list has any number of items, and not more and more of them: who begins with none cannot find it longer for ever.
    """
    for part in knots({number: [target for target, _ in after] for number, after in steps.items()}):
        states = set(part)
        inner = {number: [each for each in steps[number] if each[0] in states] for number in part}
        words = frozenset[str]().union(*(sets[kept] for after in inner.values() for _, kept in after))
        longer = {each for each in words if each.startswith(LENGTHENED)}
        ending = {each for each in longer if LISTED + each.removeprefix(LENGTHENED) not in words}
        if not ending:
            yield inner
            continue
        yield from _unlisted(
            {number: [each for each in after if ending.isdisjoint(sets[each[1]])] for number, after in inner.items()},
            sets,
        )


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


def _is_for_ever(steps: Steps, waiting: Sequence[int], sets: list[frozenset[str]]) -> bool:
    """Whether a run can stay among these states for ever though all that waits for time gets it."""
    inner = {kept for after in steps.values() for _, kept in after}
    if not inner:
        return False
    all_the_way = [sets[waiting[number]] if _is_known(number, waiting) else frozenset[str]() for number in steps]
    return not frozenset.intersection(*all_the_way, *(sets[kept] for kept in inner))


def _is_known(number: int, waiting: Sequence[int]) -> bool:
    """Whether a state was left, so that it is known what waits for time in it."""
    return number < len(waiting) and waiting[number] >= 0
