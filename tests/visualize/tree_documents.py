# SPDX-License-Identifier: Apache-2.0
"""Generated missions with behaviour trees as they are written, and what their files report about the order of nodes."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

from hypothesis import strategies as st

from tests.strategies import KEYS, tree_nodes

__all__ = ("Child", "Json", "crowded", "named", "numbers", "walk", "written_trees")

Json = dict[str, Any]


class Child(NamedTuple):
    """A node of a tree as the file has it: its name, the place among its siblings, and what is below it."""

    name: str
    number: int
    """From 1; 0 for an only child and below a decision."""
    below: tuple[Child, ...]


def named(node: Json, names: Iterator[str], number: int = 0) -> Child:
    """Give each node of a written tree a name of its own; returns what the file then reports."""
    node["name"] = next(names)
    inside = next((node[word] for word in ("sequence", "selector", "parallel") if isinstance(node.get(word), list)), [])
    if inside:
        many = len(inside) > 1
        children = [named(child, names, place * many) for place, child in enumerate(inside, 1)]
    elif isinstance(node.get("decision"), dict):
        children = [named(child, names) for child in node.get("then", {}).values()]
    else:
        words = ("child", "inverter", "failure_is_success")
        children = [named(node[word], names) for word in words if isinstance(node.get(word), dict)]
    return Child(node["name"], number, tuple(children))


def written_trees(document: Json) -> Iterator[Json]:
    """Every tree of a mission's document, in the order of the file."""
    for word in ("states", "parallel"):
        for state in document.get(word, {}).values():
            if "tree" in state:
                yield state["tree"]
            yield from written_trees(state)


def numbers() -> Iterator[str]:
    """Names that no text of a mission has."""
    return (f"node_{number:03}" for number in range(1, 1000))


def walk(node: Child) -> Iterator[Child]:
    yield node
    for child in node.below:
        yield from walk(child)


@st.composite
def crowded(draw: st.DrawFn) -> Json:
    """Missions whose trees are broad and deep, inside a region, with transitions to siblings and back."""
    broad = st.lists(tree_nodes(depth=1), min_size=2, max_size=5)
    count, word = draw(st.integers(1, 3)), st.sampled_from(["sequence", "selector", "parallel"])
    names = [f"tree{number}" for number in range(1, count + 1)]
    states: Json = {"first": {"transitions": [{"on": "poke", "to": name} for name in names]}, "seen": {}}
    for name in names:
        targets = draw(st.lists(st.sampled_from(["first", "seen", *names]), min_size=1, max_size=3, unique=True))
        ends = ["succeeded", "failed", "timed_out"]
        transitions = [{"on": end, "to": target} for end, target in zip(ends, targets, strict=False)]
        states[name] = {"tree": {draw(word): draw(broad)}, "timeout_s": 30, "transitions": transitions}
    region: Json = {"initial": "first", "states": states}
    other: Json = {"initial": "idle", "states": {"idle": {"transitions": [{"on": "poke", "to": "busy"}]}, "busy": {}}}
    return {
        "format": 1, "name": "crowded", "version": "1.0.0", "initial": "working", "events": {"poke": {}, "halt": {}},
        "blackboard": KEYS, "states": {"working": {"parallel": {"patrol": region, "energy": other}},
                                       "stopped": {"final": "aborted"}},
        "transitions": [{"on": "halt", "to": "stopped"}],
    }  # fmt: skip
