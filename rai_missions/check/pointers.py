# SPDX-License-Identifier: Apache-2.0
"""Where the parts of guards, templates and trees are: JSON pointers (RFC 6901) in the mission."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rai_missions.guards import Guard
from rai_missions.states.decision import Option
from rai_missions.states.tree import DecisionLeaf, Timeout, TreeNode

__all__ = ("NodeRef", "guard_parts", "pointer", "template_reads", "tree_nodes")


def pointer(place: str, *words: object) -> str:
    """A place inside another."""
    return "/".join([place, *(str(word).replace("~", "~0").replace("/", "~1") for word in words)])


def guard_parts(guard: Guard, place: str) -> Iterator[tuple[str, Guard]]:
    """The guard and all inside it, outermost first, each with its place."""
    stack = [(place, guard)]
    while stack:
        here, part = stack.pop()
        yield here, part
        stack += reversed(list(part.inside(here)))


def template_reads(template: Any, place: str) -> Iterator[tuple[str, str]]:
    """The paths that a template takes values from, each with its place."""
    stack = [(place, template)]
    while stack:
        here, item = stack.pop()
        if isinstance(item, Mapping):
            if len(item) == 1 and isinstance(item.get("from"), str):
                yield item["from"], f"{here}/from"
            else:
                stack += [(pointer(here, name), item[name]) for name in reversed(list(item))]
        elif isinstance(item, list | tuple):
            stack += [(f"{here}/{index}", item[index]) for index in range(len(item) - 1, -1, -1)]


class NodeRef(NamedTuple):
    """A node of a tree where it is."""

    node: TreeNode
    place: str
    timed: bool
    """A `timeout` around it bounds it."""
    option: Option | None
    """The innermost option under whose `then` it is."""


def tree_nodes(root: TreeNode, place: str) -> Iterator[NodeRef]:
    """Every node, outer before inner."""
    stack = [NodeRef(root, place, False, None)]
    while stack:
        here = stack.pop()
        yield here
        timed = here.timed or isinstance(here.node, Timeout)
        for path, child in reversed(list(here.node.branches())):
            option = here.option
            if isinstance(here.node, DecisionLeaf):
                option = here.node.decision.options.get(path.partition("/")[2])
            stack.append(NodeRef(child, f"{here.place}/{path}", timed, option))
