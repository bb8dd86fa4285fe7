# SPDX-License-Identifier: Apache-2.0
"""All states that a mission can come into, breadth first, and how one leads to another.

Rule: the first way into a state that is found is a shortest one.
"""

from __future__ import annotations

from array import array
from collections import deque
from collections.abc import Callable, Iterable, Iterator
from typing import NamedTuple

from rai_missions.prove.explored import State
from rai_missions.prove.free import Free
from rai_missions.prove.happening import KINDS, HappeningKind

__all__ = ("CANCEL", "KILL", "START", "Flaw", "Space", "Way")

TIME, COMMAND = KINDS.index("time"), KINDS.index("command")
DEEPEST = 65_535
NOW_AND_THEN = 1000


class Way(NamedTuple):
    """How one state leads to another."""

    words: str
    """What happens."""
    at: int = -1
    """The happening's place among those of its state; -1 for the start and the operator's commands."""
    trail: tuple[int, ...] = ()
    """What was chosen meanwhile."""


START, CANCEL, KILL = "the mission starts", "the operator cancels", "the operator stops the mission at once"


class Flaw(NamedTuple):
    """A state, or a step out of it, that breaks a promise."""

    promise: str
    state: int
    """Its number; -1 is before the start."""
    sentence: str
    way: Way | None = None
    """What happens in that state; None where the state itself is at fault."""


