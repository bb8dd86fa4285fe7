# SPDX-License-Identifier: Apache-2.0
"""Which of several things comes first by a measure: the leftmost, the second from the left, the nearest to the tray.

Rule: what does not lead clearly, by each way to measure it, leaves several things to choose from.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from rai_missions.planning.geometry import gap
from rai_missions.planning.reading.phrases import Rank
from rai_missions.planning.scene import Thing

__all__ = ("choices",)

CLEAR_M = 0.01
"""Metres by which one thing has to be ahead of another, so that a person sees that it is."""
SIGMAS = 3.0
"""Standard deviations of the camera that are added to it."""
RankMeasure = Callable[[Thing, Thing | None], float]
"""Metres of a thing, the least first; the other is what a distance is measured from."""


def _longest(thing: Thing, _: Thing | None) -> float:
    return max(thing.size)


def _volume(thing: Thing, _: Thing | None) -> float:
    """As the side of a cube that has it."""
    return math.cbrt(math.prod(thing.size))


def _from_robot(thing: Thing, _: Thing | None) -> float:
    return math.hypot(thing.x, thing.y)


def _between_centres(thing: Thing, other: Thing | None) -> float:
    return math.dist((thing.x, thing.y), (other.x, other.y)) if other is not None else 0.0


def _between_outlines(thing: Thing, other: Thing | None) -> float:
    return gap(thing.footprint, other.footprint) if other is not None else 0.0


def _most(*measures: RankMeasure) -> tuple[RankMeasure, ...]:
    """The measures from the other end."""

    def turned(measure: RankMeasure) -> RankMeasure:
        return lambda thing, other: -measure(thing, other)

    return tuple(turned(each) for each in measures)


SIZE: tuple[RankMeasure, ...] = (_longest, _volume)
AWAY: tuple[RankMeasure, ...] = (_between_centres, _between_outlines)
MEASURES: Mapping[str, tuple[RankMeasure, ...]] = {
    "left": (lambda thing, _: -thing.y,),
    "right": (lambda thing, _: thing.y,),
    "near_robot": (_from_robot,),
    "far_from_robot": _most(_from_robot),
    "near": AWAY,
    "far": _most(*AWAY),
    "small": SIZE,
    "big": _most(*SIZE),
}
"""Word of a rank → the ways to measure it. Without another thing all are as `near`, so that it is asked which."""


def choices(things: Sequence[Thing], rank: Rank, count: int, other: Thing | None) -> Iterator[tuple[str, ...]]:
    """What a rank may mean among things, each choice all of its names; none where there are too few.

    Args:
        things: That are compared.
        rank: What is meant.
        count: How many are.
        other: What a distance is measured from.
    """
    if (rank.is_of_two or rank.is_after) and len(things) <= count:
        return
    if rank.is_of_two and len(things) > 2:
        yield from ((each.name,) for each in things)
        return
    for measure in MEASURES[rank.measure]:
        yield from _of_measure(measure, things, slice(rank.place - 1, rank.place - 1 + count), other)


def _of_measure(
    measure: RankMeasure, things: Sequence[Thing], wanted: slice, other: Thing | None
) -> Iterator[tuple[str, ...]]:
    """The things at some places of the order by a measure; the ones that may be at the place instead, one by one."""
    order = sorted(things, key=lambda each: (measure(each, other), each.name))
    found = order[wanted]
    if len(found) < wanted.stop - wanted.start:
        return
    yield tuple(each.name for each in found)
    edges = (found[0], found[-1])
    for each in order:
        if each not in found and any(_is_level(measure, each, edge, other) for edge in edges):
            yield from (
                tuple(each.name if one is edge else one.name for one in found)
                for edge in edges
                if _is_level(measure, each, edge, other)
            )


def _is_level(measure: RankMeasure, one: Thing, two: Thing, other: Thing | None) -> bool:
    clear = CLEAR_M + SIGMAS * math.hypot(one.sigma_m, two.sigma_m)
    return abs(measure(one, other) - measure(two, other)) < clear
