# SPDX-License-Identifier: Apache-2.0
"""What a run listens to while trees run: a set of names that is worked out where one is asked for."""

from __future__ import annotations

from collections.abc import Iterator
from collections.abc import Set as AbstractSet
from typing import Any

from rai_missions.engine.activities.activity import Machine, listens

__all__ = ("WatchedNames",)


class WatchedNames(AbstractSet[str]):
    """Names of keys, and of states by their `presence`. A tree is asked about one name, not for all that it reads.

    Args:
        names: What is listened to but for trees.
        trees: The machines of the trees that run, each with its state.
    """

    __slots__ = ("names", "trees")

    def __init__(self, names: frozenset[str], trees: tuple[tuple[Machine, Any], ...]) -> None:
        self.names, self.trees = names, trees

    @classmethod
    def _from_iterable(cls, names: Any) -> Any:
        return frozenset(names)

    def __contains__(self, name: object) -> bool:
        return name in self.names or any(listens(machine, state, (str(name),)) for machine, state in self.trees)

    def __iter__(self) -> Iterator[str]:
        return iter(self.all())

    def __len__(self) -> int:
        return len(self.all())

    def all(self) -> frozenset[str]:
        """Every name."""
        return self.names.union(*(machine.reads(state) for machine, state in self.trees))

    def __repr__(self) -> str:
        return repr(self.all())

    __hash__ = None  # type: ignore[assignment]
