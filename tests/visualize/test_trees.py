# SPDX-License-Identifier: Apache-2.0
"""Behaviour trees in pictures: the order of a node's children is their meaning, so it is numbered and kept.

Rule: where a node lies is read from the laid-out SVG. Every node of a tree gets a name of its own, by which its text is
found.
"""

from __future__ import annotations

import itertools
import xml.etree.ElementTree as ElementTree
from typing import NamedTuple

from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.mission.mission import Mission
from tests.rigs.laws import drill
from tests.strategies import mission_documents
from tests.visualize.tree_documents import Child, Json, crowded, named, numbers, walk, written_trees
from visualize import drawn
from visualize.build import picture
from visualize.graphviz import render
from visualize.page.chart_data import chart_data

SVG = "{http://www.w3.org/2000/svg}"


class At(NamedTuple):
    """Where a text begins on the sheet, in points."""

    x: float
    y: float
    text: str


def label(node: Child, message: str) -> bool:
    """Whether a line of text begins a node's label."""
    number = f"{node.number}. " if node.number else ""
    return any(message.startswith(f"{number}{sign}{node.name}:") for sign in ("", "→ ", "? "))


def texts(svg: bytes) -> list[At]:
    return [
        At(float(each.get("x", "0")), float(each.get("y", "0")), "".join(each.itertext()).replace("\u00a0", " "))
        for each in ElementTree.fromstring(svg).iter(f"{SVG}text")
    ]


def assert_in_order(placed: list[At], node: Child) -> None:
    """A node's children lie below it, each right of the one before, and bear their numbers."""
    found = [next(at for at in placed if label(each, at.text)) for each in (node, *node.below)]
    above, below = found[0], found[1:]
    assert all(at.y > above.y for at in below), found
    assert all(one.x < other.x for one, other in itertools.pairwise(below)), found
    for child in node.below:
        assert_in_order(placed, child)


def assert_lines_in_order(message: str, trees: list[Child]) -> None:
    """In a text each node comes after the one before it in the file."""
    names = [each.name for tree in trees for each in walk(tree)]
    places = [message.index(name) for name in names]
    assert places == sorted(places), message


def assert_drawn_in_order(document: Json) -> None:
    """In SVG, DOT and Mermaid, and in what the page draws from."""
    names = numbers()
    trees = [named(tree, names) for tree in written_trees(document)]
    mission = Mission.model_validate(document)
    shown = picture(mission)
    placed = texts(render(shown, "svg"))
    for tree in trees:
        assert_in_order(placed, tree)
    for form in ("dot", "mmd"):
        assert_lines_in_order(drawn(shown, form).decode().replace("#95;", "_"), trees)
    page = [twig for state in chart_data(shown, mission)["states"] for twig in state.get("twigs", ())]
    nodes = [each for tree in trees for each in walk(tree)]
    assert [(twig["text"].partition(":")[0], twig.get("number", 0)) for twig in page] == [
        (each.name, each.number) for each in nodes
    ]


many = settings(max_examples=20, suppress_health_check=[HealthCheck.too_slow])


@many
@given(st.one_of(crowded(), mission_documents()))
def test_children_are_drawn_in_the_order_of_the_file(document: Json) -> None:
    assert_drawn_in_order(document)


test_children_are_drawn_in_the_order_of_the_file_in_many_missions = drill(
    assert_drawn_in_order, st.one_of(crowded(), mission_documents()), tried=settings(parent=many, max_examples=2000)
)


def test_a_check_before_a_retry_is_drawn_before_it() -> None:
    """The smallest: a tree in a region, with transitions to a sibling, whose second child is the deepest."""
    deep = {"retry": 2, "child": {"sequence": [{"check": {"key": "near", "==": True}}, {"wait_s": 3}]}}
    tree = {"sequence": [{"check": {"key": "clear", "==": True}}, deep, {"set": "count", "add": 1}]}
    inspecting = {"tree": tree, "timeout_s": 30, "transitions": [{"on": "succeeded", "to": "seen"}]}
    keys = {name: {"type": "boolean", "source": "robot", "max_age_s": 1} for name in ("clear", "near")}
    assert_drawn_in_order(
        {
            "format": 1,
            "name": "warehouse",
            "version": "1.0.0",
            "initial": "working",
            "blackboard": {**keys, "count": {"type": "integer", "source": "mission", "initial": 0}},
            "states": {
                "working": {
                    "parallel": {
                        "patrol": {
                            "initial": "inspecting",
                            "states": {"inspecting": inspecting, "seen": {"final": "succeeded"}},
                        },
                        "energy": {"initial": "fine", "states": {"fine": {}}},
                    }
                }
            },
        }
    )
