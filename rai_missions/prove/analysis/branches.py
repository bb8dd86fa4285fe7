# SPDX-License-Identifier: Apache-2.0
"""The waits and timeouts of one tree: which of them can be over first.

Rule: those that began together, or at the end of one of the same group, are over in the order of their durations. What
begins at any other instant begins after an unknown time, in which those before it may have come near to their ends.
"""

from __future__ import annotations

from collections.abc import Collection, Iterator, Mapping
from typing import Any

from rai_missions.engine.activities.tree import TreeActivity

__all__ = ("Groups", "firsts", "groups_key", "parted", "passed")

Groups = tuple[frozenset[str], ...]
"""Paths of what waits in a tree, in groups. Of one before another, what is left of its time is at the most what is
noted; of the last one it is known how much was left when it became the last."""


def groups_key(groups: Mapping[str, Groups]) -> list[tuple[str, list[list[str]]]]:
    """What distinguishes the groups of several trees, by the state that each runs in."""
    return [(name, [sorted(each) for each in found]) for name, found in sorted(groups.items())]


def _until(nodes: Mapping[str, Mapping[str, Any]], group: Collection[str]) -> float:
    return min(float(nodes[path]["until"]) for path in group)


def firsts(state: TreeActivity, groups: Groups) -> Iterator[tuple[frozenset[str], bool]]:
    """The groups of which something can be over before all else: not if one before it is over by then.

    Returns:
        Each group, and whether it can be over alone; if not, it can be at the same instant as one before it.
    """
    nodes, soonest = state.tree.nodes, float("inf")
    for group in groups:
        until = _until(nodes, group)
        if until <= soonest:
            yield group, until < soonest
            soonest = until


def passed(state: TreeActivity, group: Collection[str], now: float) -> TreeActivity:
    """The state once the first of a group is over; how long that took is not known of the others."""
    nodes = dict(state.tree.nodes)
    late = now - _until(nodes, group)
    for path in group:
        nodes[path] = {**nodes[path], "until": nodes[path]["until"] + late}
    return state._replace(tree=state.tree._replace(nodes=nodes), wake=now)


def parted(state: TreeActivity, groups: Groups, begun: Collection[str], over: Collection[frozenset[str]]) -> Groups:
    """The groups after a step; none where one is left.

    Args:
        state: The tree's state.
        groups: The groups before it; none for one.
        begun: The paths of what has begun in it.
        over: The groups of which something was over; an empty one is the only one.
    """
    waiting = {path for path, memory in state.tree.nodes.items() if "until" in memory}
    old, new = frozenset(waiting.difference(begun)), frozenset(waiting.intersection(begun))
    before = groups or (old,)
    ended = {groups.index(each) if each else 0 for each in over}
    together = new.union(*(before[at] & old for at in ended))
    found = [*(each & old for at, each in enumerate(before) if at not in ended), together]
    found = [each for each in found if each]
    return tuple(found) if len(found) > 1 else ()
