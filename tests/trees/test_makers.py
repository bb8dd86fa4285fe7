# SPDX-License-Identifier: Apache-2.0
"""Each kind of node has one way to become a behaviour."""

from __future__ import annotations

from rai_missions.states import tree
from rai_missions.trees.builder import MAKERS


def test_each_kind_of_node_has_its_maker() -> None:
    assert set(MAKERS) == {*tree.TreeNode.kinds.values(), tree.Behaviour}
