# SPDX-License-Identifier: Apache-2.0
"""The states that were reached and the steps between them, in little room.

Rule: states are numbered in the order in which they are reached, so the first way into one is a shortest.
"""

from __future__ import annotations

from array import array
from collections import deque
from collections.abc import Iterable, Iterator
from itertools import compress
from typing import NamedTuple

from rai_missions.prove.stimulus import HappeningKind

__all__ = ("Edge", "StateGraph")

DEEPEST = 65_535
REPORTED, MOVING = -2, -1
"""Of a step, in place of the number of what waits on: more than time makes it; the robot is not silent."""


class Edge(NamedTuple):
    """How one state leads to another."""

    words: str
    """What happens."""
    at: int = -1
    """The happening's place among those of its state; -1 for the start, a cancel and an e-stop."""
    trail: tuple[int, ...] = ()
    """What was chosen meanwhile."""


class StateGraph:
    """States by number, and how one leads to another."""

    def __init__(self) -> None:
        self._numbers: dict[bytes, int] = {}
        self._parents, self._ways = array("l"), array("L")
        self._way_numbers: dict[Edge, int] = {}
        self._sources, self._targets, self._kept = array("L"), array("L"), array("l")
        """Each step once: from where, to where, and the number of the set of what waits for time on."""
        self._source, self._joined = -1, set[tuple[int, int]]()
        """The state that is left, and the steps out of it that are known."""
        self._before: dict[bool, list[list[int]]] = {}
        self._depths = array("H")
        self._set_numbers: dict[frozenset[str], int] = {}
        self.waiting: dict[int, int] = {}
        """Number of a state → that of the set of what waits for time in it."""

    @property
    def states(self) -> int:
        return len(self._parents)

    @property
    def depth(self) -> int:
        """Steps of the longest of the shortest ways."""
        return max(self._depths, default=0)

    def _add(self, key: bytes, source: int, way: Edge) -> int:
        """The number of a state that is new."""
        number = self._numbers[key] = self.states
        self._parents.append(source)
        self._ways.append(self._way_numbers.setdefault(way, len(self._way_numbers)))
        self._depths.append(min(DEEPEST, self._depths[source] + 1 if source >= 0 else 1))
        return number

    def wait(self, number: int, words: frozenset[str]) -> int:
        """Note what waits for time in a state; its number among such sets."""
        self.waiting[number] = self._set_numbers.setdefault(words, len(self._set_numbers))
        return self.waiting[number]

    def join(self, source: int, target: int, kind: HappeningKind, kept: frozenset[str] | None = None) -> None:
        """Note a step from one to another, but for what an operator does who need not."""
        if kind == "command":
            return
        number = MOVING if kind == "time" else REPORTED
        if kept is not None:
            number = self._set_numbers.setdefault(kept, len(self._set_numbers))
        if source != self._source:
            self._source, self._joined = source, set()
        step = target, number
        if step not in self._joined:
            self._joined.add(step)
            self._sources.append(source)
            self._targets.append(target)
            self._kept.append(number)

    def path(self, number: int) -> list[Edge]:
        """What happens, from the start, to be in a state."""
        every, way = list(self._way_numbers), []
        while number >= 0:
            way.append(every[self._ways[number]])
            number = self._parents[number]
        return way[::-1]

    def edges(self, *, time_only: bool = False) -> Iterator[tuple[int, int]]:
        """Source and target of every step from one state to another, but what an operator does who need not."""
        steps = zip(self._sources, self._targets, strict=True)
        return compress(steps, map(REPORTED.__lt__, self._kept)) if time_only else steps

    def distances(self, goals: Iterable[int], *, time_only: bool = False) -> array[int]:
        """For each state the steps to the nearest of these; -1 where no way leads there."""
        before = self._sources_of(time_only=time_only)
        far, waiting = array("l", [-1]) * self.states, deque(goals)
        for number in waiting:
            far[number] = 0
        while waiting:
            number = waiting.popleft()
            for source in before[number]:
                if far[source] < 0:
                    far[source] = far[number] + 1
                    waiting.append(source)
        return far

    def silent(self) -> Iterator[tuple[int, int, int]]:
        """Source, target and what waits on, of every step that time alone makes while the robot is silent."""
        for source, target, kept in zip(self._sources, self._targets, self._kept, strict=True):
            if kept >= 0:
                yield source, target, kept

    @property
    def sets(self) -> list[frozenset[str]]:
        """What waits for time, by number."""
        return list(self._set_numbers)

    def _sources_of(self, *, time_only: bool) -> list[list[int]]:
        """For each state those from which a step leads to it; the exploration is over."""
        if time_only not in self._before:
            before = self._before[time_only] = [[] for _ in range(self.states)]
            for source, target in self.edges(time_only=time_only):
                before[target].append(source)
        return self._before[time_only]
