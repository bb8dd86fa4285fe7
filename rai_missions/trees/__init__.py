# SPDX-License-Identifier: Apache-2.0
"""Behaviour trees on py_trees: the only door to it.

Rule: py_trees is loaded when the first tree is compiled. Its clock, its blackboard and its threads are never used.

Imports `engine`, `guards` and `states`, and the modules of the root.
"""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.engine.activities.ticker import Ticker
from rai_missions.keys import Key
from rai_missions.states.tree import TreeNode

__all__ = ("PyTrees",)


class PyTrees:
    """Compiles trees for a chart: `Chart(mission, ticker=PyTrees())`."""

    def compile(self, root: TreeNode, place: str, keys: Mapping[str, Key], state: str) -> Ticker:
        from rai_missions.trees.ticker import TreeTicker  # brings py_trees, which missions without trees do not need

        return TreeTicker(root, place, keys, state)
