# SPDX-License-Identifier: Apache-2.0
"""Nodes with several children, under py_trees' names."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from typing import Annotated, Literal, Self

from pydantic import Field, model_validator

from rai_missions.model import AnyOf, Bool, Integer, fault
from rai_missions.states.tree.node import TreeNode, TreeNodes

__all__ = ("Branch", "ParallelTree", "Selector", "Sequence")


Children = Annotated[tuple[AnyOf[TreeNode], ...], Field(min_length=1)]
Policy = Literal["success_on_all", "success_on_one"]
Numbers = Annotated[tuple[Integer, ...], Field(min_length=1)]


class Branch(TreeNode):
    """A composite: it has children."""

    def children(self) -> tuple[TreeNode, ...]:
        """In the order written."""
        given: tuple[TreeNode, ...] = getattr(self, self.word)
        return given

    def branches(self) -> Iterator[tuple[str, TreeNode]]:
        for index, child in enumerate(self.children()):
            yield f"{self.word}/{index}", child


class Sequence(Branch, word="sequence"):
    """One after the other, until one fails."""

    sequence: Children
    """The children, in this order."""
    memory: Bool = True
    """Continues at the running child; without it, from the first at each tick."""

    def __init__(self, sequence: TreeNodes, *, memory: bool = True, name: str = "") -> None: ...

    def words(self) -> str:
        return "sequence" if self.memory else "sequence without memory"


class Selector(Branch, word="selector"):
    """One after the other, until one succeeds."""

    selector: Children
    """The children, the preferred one first."""
    memory: Bool = False
    """Continues at the running child; without it, a higher one that stops failing takes over."""

    def __init__(self, selector: TreeNodes, *, memory: bool = False, name: str = "") -> None: ...

    def words(self) -> str:
        return "selector with memory" if self.memory else "selector"


class ParallelTree(Branch, word="parallel"):
    """All at each tick; fails with the first that fails."""

    parallel: Children
    """The children."""
    policy: Policy | Numbers = "success_on_all"
    """Whose success is enough: all, one, or the children with these numbers (from 0)."""
    synchronise: Bool = True
    """A child that has succeeded is not ticked again. With `success_on_one` there is no such child."""

    def __init__(
        self,
        parallel: TreeNodes,
        *,
        policy: Policy | Iterable[int] = "success_on_all",
        synchronise: bool = True,
        name: str = "",
    ) -> None: ...

    def words(self) -> str:
        policy = self.policy if isinstance(self.policy, str) else f"success on {', '.join(map(str, self.policy))}"
        return f"parallel, {policy.replace('_', ' ')}" + ("" if self.synchronise else ", not synchronised")

    @model_validator(mode="after")
    def _policy_names_children(self) -> Self:
        if isinstance(self.policy, tuple):
            last = len(self.parallel) - 1
            for number in self.policy:
                if not 0 <= number <= last:
                    raise fault(
                        "policy",
                        f"'policy' names child {number}; the children have the numbers 0 to {last}",
                        at=("policy",),
                    )
        return self
