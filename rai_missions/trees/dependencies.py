# SPDX-License-Identifier: Apache-2.0
"""What the next tick would look at: keys and instants that want a tick, and the guards whose duration is counted."""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from py_trees.behaviour import Behaviour

from rai_missions.engine.activities.ticker import LoopRound
from rai_missions.guards.guard import Instant, Site
from rai_missions.trees.builder import BuiltNode
from rai_missions.trees.leaves import ActivityLeaf, Ask, Write
from rai_missions.trees.nodes import (
    FAILURE,
    LOOPS,
    RUNNING,
    SUCCESS,
    EternalGuard,
    OneShot,
    Parallel,
    Repeat,
    Retry,
    Selector,
    Sequence,
)
from rai_missions.trees.tick import TickView

__all__ = ("BehaviourWatch", "TickReads")

Call = tuple[str, str, str]


class TickReads(NamedTuple):
    """What a tick may look at."""

    watched: frozenset[str]
    """Keys, and states by their `presence`."""
    instants: tuple[Instant, ...]


def _of(site: Site) -> TickReads:
    return TickReads(site.watched, tuple(site.instants))


class BehaviourWatch:
    """Over the live behaviours of one tree.

    Args:
        planted: Path → what is there.
    """

    def __init__(self, planted: Mapping[str, BuiltNode]) -> None:
        sites = {each.behaviour: each.site for each in planted.values() if each.site}
        self.holds = {name: test for site in sites.values() for name, test in site.holds.items()}
        self.depends: dict[Any, TickReads] = {node: _of(site) for node, site in sites.items() if not site.holds}
        held = [_of(site) for site in sites.values() if site.holds]
        self.held_by = TickReads(
            frozenset[str]().union(*(each.watched for each in held)),
            tuple(instant for each in held for instant in each.instants),
        )
        """By what the guards change whose duration is counted, whether the next tick looks at them or not."""
        self.turns = dict(_turns(planted))
        """Path → the child of a loop that is there."""

    def hold(self, sight: TickView) -> TickView:
        """Note since when the inner guards of `held` have been true, whether the next tick looks at them or not."""
        if self.holds:
            held: dict[str, float] = dict(sight.held)
            sight.held = held
            for name, test in self.holds.items():
                if test(sight) is True:
                    held.setdefault(name, sight.at)
                else:
                    held.pop(name, None)
        return sight

    def looked_at(self, root: Behaviour) -> TickReads:
        """What the next tick may look at if nothing but facts and time change, and on what a duration depends."""
        keys, instants, rest = set(self.held_by.watched), list(self.held_by.instants), [root]
        while rest:
            node = rest.pop()
            rest += _next(node)
            found = self.depends.get(node)
            if found is not None and looks(node):
                keys |= found.watched
                instants += found.instants
        return TickReads(frozenset(keys), tuple(instants))

    @staticmethod
    def wake_at(root: Behaviour, sight: TickView, instants: Iterable[Instant]) -> float:
        """The next deadline of what runs, or instant at which a guard's facts grow old."""
        due = [node.deadline() for node in running(root)]
        due += [instant(sight) for instant in instants]
        return min((at for at in due if at is not None and at > sight.at), default=math.inf)

    def turning(self) -> frozenset[str]:
        """The children of loops of which a run is under way."""
        return frozenset(path for path, turn in self.turns.items() if turn.child.status is RUNNING)

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
                turn = self.turns[path]
                rounds.append(LoopRound(path, turn.counted, at_once, turn.loop.status is RUNNING))
        return tuple(begun), tuple(rounds)


class LoopTurn(NamedTuple):
    """The child of a loop: each of its runs is a round."""

    child: Any
    loop: Any
    counted: bool


def _turns(planted: Mapping[str, BuiltNode]) -> Iterator[tuple[str, LoopTurn]]:
    for path, each in planted.items():
        loop = each.behaviour.parent
        if isinstance(loop, LOOPS) or (isinstance(loop, Parallel) and not loop.policy.synchronise):
            yield path, LoopTurn(each.behaviour, loop, _counted(loop))


def _counted(loop: Any) -> bool:
    return isinstance(loop, Retry) or (isinstance(loop, Repeat) and loop.num_success > 0)


def running(node: Any) -> Iterator[Any]:
    """What runs, outer before inner."""
    if node.status is RUNNING:
        yield node
        for child in node.children:
            yield from running(child)


def looks(node: Any) -> bool:
    """Whether what the next tick would do there depends on its keys.

    What an action or call was sent with makes no difference any more, unless it was refused for that. What a leaf adds
    to is its own affair, as long as there is something to add to.
    """
    if isinstance(node, ActivityLeaf):
        return node.refused
    return not isinstance(node, Write) or not node.adds or node.status is not SUCCESS


def _next(node: Any) -> list[Any]:
    children: list[Any] = node.children
    if isinstance(node, Sequence | Selector):
        return _in_turn(node, children)
    if isinstance(node, OneShot) and node.final_status is not None:
        return []
    if isinstance(node, EternalGuard) and node.status is FAILURE and node.decorated.status is not FAILURE:
        return []  # its guard was not true
    if node.status is RUNNING:
        if isinstance(node, Ask):
            return [node.current_child] if node.current_child is not None else []
        if isinstance(node, Parallel) and node.policy.synchronise:
            return [child for child in children if child.status is not SUCCESS]
    return children


def _in_turn(node: Any, children: list[Any]) -> list[Any]:
    """The child that runs, those before it without memory; of what has ended, those up to the one that decided."""
    if node.status is RUNNING:
        current: int = node.place()
        return children[current : current + 1] if node.memory else children[: current + 1]
    decides = FAILURE if isinstance(node, Sequence) else SUCCESS
    if node.status is decides:
        for number, child in enumerate(children):
            if child.status is decides:
                return children[: number + 1]
    return children
