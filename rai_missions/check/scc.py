# SPDX-License-Identifier: Apache-2.0
"""What goes round in a graph: its strongly connected parts (R. Tarjan 1972), without recursion."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import TypeVar

__all__ = ("knots",)

Node = TypeVar("Node")


def knots(follows: Mapping[Node, Iterable[Node]]) -> list[list[Node]]:
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
        work = [root] if root not in number else []
        successors: dict[Node, Iterator[Node]] = {}
        while work:
            node = work[-1]
            if node not in number:
                number[node] = low[node] = len(number)
                stack.append(node)
                waiting.add(node)
                successors[node] = iter(follows[node])
            for following in successors[node]:
                if following not in number:
                    work.append(following)
                    break
                if following in waiting:
                    low[node] = min(low[node], number[following])
            else:
                work.pop()
                if work:
                    low[work[-1]] = min(low[work[-1]], low[node])
                if low[node] == number[node]:
                    found.append(sorted(_cut(stack, waiting, node), key=order.__getitem__))
    return sorted(found, key=lambda knot: order[knot[0]])


def _cut(stack: list[Node], waiting: set[Node], last: Node) -> list[Node]:
    """Take off the top of a stack, down to and with one."""
    taken: list[Node] = []
    while not taken or taken[-1] is not last:
        taken.append(stack.pop())
        waiting.discard(taken[-1])
    return taken
