# SPDX-License-Identifier: Apache-2.0
"""What a node of a behaviour tree is, as an author writes it."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, ClassVar

from rai_missions.model import OneOf, TaggedModel, Text
from rai_missions.states.decision import Option

__all__ = ("Decorator", "TreeNode", "depth", "tree_paths")


class TreeNode(TaggedModel, family="tree node"):
    """A node of a tree."""

    limits: ClassVar[bool] = False
    """What is below it ends in time."""

    name: Text = ""
    """For pictures; without it the node is called by its word."""

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        """Its children, each with the pointer from here."""
        return iter(())

    def option_of(self, branch: str) -> Option | None:
        """The option whose answer has led to a branch, which its `answer.…` reads; None where none has."""
        return None


class Decorator(TreeNode):
    """Changes what its one child says."""

    positional: ClassVar[tuple[str, ...]] = ("child",)

    child: OneOf[TreeNode]

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        yield type(self).model_fields["child"].alias or "child", self.child


def tree_paths(root: TreeNode, path: str = "") -> Iterator[tuple[str, TreeNode]]:
    """Every node, outer before inner, with its path from the root: `sequence/0/child`; the root's own is empty."""
    yield path, root
    for pointer, child in root.branches():
        yield from tree_paths(child, f"{path}/{pointer}" if path else pointer)


def depth(given: Any) -> int:
    """How deep objects and lists are nested in one another; a node counts as the two that it is written as."""
    deepest, rest = 0, [(given, 1)]
    while rest:
        item, level = rest.pop()
        inner: Any = item.values() if isinstance(item, dict) else item
        if isinstance(item, TreeNode):
            inner, level = [child for _, child in item.branches()], level + 1
        if isinstance(item, TreeNode | dict | list | tuple):
            deepest = max(deepest, level)
            rest += [(each, level + 1) for each in inner]
    return deepest
