# SPDX-License-Identifier: Apache-2.0
"""What a run watches while trees run: a set of names that is worked out where one is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from typing import Any

from rai_missions.engine.activities.tree import TreeActivity, TreeMachine

__all__ = ("RunningTree", "WatchedNames")

RunningTree = tuple[str, TreeMachine, TreeActivity]
"""A state, the machine of its tree and what that remembers."""


class WatchedNames(AbstractSet[str]):
    """Names of keys, and of states by their `presence`. A tree is asked about one name, not for all that it reads.

    Args:
        names: What is watched but for trees.
        trees: Those that run.
    """

    __slots__ = ("names", "trees")

    def __init__(self, names: frozenset[str], trees: tuple[RunningTree, ...]) -> None:
        self.names, self.trees = names, trees

    def with_tree(self, tree: RunningTree) -> WatchedNames:
        """These names with a tree's state replaced by a later one."""
        trees = self.trees
        if len(trees) == 1:
            return WatchedNames(self.names, (tree,))
        return WatchedNames(self.names, tuple([tree if each[0] == tree[0] else each for each in trees]))

    @classmethod
    def _from_iterable(cls, names: Any) -> Any:
        return frozenset(names)

    def __contains__(self, name: object) -> bool:
        return name in self.names or any(machine.watches(state, (str(name),)) for _, machine, state in self.trees)

    def __bool__(self) -> bool:
        return True  # a tree runs; what it looks at is asked for by name

    def __iter__(self) -> Iterator[str]:
        return iter(self.all())

    def __len__(self) -> int:
        return len(self.all())

    def all(self) -> frozenset[str]:
        """Every name."""
        return self.names.union(*(machine.reads(state) for _, machine, state in self.trees))

    def __repr__(self) -> str:
        return repr(self.all())

    __hash__ = None  # type: ignore[assignment]