class Space:
    """What was explored of a mission.

    Args:
        chart: The mission.
        most: States at the most.
        progress: Told of states found and states done, now and then.
    """

    def __init__(self, chart: Free, most: int, progress: Callable[[int, int], None] = lambda found, done: None) -> None:
        self.chart, self.most, self._progress = chart, most, progress
        self.fresh = chart.save()
        """Before the start."""
        self._numbers: dict[bytes, int] = {}
        self._parents, self._ways = array("l"), array("L")
        self._way_numbers: dict[Way, int] = {}
        self._sources, self._targets, self._kinds = array("L"), array("L"), bytearray()
        self._frontier: deque[tuple[int, State]] = deque()
        self._depths = array("H")
        self.ends: dict[int, str] = {}
        """Number of a state → the outcome with which the run has ended in it."""
        self.canceling: set[int] = set()
        self.taken: set[str] = set()
        """JSON pointers of the rows that were taken."""
        self.entered: set[str] = set()
        self.flaws: dict[str, Flaw] = {}
        """Promise → a shortest way to break it."""
        self.steps = 0
        self.cut: set[int] = set()
        """States out of which some step leads where there was no room for it."""

    @property
    def states(self) -> int:
        return len(self._parents)

    @property
    def depth(self) -> int:
        """Steps of the longest of the shortest ways."""
        return max(self._depths, default=0)

    @property
    def is_whole(self) -> bool:
        """Nothing was left out for want of room."""
        return not self.cut and not self._frontier

    # -- exploring ------------------------------------------------------------------------------------------------

    def explore(self) -> None:
        """Find every state, or as many as there is room for."""
        self._each_way(self.fresh, self.chart.begin, -1, "start", START, at=-1)
        while self._frontier:
            number, state = self._frontier.popleft()
            self._leave(number, state)
            if number % NOW_AND_THEN == 0:
                self._progress(self.states, number)

    def _leave(self, number: int, state: State) -> None:
        """Everything that can happen in a state."""
        chart = self.chart
        chart.load(state)
        found = list(chart.happenings())
        self._stop(number, state)
        for at, happening in enumerate(found):
            self._each_way(state, happening.do, number, happening.kind, happening.words, at=at)
        if number not in self.canceling:
            self._each_way(state, self._cancel, number, "command", CANCEL, at=-1)

    def _cancel(self) -> None:
        self.chart.order("cancel")

    def _each_way(
        self, state: State, do: Callable[[], None], source: int, kind: HappeningKind, words: str, *, at: int
    ) -> None:
        """Let it happen in each way in which it can."""
        chart = self.chart
        chart.choices.begin()
        while True:
            chart.load(state)
            chart.make(do)
            self.steps += 1
            if chart.is_possible:
                chart.settle()
                self._arrive(source, kind, Way(words, at, chart.choices.trail))
            if not chart.choices.another():
                break

    def _stop(self, number: int, state: State) -> None:
        """An emergency stop here ends the mission and every goal."""
        chart = self.chart
        chart.load(state)
        chart.choices.begin()
        chart.make(lambda: chart.order("kill"))
        if chart.outcome != "aborted":
            self._flaw("stop", number, f"an emergency stop leaves the mission {chart.outcome or chart.mode}", Way(KILL))
        self._end(number, Way(KILL))

    def _end(self, source: int, way: Way) -> None:
        if loose := self.chart.loose:
            self._flaw("stopped", source, f"the mission ends while '{loose[0]}' goes on", way)

    def _arrive(self, source: int, kind: HappeningKind, way: Way) -> None:
        """Take note of a step and of the state it leads to."""
        chart = self.chart
        self._learn(source, way)
        ended = chart.outcome is not None
        number = self._numbers.get(key := repr((chart.outcome, chart.why)).encode() if ended else chart.key())
        if number is None:
            if self.states >= self.most:
                self.cut.add(max(source, 0))
                return
            number = self._numbers[key] = self.states
            self._add(source, way)
            if ended:
                self.ends[number] = chart.outcome or ""
            else:
                self._frontier.append((number, chart.save()))
                if chart.mode == "canceling":
                    self.canceling.add(number)
        is_circle = source == number and not (kind == "time" and chart.moves)  # what changes nothing leads nowhere
        if source >= 0 and not is_circle:
            self._sources.append(source)
            self._targets.append(number)
            self._kinds.append(KINDS.index(kind))

    def _add(self, source: int, way: Way) -> None:
        self._parents.append(source)
        self._ways.append(self._way_numbers.setdefault(way, len(self._way_numbers)))
        self._depths.append(min(DEEPEST, self._depths[source] + 1 if source >= 0 else 1))

    def _learn(self, source: int, way: Way) -> None:
        chart = self.chart
        for move in chart.moves:
            self.taken.update(move.taken)
            self.entered.update(move.entered)
        for place, value in chart.looked:
            chart.seen.setdefault(place, set()).add(value)
        if chart.outcome is None:
            return
        self._end(source, way)
        if chart.why.startswith("invariant "):
            self._flaw("invariants", source, chart.why, way)
        elif chart.why.startswith(("a cycle without end", "timers without end")):
            self._flaw("comes to rest", source, chart.why, way)
        if chart.outcome == "succeeded" and not chart.rests_on_facts:
            self._flaw("answers", source, "the mission succeeds, whatever the robot says", way)

    def _flaw(self, promise: str, state: int, sentence: str, way: Way) -> None:
        """The first of each promise is a shortest."""
        self.flaws.setdefault(promise, Flaw(promise, state, sentence, way))

    # -- the graph ------------------------------------------------------------------------------------------------

    def path(self, number: int) -> list[Way]:
        """What happens, from the start, to be in a state."""
        every, way = list(self._way_numbers), []
        while number >= 0:
            way.append(every[self._ways[number]])
            number = self._parents[number]
        return way[::-1]

    def edges(self, *, time_only: bool = False) -> Iterator[tuple[int, int]]:
        """Source and target of every step from one state to another, but the operator's commands."""
        for source, target, kind in zip(self._sources, self._targets, self._kinds, strict=True):
            if kind == TIME or not (time_only or kind == COMMAND):
                yield source, target

    @property
    def unfinished(self) -> list[int]:
        """States whose steps were not explored, or not all."""
        return [*self.cut, *(number for number, _ in self._frontier)]

    def distances(self, goals: Iterable[int], *, time_only: bool = False) -> array[int]:
        """For each state the steps to the nearest of these; -1 where no way leads there."""
        before = _reversed(self.states, self, time_only=time_only)
        far, waiting = array("l", [-1]) * self.states, deque(goals)
        for number in waiting:
            far[number] = 0
        while waiting:
            number = waiting.popleft()
            for source in before(number):
                if far[source] < 0:
                    far[source] = far[number] + 1
                    waiting.append(source)
        return far


def _reversed(states: int, space: Space, *, time_only: bool) -> Callable[[int], array[int]]:
    """Target → its sources, in two arrays (compressed sparse rows)."""
    counts = array("L", [0]) * (states + 1)
    for _, target in space.edges(time_only=time_only):
        counts[target + 1] += 1
    for number in range(states):
        counts[number + 1] += counts[number]
    places, sources = array("L", counts), array("L", [0]) * counts[states]
    for source, target in space.edges(time_only=time_only):
        sources[places[target]] = source
        places[target] += 1
    return lambda number: sources[counts[number] : counts[number + 1]]
