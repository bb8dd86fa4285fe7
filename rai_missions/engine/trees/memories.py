# SPDX-License-Identifier: Apache-2.0
"""What the nodes of a compiled tree remember, as a mapping that shares with the one before all that has not changed.

Rule: once made, it is never changed. A tick copies the parts in which a node has changed, and no others.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

__all__ = ("PART", "NodeMemories", "Paths")

PART = 64
"""Nodes a part: a change copies one part and the list of parts."""
Part = list[Any]


class Paths:
    """The nodes of one tree by number, outer before inner.

    Args:
        paths: The path of each.
    """

    __slots__ = ("numbers", "paths")

    def __init__(self, paths: tuple[str, ...]) -> None:
        self.paths = paths
        self.numbers = {path: number for number, path in enumerate(paths)}


class NodeMemories(Mapping[str, Any]):
    """Path → what the node there remembers; a node that has never run is left out.

    Args:
        paths: The paths of the tree.
        parts: What the nodes remember by number, `PART` of them each; None for nothing.
    """

    __slots__ = ("parts", "paths")

    def __init__(self, paths: Paths, parts: list[Part]) -> None:
        self.paths, self.parts = paths, parts

    def __getitem__(self, path: str) -> Any:
        number = self.paths.numbers[path]
        found = self.parts[number // PART][number % PART]
        if found is None:
            raise KeyError(path)
        return found

    def __iter__(self) -> Iterator[str]:
        every = (memory for part in self.parts for memory in part)
        return (path for path, memory in zip(self.paths.paths, every, strict=True) if memory is not None)

    def __len__(self) -> int:
        return sum(memory is not None for part in self.parts for memory in part)

    def __eq__(self, other: object) -> bool:
        if isinstance(other, NodeMemories) and other.paths is self.paths:
            return self.parts == other.parts  # lists compare what they share by identity first
        return dict(self) == dict(other) if isinstance(other, Mapping) else NotImplemented

    __hash__ = None  # type: ignore[assignment]

    def __repr__(self) -> str:
        return repr(dict(self))

    def __reduce__(self) -> Any:
        return dict, (dict(self),)
