# SPDX-License-Identifier: Apache-2.0
"""What goes round in a graph: its strongly connected parts (R. Tarjan 1972), without recursion."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TypeVar

__all__ = ("knots",)

Node = TypeVar("Node")


def knots(follows: Mapping[Node, Sequence[Node]]) -> list[list[Node]]:
    """The parts within which every node leads to every other, those of a single node too.

    Args:
        follows: Node → the nodes that come right after it; each of them is a key as well.

    Returns:
        The parts, each and all of them in the order of the keys.
    """
    order = {node: index for index, node in enumerate(follows)}
    number: dict[Node, int] = {}
    low: dict[Node, int] = {}
    stack: list[Node] = []
    waiting: set[Node] = set()
    found: list[list[Node]] = []
    for root in follows:
        work = [(root, iter(follows[root]))] if root not in number else []
        while work:
            node, successors = work[-1]
            if node not in number:
                number[node] = low[node] = len(number)
                stack.append(node)
                waiting.add(node)
            following = next((each for each in successors if each not in number), None)
            if following is not None:
                work.append((following, iter(follows[following])))
                continue
            work.pop()
            low[node] = min([low[node], *(low[each] for each in follows[node] if each in waiting)])
            if low[node] == number[node]:
                knot = _cut(stack, node)
                waiting.difference_update(knot)
                found.append(sorted(knot, key=order.__getitem__))
    return sorted(found, key=lambda knot: order[knot[0]])


def _cut(stack: list[Node], last: Node) -> list[Node]:
    """Take off the top of a stack, down to and with one."""
    taken = [stack.pop()]
    while taken[-1] is not last:
        taken.append(stack.pop())
    return taken
