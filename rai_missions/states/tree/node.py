# SPDX-License-Identifier: Apache-2.0
"""What a node of a behaviour tree is, as an author writes it."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any, ClassVar, TypeAlias

from rai_missions.model import AnyOf, TaggedModel, Text
from rai_missions.states.decision import DecisionSpec, Option
from rai_missions.states.state import TREE

if TYPE_CHECKING:
    from rai_missions.states.tree.behaviour import BehaviourLeaf

__all__ = ("Decorator", "TreeNode", "TreeNodes", "depth")

INSTEAD: Mapping[str, str] = {
    "guard": "; put it in tree.Check(…)",
    "state": "; the nodes of trees are in rai_missions.states.tree: tree.Action(…)",
}
"""The family of what an author in Python gave for a node → what to write."""


class TreeNode(TaggedModel, family=TREE):
    """One word of a tree as data, such as a sequence or a call, with what is below it."""

    limits: ClassVar[bool] = False
    """What is below it ends in time."""
    takes_time: ClassVar[bool] = False
    """It ends no sooner than something has been received, or time has passed."""
    unit: ClassVar[str] = ""
    """Of its number, in words."""

    name: Text = ""
    """For pictures; without it the node is called by its word."""

    @classmethod
    def remedy(cls, data: Any) -> str:
        """The node that a guard, a reference or a state most likely means."""
        is_model, is_reference = isinstance(data, TaggedModel), bool(getattr(data, "__path__", ""))
        family = data.family if is_model else "guard" if is_reference else ""
        return INSTEAD.get(family, super().remedy(data))

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        """The node's children, each with the pointer from here."""
        return iter(())

    def paths(self, path: str = "") -> Iterator[tuple[str, TreeNode]]:
        """This node and all below, outer before inner, each with its path: `sequence/0/child`, empty for this node."""
        yield path, self
        for pointer, child in self.branches():
            yield from child.paths(f"{path}/{pointer}" if path else pointer)

    def question(self) -> DecisionSpec | None:
        """What it asks; None for nothing."""
        return None

    def leads(self, option: str) -> str:
        """Where an answer leads, in words."""
        return "and then the node has succeeded"

    def behaviour(self) -> BehaviourLeaf | None:
        """Itself where it is written in Python."""
        return None

    def words(self) -> str:
        """What it does, as a reviewer must know it."""
        word, value = self.word.replace("_", " "), self.written().get(self.word)
        if isinstance(value, int | float):
            return f"{word} {value:g}{self.unit}" if value != -1 else f"{word} for ever"
        words = f"{word} {value}" if isinstance(value, str) else word
        return f"{words}, {policy.replace('_', ' ')}" if (policy := getattr(self, "policy", "")) else words

    def option_of(self, branch: str) -> Option | None:
        """The option whose answer has led to a branch, which its `answer.…` reads; None where none has."""
        return None


TreeNodes: TypeAlias = Sequence[TreeNode]


class Decorator(TreeNode):
    """Changes what its one child reports."""

    positional: ClassVar[tuple[str, ...]] = ("child",)

    child: AnyOf[TreeNode]
    """The node whose report it changes."""

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        yield type(self).model_fields["child"].alias or "child", self.child


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
