# SPDX-License-Identifier: Apache-2.0
"""Trees as authors write them."""

from __future__ import annotations

import re
from typing import Any

import jsonschema
import pytest
from hypothesis import given

from rai_missions.engine.activities.ticker import TreeState
from rai_missions.errors import DefinitionError
from rai_missions.mission.schema import mission_schema
from rai_missions.states import tree as t
from rai_missions.states.tree import TreeNode
from rai_missions.trees import PyTrees
from tests.trees.growing import rich_trees, seen

SCHEMA = jsonschema.Draft202012Validator(mission_schema())


@given(rich_trees)
def test_a_tree_reads_as_it_was_written(tree: Any) -> None:
    root = TreeNode.read(tree)
    assert TreeNode.read(root.written()) == root


@given(rich_trees)
def test_every_path_leads_to_its_node(tree: Any) -> None:
    for path, node in TreeNode.read(tree).paths():
        place: Any = tree
        for word in filter(None, path.split("/")):
            place = place[int(word)] if isinstance(place, list) else place[word]
        assert TreeNode.read(place) == node


def test_python_and_json_state_the_same() -> None:
    python = t.Selector([
        t.Sequence([t.Check({"fresh": "obstacle"}), t.Inverter(t.Action("drive"))], memory=False),
        t.Retry(t.Timeout(t.Call("horn"), 2.0), 3),
        t.OneShot(t.Set("n", 1)),
    ])  # fmt: skip
    json = {"selector": [
        {"sequence": [{"check": {"fresh": "obstacle"}}, {"inverter": {"action": "drive"}}], "memory": False},
        {"retry": 3, "child": {"timeout": 2.0, "child": {"call": "horn"}}},
        {"one_shot": {"set": "n", "value": 1}},
    ]}  # fmt: skip
    assert python.written() == json
    assert TreeNode.read(json) == python


@pytest.mark.parametrize(
    ("tree", "sentence"),
    [
        ({"sequnce": []}, "no tree node is written ['sequnce']; did you mean 'sequence'?"),
        ({"check": {"in": "s"}, "wait_s": 1}, "a tree node is one thing, this is 2: check, wait_s; keep one"),
        ({"parallel": [{"wait_s": 1}], "policy": [1]}, "'policy' names child 1; the children have the numbers 0 to 0"),
        ({"set": "n"}, "'set' takes one of value, from, add"),
        ({"set": "n", "value": [{"from": "m"}]}, "'m' is a reference inside a value"),
        (
            {"decision": {"question": "?", "options": {"left": {}}}, "then": {"lft": {"wait_s": 1}}},
            "'then' has a subtree for 'lft', which is no option; did you mean 'left'?",
        ),
    ],
)
def test_a_fault_is_reported_with_a_remedy(tree: Any, sentence: str) -> None:
    with pytest.raises(DefinitionError, match=re.escape(sentence)):
        t.Tree(tree)


@pytest.mark.parametrize(
    "tree", [{"sequence": []}, {"retry": 0, "child": {"wait_s": 1}}, {"repeat": -2, "child": {"wait_s": 1}}]
)
def test_a_tree_that_means_nothing_is_refused(tree: Any) -> None:
    with pytest.raises(DefinitionError):
        t.Tree(tree)


def test_a_tree_that_is_too_deep_is_refused_and_one_that_is_not_is_ticked() -> None:
    deep: Any = {"wait_s": 1}
    for _ in range(49):
        deep = {"sequence": [deep]}
    ticker = PyTrees().compile(t.Tree(deep).tree, "/tree", {}, "s")
    assert ticker.tick(TreeState(), seen(0.0, {}), {}).status == "running"
    with pytest.raises(DefinitionError, match="nested 101 deep, and at most 100 can be read; make states of its parts"):
        t.Tree({"sequence": [deep]})


@given(rich_trees)
def test_the_schema_takes_what_the_models_take(tree: Any) -> None:
    mission = {"format": 1, "name": "m", "initial": "work", "states": {"work": {"tree": tree}}}
    assert list(SCHEMA.iter_errors(mission)) == []


@pytest.mark.parametrize(
    "tree", [{"sequence": []}, {"retry": 0, "child": {"wait_s": 1}}, {"inverter": {}}, {"wait_s": 1, "s": 2}]
)
def test_the_schema_refuses_what_the_models_refuse(tree: Any) -> None:
    mission = {"format": 1, "name": "m", "initial": "work", "states": {"work": {"tree": tree}}}
    assert list(SCHEMA.iter_errors(mission))
