# SPDX-License-Identifier: Apache-2.0
"""The states that were reached and the steps between them, in little room.

Rule: states are numbered in the order in which they are reached, so the first way into one is a shortest. They are left
in that order, too, so the steps out of one follow those out of the one before.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterable, Iterator, Sequence
from itertools import accumulate, chain, compress, repeat
from typing import NamedTuple

from rai_missions.prove.stimulus import StimulusKind

__all__ = ("LENGTHENED", "LISTED", "MOVING", "REPORTED", "Edge", "StateGraph")

DEEPEST = 65_535
REPORTED, MOVING = -2, -1
"""In place of the number of what waits on, for a step: more than time makes it; the robot is not silent."""
UNKNOWN = -1
LENGTHENED, LISTED = "longer list of ", "list of "
"""Prefixes of the name of a state whose list had another item in a step, and of one that began with a list in it: words
that are noted with what waits on."""


class Edge(NamedTuple):
    """How one state leads to another."""

    words: str
    """What happens."""
    at: int = -1
    """The happening's place among those of its words in its state; -1 for the start, a cancel and an e-stop."""
    trail: tuple[int, ...] = ()
    """What was chosen meanwhile."""


class StateGraph:
    """States by number, and how one leads to another."""

    def __init__(self) -> None:
        self._numbers: dict[bytes | int, int] = {}
        self._parents, self._ways = array("l"), array("L")
        self._way_numbers: dict[Edge, int] = {}
        self._first = array("L")
        """Of each state the place of its first step among all; a state without steps has that of the next one."""
        self._targets, self._kept = array("I"), array("i")
        """Each step once: to where, and the number of the set of what waits for time on."""
        self._source, self._joined = -1, set[tuple[int, int]]()
        """The state that is left, and the steps out of it that are known."""
        self._before: dict[bool, tuple[array[int], array[int]]] = {}
        self._far: dict[tuple[int, ...], array[int]] = {}
        self._depths = array("H")
        self._set_numbers: dict[frozenset[str], int] = {}
        self.waiting = array("i")
        """Of each state the number of the set of what waits for time in it; -1 where it was not left."""

    @property
    def states(self) -> int:
        return len(self._parents)

    @property
    def depth(self) -> int:
        """Steps of the longest of the shortest ways."""
        return max(self._depths, default=0)

    def depth_of(self, number: int) -> int:
        """Steps of the shortest way to a state."""
        return self._depths[number]

    def _add(self, key: bytes | int, source: int, way: Edge) -> int:
        """The number of a state that is new."""
        number = self._numbers[key] = self.states
        self._parents.append(source)
        self._ways.append(self._way_numbers.setdefault(way, len(self._way_numbers)))
        self._depths.append(min(DEEPEST, self._depths[source] + 1 if source >= 0 else 1))
        return number

    def note_words(self, number: int, words: frozenset[str]) -> int:
        """Note what waits for time in a state; its number among such sets."""
        found = self.number_of(words)
        self.note_waiting(number, found)
        return found

    def number_of(self, words: frozenset[str]) -> int:
        """The number of a set of what waits for time."""
        return self._set_numbers.setdefault(words, len(self._set_numbers))

    def note_waiting(self, number: int, words: int) -> None:
        """Note what waits for time in a state, by the number of the set."""
        missing = number - len(self.waiting)
        if missing > 0:
            self.waiting.extend([UNKNOWN] * missing)
        self.waiting.append(words)

    def begin(self, source: int) -> None:
        """The steps that are joined from now on lead out of this state."""
        missing = source + 1 - len(self._first)
        self._first.extend([len(self._targets)] * missing)
        self._source = source
        if self._joined:
            self._joined = set()

    def join(self, source: int, target: int, kind: StimulusKind, kept: frozenset[str] | None = None) -> None:
        """Note a step from one to another, but for what an operator does who need not."""
        if kind == "command":
            return
        number = MOVING if kind == "time" else REPORTED
        if kept is not None:
            number = self.number_of(kept)
        if source != self._source:
            self.begin(source)
        step = target, number
        if step not in self._joined:
            self._joined.add(step)
            self._targets.append(target)
            self._kept.append(number)

    def path(self, number: int) -> list[Edge]:
        """What happens, from the start, to be in a state."""
        every, way = list(self._way_numbers), []
        while number >= 0:
            way.append(every[self._ways[number]])
            number = self._parents[number]
        return way[::-1]

    def _sources(self) -> Iterator[int]:
        """From where each step leads."""
        ends = [*self._first[1:], len(self._targets)]
        many = (end - first for first, end in zip(self._first, ends, strict=True))
        return chain.from_iterable(map(repeat, range(len(self._first)), many))

    def edges(self, *, time_only: bool = False) -> Iterator[tuple[int, int]]:
        """Source and target of every step from one state to another, but what an operator does who need not."""
        steps = zip(self._sources(), self._targets, strict=True)
        return compress(steps, map(REPORTED.__lt__, self._kept)) if time_only else steps

    @property
    def has_time(self) -> bool:
        """Time alone makes some step."""
        return any(map(REPORTED.__lt__, self._kept))

    def distances(self, goals: Iterable[int], *, time_only: bool = False) -> Sequence[int]:
        """For each state the steps to the nearest of these; -1 where no way leads there. The exploration is over."""
        now = list(goals)
        place = tuple(now)
        if not time_only and place in self._far:
            return self._far[place]
        far, steps = array("l", [-1]) * self.states, 1
        for number in now:
            far[number] = 0
        # one look at every step: where an event ends the mission from everywhere, none has to be sorted
        now = list({source for source, target in self.edges(time_only=time_only) if far[source] and not far[target]})
        for number in now:
            far[number] = steps
        first, sources = self._sources_of(time_only=time_only) if -1 in far else (array("L"), array("I"))
        while now and first:
            steps += 1
            then = []
            for number in now:
                for source in sources[first[number] : first[number + 1]]:
                    if far[source] < 0:
                        far[source] = steps
                        then.append(source)
            now = then
        if not time_only:
            self._far[place] = far
        return far

    def silent(self) -> Iterator[tuple[int, int, int]]:
        """Source, target and what waits on, of every step that time alone makes while the robot is silent."""
        for source, target, kept in zip(self._sources(), self._targets, self._kept, strict=True):
            if kept >= 0:
                yield source, target, kept

    @property
    def sets(self) -> list[frozenset[str]]:
        """What waits for time, by number."""
        return list(self._set_numbers)

    def _sources_of(self, *, time_only: bool) -> tuple[array[int], array[int]]:
        """The predecessors of all states: where those of each begin, and all of them, state by state."""
        if time_only not in self._before:
            many = array("L", bytes(array("L").itemsize)) * (self.states + 1)
            for _, target in self.edges(time_only=time_only):
                many[target + 1] += 1
            first = array("L", accumulate(many))
            place, sources = first[:], array("I", [0]) * first[-1]
            for source, target in self.edges(time_only=time_only):
                sources[place[target]] = source
                place[target] += 1
            self._before[time_only] = first, sources
        return self._before[time_only]
