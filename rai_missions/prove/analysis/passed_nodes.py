# SPDX-License-Identifier: Apache-2.0
"""What a tree remembers of nodes that it has passed, and that begin again before anything looks at them.

Rule: such a node is as if it had been stopped. So two states in which a branch was passed in different ways are one.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from typing import Any, NamedTuple, Protocol

from rai_missions.states import tree
from rai_missions.states.tree import TreeNode

__all__ = ("ForgetsNodes", "PassedNodes")

Memories = Mapping[str, Any]
"""Path of a node → what it remembers."""
KEPT = ("run", "end")
"""What a node still remembers once it is stopped."""
ENDS_WITH_CHILD = (
    tree.Decision,
    tree.EternalGuard,
    tree.FailureIsSuccess,
    tree.Inverter,
    tree.OneShot,
    tree.PassThrough,
    tree.Repeat,
    tree.Retry,
    tree.RunningIsFailure,
    tree.RunningIsSuccess,
    tree.StatusToBlackboard,
    tree.SuccessIsFailure,
    tree.Timeout,
)
"""Where the child of such a node has ended, the node has ended as well, or the child begins again in the same step."""


class ForgetsNodes(Protocol):
    """Whatever knows what of a tree makes no difference any more."""

    def forgotten(self, memories: Memories) -> Memories:
        """What the tree remembers but for that."""


class Steps(NamedTuple):
    """A sequence or selector that continues at the child that runs: while it runs, those before have been passed."""

    path: str
    children: tuple[tuple[str, ...], ...]
    """Of each child its path and those of all below it."""

    def passed(self, memories: Memories) -> Iterable[str]:
        """The paths of what has been passed."""
        memory = memories.get(self.path)
        if memory is None or memory["status"] != "running":
            return ()
        return (path for child in self.children[: memory["child"]] for path in child)


class Branches(NamedTuple):
    """A parallel that does not tick a child again that has succeeded: while it runs, all below that was passed."""

    path: str
    children: tuple[tuple[str, ...], ...]

    def passed(self, memories: Memories) -> Iterator[str]:
        """See `Steps`; a child itself remembers that it has succeeded."""
        memory = memories.get(self.path)
        if memory is None or memory["status"] != "running":
            return
        for top, *below in self.children:
            child = memories.get(top)
            if child is not None and child["status"] == "success":
                yield from below


class PassedNodes:
    """The nodes of one tree that were passed: what they remember makes no difference.

    Why what they remember makes no difference. While `Steps` and `Branches` run, no tick comes by, and nothing that is
    there is listened to. Such a node begins again by stopping its children; where it leaves that out (`renews` in
    `engine.trees`), a tick comes to the same. A selector stops what it has passed with its next tick anyway. Once the
    node has ended, it could be looked at where it was left: what it listens to depends on what it remembers. So this
    holds where each node around it ends with it or begins it again in the same step: `ENDS_WITH_CHILD`, and `Steps` and
    `Branches` themselves. At the limit of rounds in a step, what was passed has begun again since.

    Args:
        root: The tree.
    """

    def __init__(self, root: TreeNode) -> None:
        self._composites = tuple(_composites(root, ""))

    def forgotten(self, memories: Memories) -> Memories:
        """What the tree remembers with what was passed as if it had been stopped; the same where nothing was."""
        stopped = dict[str, Any]()
        for each in self._composites:
            for path in each.passed(memories):
                memory = memories.get(path)
                if memory is not None and memory != (left := _once_stopped(memory)):
                    stopped[path] = left
        if not stopped:
            return memories
        return {path: memory for path, memory in {**memories, **stopped}.items() if memory is not None}


def _composites(node: TreeNode, path: str) -> Iterator[Steps | Branches]:
    """The composites whose ends nothing looks at, outer before inner."""
    branches = [(f"{path}/{pointer}" if path else pointer, child) for pointer, child in node.branches()]
    below = tuple(tuple(inner for inner, _ in child.paths(place)) for place, child in branches)
    if isinstance(node, tree.Sequence | tree.Selector) and node.memory:
        yield Steps(path, below)
    elif isinstance(node, tree.Parallel) and node.synchronise and node.policy != "success_on_one":
        yield Branches(path, below)
    elif not isinstance(node, ENDS_WITH_CHILD):
        return
    for place, child in branches:
        yield from _composites(child, place)


def _once_stopped(memory: Mapping[str, Any]) -> Mapping[str, Any] | None:
    """What a node remembers once it is stopped; None for nothing."""
    kept = {word: memory[word] for word in KEPT if word in memory}
    return {"status": "invalid", **kept} if kept else None
