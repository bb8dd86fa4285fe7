# SPDX-License-Identifier: Apache-2.0
"""Regions that share nothing: explored one at a time, with the others where they were when all were entered.

Rule: this is done only while each step shows that it can be; the first that does not ends it, and regions are explored
side by side instead.

What is left out, and why nothing is lost. Let a parallel state be entered in one way, with certain parts, and let each
step within it be of one of two kinds: it changes one part, looks at no other and at nothing that is written meanwhile;
or it leaves the parallel state, to the same end or state whatever the other parts are. Then (by induction over the
steps) a run comes to exactly those states whose parts each group comes to by itself, in the sum of their steps; and in
each of them exactly the steps are possible that are possible for its parts, and around them. So what a single step
shows is shown where the others have not moved, at the end of a shortest run: rules, options, invariants, circles within
a step, ends that rest on nothing. The way out is the same: a step that leaves is possible as soon as its own part has
come there. Claims about all runs from a state need one thing more. Something around the regions that the mission can
receive ends it at once, from every one of these states: so none is stuck, and each is one step from its end. Nothing in
them waits for time: each is a state of rest.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from typing import NamedTuple

from rai_missions.engine.compiled.states import CompiledState
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.exploration.region_parts import PartedState
from rai_missions.prove.exploration.regions import OUTSIDE, RegionGroups
from rai_missions.prove.exploration.step_cache import Arrival, CachedStep

__all__ = ("EntangledError", "SeparateRegions", "may_be_apart")


class EntangledError(Exception):
    """Regions were taken to share nothing, and a step shows that they may."""


class Block:
    """All states into which a parallel state that was entered in one way can come.

    Args:
        entry: The parts with which it was entered.
        depth: Steps of the shortest run to there.
    """

    def __init__(self, entry: tuple[int, ...], depth: int) -> None:
        self.entry, self.depth = entry, depth
        self.steps: list[dict[int, int]] = [{} for _ in entry]
        """Of each group: number of a part → steps on its account."""
        self.far = [0 for _ in entry]
        """Of each group the steps to its farthest part."""
        self.around = 0
        """Steps around all parts."""
        self._wakes, self._waits = [0 for _ in entry], [0 for _ in entry]
        """Of each group what its steps could wake, and what its parts wait for, as bits."""

    @property
    def states(self) -> int:
        return math.prod(len(each) for each in self.steps)

    @property
    def explored(self) -> int:
        """States of it that were explored."""
        return 1 + sum(len(each) - 1 for each in self.steps)

    @property
    def every_step(self) -> int:
        """The steps out of all its states."""
        own = (sum(each.values()) * self.states // len(each) for each in self.steps)
        return self.states * self.around + sum(own)

    def is_woken(self, group: int, wakes: int, waits: int) -> bool:
        """Whether some group could be woken by another, now that one has such steps and such a part."""
        self._wakes[group] |= wakes
        self._waits[group] |= waits
        each = range(len(self.entry))
        return any(self._wakes[one] & self._waits[other] for one in each for other in each if one != other)

    @property
    def explored_steps(self) -> int:
        others = sum(sum(each.values()) for each in self.steps)
        return self.explored * self.around + others


class LeftOut(NamedTuple):
    """What the states that were left out add to what was explored."""

    states: int
    steps: int
    depth: int
    """Steps of the longest of the shortest runs to any of them."""


class SeparateRegions:
    """The parallel states whose regions are explored one at a time."""

    def __init__(self) -> None:
        self._blocks: dict[int, Block] = {}
        """Head of the code of states → the block that they are in."""

    def enter(self, head: int, parts: tuple[int, ...], depth: int) -> None:
        """A parallel state was entered.

        Raises:
            EntangledError: It was entered in another way before.
        """
        if self._blocks.setdefault(head, Block(parts, depth)).entry != parts:
            raise EntangledError

    def moved(self, head: int, parts: tuple[int, ...]) -> list[int]:
        """The groups whose steps are made in a state: all where it was entered, else the one that has moved.

        Raises:
            EntangledError: Several have moved in one step.
        """
        entry = self._blocks[head].entry
        found = [group for group, (part, first) in enumerate(zip(parts, entry, strict=True)) if part != first]
        if len(found) > 1:
            raise EntangledError
        return found or [*range(len(parts))]

    def leave(
        self, head: int, parted: PartedState, waits: Sequence[int], depth: int, outcomes: Mapping[int, CachedStep]
    ) -> None:
        """Note what can happen in a state, by group and around all.

        Args:
            head: Of its code.
            parted: The numbers of its frame and parts.
            waits: What each of them waits for, as bits.
            depth: Steps of the shortest run to there.
            outcomes: Group, or `OUTSIDE`, → what comes of all that happens on its account.

        Raises:
            EntangledError: A step is of another kind than those for which groups may be apart.
        """
        block = self._blocks[head]
        for group, outcome in outcomes.items():
            is_apart = (
                _is_around(outcome, parted.frame) if group == OUTSIDE else _is_of_one(outcome, group, parted.frame)
            )
            is_woken = group != OUTSIDE and block.is_woken(group, outcome.footprint.wakes, waits[group])
            if is_woken or not is_apart:
                raise EntangledError
            if group == OUTSIDE:
                block.around = outcome.steps
            else:
                block.steps[group][parted.parts[group]] = outcome.steps
                block.far[group] = max(block.far[group], depth - block.depth)

    def totals(self) -> LeftOut:
        """What was left out."""
        every = self._blocks.values()
        return LeftOut(
            sum(block.states - block.explored for block in every),
            sum(block.every_step - block.explored_steps for block in every),
            max((block.depth + sum(block.far) for block in every), default=0),
        )


def _is_of_one(outcome: CachedStep, group: int, frame: int) -> bool:
    """Each step changes one part, or leaves the parallel state, and rests on no other part."""
    footprint = outcome.footprint
    is_alone = footprint.needs in ((), (group,)) and not footprint.turns
    return is_alone and all(_is_out(each) or _is_within(each, frame) for each in outcome.arrivals)


def _is_around(outcome: CachedStep, frame: int) -> bool:
    """Each step leaves the parallel state, whatever its parts are, or does nothing; one that may come is an end."""
    footprint, arrivals = outcome.footprint, outcome.arrivals
    is_free = not (footprint.needs or footprint.turns)
    is_left = all(_is_out(each) or (_is_within(each, frame) and not each.changed) for each in arrivals)
    return is_free and is_left and any(each.kind == "event" and each.ended is not None for each in arrivals)


def _is_out(arrival: Arrival) -> bool:
    """Whether it leaves the parallel state, and takes no time."""
    return arrival.changed is None and arrival.kind != "time"


def _is_within(arrival: Arrival, frame: int) -> bool:
    """Whether it changes parts alone, neither frame nor store, and takes no time."""
    change, parted = arrival.change, arrival.parted
    is_kept = change is not None and not (change.written or change.added or change.goals or change.is_absolute)
    is_here = arrival.changed is not None and parted is not None and parted.frame == frame
    return is_kept and is_here and arrival.kind not in ("time", "command")


def may_be_apart(environment: Environment, parallels: Iterable[RegionGroups]) -> bool:
    """Whether it is worth while to try: something outside ends the mission, and nothing takes time."""
    graph = environment.chart.program.graph
    is_timed = any(node.timed or node.activity or node.clocked for node in graph.order)
    return not (environment.pause_matters or is_timed) and all(map(_can_end, parallels))


def _can_end(parallel: RegionGroups) -> bool:
    """Whether an event that no region handles ends the mission."""
    around: list[CompiledState] = [parallel.node, *parallel.node.ancestors]
    for transition in (each for node in around for each in node.transitions):
        on, targets = transition.definition.on, transition.targets
        is_alone = transition.test is None and not any(parallel.handlers.get(event) for event in on)
        if on and is_alone and all(each.is_final and each.parent in around[1:] for each in targets) and targets:
            return True
    return False
