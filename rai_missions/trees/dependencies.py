# SPDX-License-Identifier: Apache-2.0
"""What the next tick would look at: keys and instants that want a tick, and the guards whose duration is counted."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from rai_missions.engine.activities.ticker import LoopRound
from rai_missions.engine.trees.tick import TickView
from rai_missions.guards.view import Instant, Site
from rai_missions.trees.nodes import RUNNING, TracedBehaviour

__all__ = ("BehaviourWatch", "TickReads")

Call = tuple[str, str, str]


class TickReads(NamedTuple):
    """What a tick may look at."""

    watched: frozenset[str]
    """Keys, and states by their `presence`."""
    instants: tuple[Instant, ...]


def _of(sites: Iterable[Site]) -> TickReads:
    every = list(sites)
    watched = frozenset[str]().union(*(site.watched for site in every))
    return TickReads(watched, tuple(instant for site in every for instant in site.instants))


class BehaviourWatch:
    """Over the live behaviours of one tree.

    Args:
        live: Path → what is there.
    """

    def __init__(self, live: Mapping[str, TracedBehaviour]) -> None:
        sites = {each: each.site for each in live.values() if each.site is not None}
        self.held_guards = {name: test for site in sites.values() for name, test in site.held_guards.items()}
        self.depends = {each: _of([site]) for each, site in sites.items() if not site.held_guards}
        self.held_reads = _of(site for site in sites.values() if site.held_guards)
        """By what the guards change whose duration is counted, whether the next tick looks at them or not."""
        self.turns = {path: each for path, each in live.items() if getattr(each.parent, "loops", False)}
        """Path → the child of a loop that is there: each of its runs is a round."""

    def note_held(self, sight: TickView) -> TickView:
        """Note since when the inner guards of `held` have been true, whether the next tick looks at them or not."""
        if self.held_guards:
            sight.note_held(self.held_guards)
        return sight

    def looked_at(self, root: TracedBehaviour) -> TickReads:
        """What the next tick may look at if nothing but facts and time change, and on what a duration depends."""
        keys, instants, rest = set(self.held_reads.watched), list(self.held_reads.instants), [root]
        while rest:
            node = rest.pop()
            rest += node.ahead()
            found = self.depends.get(node)
            if found is not None and node.looks:
                keys |= found.watched
                instants += found.instants
        return TickReads(frozenset(keys), tuple(instants))

    @staticmethod
    def wake_at(root: TracedBehaviour, sight: TickView, instants: Iterable[Instant]) -> float:
        """The next deadline of what runs, or instant at which a guard's facts grow old."""
        due = [node.deadline() for node in running(root)]
        due += [instant(sight) for instant in instants]
        return min((at for at in due if at is not None and at > sight.at), default=math.inf)

    def turning(self) -> frozenset[str]:
        """The children of loops of which a run is under way."""
        return frozenset(path for path, child in self.turns.items() if child.status is RUNNING)

    def turned(self, before: Collection[str], trace: Iterable[Call]) -> tuple[tuple[str, ...], tuple[LoopRound, ...]]:
        """The runs of loops' children that have begun in a tick and continue, and the rounds that have ended.

        Args:
            before: What `turning` was before the tick.
            trace: What was called in it.
        """
        begun: dict[str, None] = {}
        rounds: list[LoopRound] = []
        for path, call, status in trace:
            if path not in self.turns or call == "update":
                continue
            if call == "initialise":
                begun[path] = None
                continue
            at_once = path in begun or path not in before
            begun.pop(path, None)
            if status != "invalid":
                loop: Any = self.turns[path].parent
                rounds.append(LoopRound(path, loop.counted, at_once, loop.status is RUNNING))
        return tuple(begun), tuple(rounds)


def running(node: Any) -> Iterator[Any]:
    """What runs, outer before inner."""
    if node.status is RUNNING:
        yield node
        for child in node.children:
            yield from running(child)
