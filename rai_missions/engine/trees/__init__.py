# SPDX-License-Identifier: Apache-2.0
"""Behaviour trees that are data, compiled: each node is made once, with its guard, and a tick visits what can change.

Rule: a node does what py_trees' node of the same name does; `rai_missions.trees` ticks the same trees on py_trees, and
tests hold the two together. Where a node skips a child, its docstring names why a tick of it would change nothing.

Imports `engine.activities`, `guards` and `states`, and the modules of the root.
"""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.engine.activities.ticker import Ticker
from rai_missions.engine.trees.ticker import CompiledTicker
from rai_missions.keys import Key
from rai_missions.states.tree import TreeNode

__all__ = ("CompiledTrees",)


class CompiledTrees:
    """Compiles trees for a chart; what a chart uses unless it is given another."""

    def compile(self, root: TreeNode, place: str, keys: Mapping[str, Key], state: str) -> Ticker:
        return CompiledTicker(root, place, keys, state)
