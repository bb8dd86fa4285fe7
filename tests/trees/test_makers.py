# SPDX-License-Identifier: Apache-2.0
"""Each kind of node has one way to be compiled, and one to become a behaviour of py_trees."""

from __future__ import annotations

import pytest

from rai_missions.engine.trees import build
from rai_missions.states import tree
from rai_missions.trees import builder


@pytest.mark.parametrize("makers", [build.MAKERS, builder.MAKERS], ids=["compiled", "py_trees"])
def test_each_kind_of_node_has_its_maker(makers: object) -> None:
    assert set(makers) == {*tree.TreeNode.kinds.values(), tree.Behaviour}  # type: ignore[call-overload]
