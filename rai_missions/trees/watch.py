# SPDX-License-Identifier: Apache-2.0
"""What the next tick would look at: keys and instants that want a tick, and the guards whose duration is counted."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator, Mapping
from typing import Any

from py_trees.behaviour import Behaviour

from rai_missions.guards.guard import Site
from rai_missions.trees.leaves import Ask
from rai_missions.trees.nodes import LOOPS, RUNNING, SUCCESS, Parallel, Repeat, Retry, Selector, Sequence
from rai_missions.trees.planting import Planted
from rai_missions.trees.round import Sight

__all__ = ("Watch",)


class Watch:
    """Over the live behaviours of one tree.

    Args:
        planted: Path → what stands there.
    """

    def __init__(self, planted: Mapping[str, Planted]) -> None:
        self.sites: dict[Behaviour, Site] = {each.behaviour: each.site for each in planted.values() if each.site}
        self.holds = {name: test for site in self.sites.values() for name, test in site.holds.items()}
        self.holding = [site for site in self.sites.values() if site.holds]
        self.loops = [each.behaviour for each in planted.values() if _may_begin_again(each.behaviour)]

    def hold(self, sight: Sight) -> Sight:
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

    def reads(self, root: Behaviour) -> frozenset[str]:
        """The keys at which the next tick may look, and those on which a duration depends."""
        return frozenset(key for site in self._sites(root) for key in site.reads)

    def wake_at(self, root: Behaviour, sight: Sight) -> float:
        """The next deadline of what runs, or instant at which a guard's facts grow old."""
        due = [node.deadline() for node in running(root)]
        due += [instant(sight) for site in self._sites(root) for instant in site.instants]
        return min((at for at in due if at is not None and at > sight.at), default=math.inf)

    def _sites(self, root: Behaviour) -> Iterable[Site]:
        seen = [self.sites[node] for node in looked_at(root) if node in self.sites]
        return [*seen, *(site for site in self.holding if site not in seen)]

    def loops_running(self) -> frozenset[Behaviour]:
        """The children of loops that run now."""
        return frozenset(child for loop in self.loops for child in loop.children if child.status is RUNNING)

    def again(self, before: frozenset[Behaviour], *, written: bool) -> bool:
        """Whether the tree wants the next tick at once.

        A loop whose child has just ended begins it anew at the next tick, and nothing outside would bring that tick.
        Where the count is not bounded, the child must have taken time or written something: else the same would only
        happen again.
        """
        for loop in self.loops:
            if loop.status is not RUNNING:
                continue
            for child in loop.children:
                ended = child.status is not RUNNING
                if ended and (written or child in before or _bounded(loop)):
                    return True
        return False


def _may_begin_again(node: Any) -> bool:
    return isinstance(node, LOOPS) or (isinstance(node, Parallel) and not node.policy.synchronise)


def _bounded(loop: Any) -> bool:
    return isinstance(loop, Retry) or (isinstance(loop, Repeat) and loop.num_success > 0)


def running(node: Any) -> Iterator[Any]:
    """What runs, outer before inner."""
    if node.status is RUNNING:
        yield node
        for child in node.children:
            yield from running(child)


def looked_at(node: Any) -> Iterator[Any]:
    """The nodes at which the next tick may look, if nothing but facts and time change."""
    yield node
    for child in _next(node):
        yield from looked_at(child)


def _next(node: Any) -> list[Any]:
    if node.status is not RUNNING:
        return list(node.children)
    if isinstance(node, Ask):
        return [node.current_child] if node.current_child is not None else []
    if isinstance(node, Sequence | Selector):
        current = node.place()
        return node.children[current : current + 1] if node.memory else node.children[: current + 1]
    if isinstance(node, Parallel) and node.policy.synchronise:
        return [child for child in node.children if child.status is not SUCCESS]
    return list(node.children)
