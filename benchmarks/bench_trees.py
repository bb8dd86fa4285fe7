# SPDX-License-Identifier: Apache-2.0
"""What a tick of a behaviour tree costs, next to plain py_trees: `python -m benchmarks.bench_trees`.

The same trees in both: a sequence of checks and an action that runs, and selectors in which a high branch fails at each
tick. py_trees' checks read a Python dict; its own blackboard would add 1.7 µs each. Ours restores the tree from its
state, ticks it and reads it back; `kept` is a state that the ticker saw last, `restored` is another.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import py_trees

from benchmarks.figures import figure
from rai_missions.engine.activities.ticker import TreeState
from rai_missions.guards.guard import Truth
from rai_missions.keys import Stamped
from rai_missions.states.tree import TreeNode
from rai_missions.trees import PyTrees

SIZES = (4, 16, 64)
"""Leaves."""
TICKS, ROUNDS = 300, 7
Status = py_trees.common.Status


class View(NamedTuple):
    at: float
    board: Mapping[str, Stamped]
    active: frozenset[str] = frozenset()
    entered: Mapping[str, float] = {}
    held: Mapping[str, float] = {}
    event: Mapping[str, Any] = {}
    answer: Mapping[str, Any] = {}

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        return None


def tree(leaves: int) -> dict[str, Any]:
    """Selectors of a guarded branch and the next one, four leaves each; at the end an action that runs."""
    inner: dict[str, Any] = {"action": "work"}
    for _ in range(leaves // 4):
        ready = [{"check": {"key": "ready", "==": True}} for _ in range(2)]
        guarded = {"sequence": [{"check": {"key": "alarm", "==": True}}, {"action": "stop"}]}
        inner = {"selector": [guarded, {"sequence": [*ready, inner], "memory": False}]}
    return inner


class Check(py_trees.behaviour.Behaviour):
    def __init__(self, facts: dict[str, bool], key: str) -> None:
        super().__init__("check")
        self.facts, self.key = facts, key

    def update(self) -> Status:
        return Status.SUCCESS if self.facts[self.key] else Status.FAILURE


class Action(py_trees.behaviour.Behaviour):
    def update(self) -> Status:
        return Status.RUNNING


def grown(node: Any, facts: dict[str, bool]) -> py_trees.behaviour.Behaviour:
    """The same in plain py_trees."""
    if node.word == "check":
        return Check(facts, node.check.key)
    if node.word == "action":
        return Action("action")
    kind = py_trees.composites.Sequence if node.word == "sequence" else py_trees.composites.Selector
    return kind(node.word, node.memory, [grown(child, facts) for _, child in node.branches()])


def cpu_us(tick: Callable[[], object]) -> float:
    """CPU time of one tick in microseconds, the median of some rounds."""
    tick()
    rounds = []
    for _ in range(ROUNDS):
        start = time.process_time()
        for _ in range(TICKS):
            tick()
        rounds.append((time.process_time() - start) / TICKS * 1e6)
    return statistics.median(rounds)


def measure(leaves: int) -> tuple[int, float, float, float]:
    """Nodes, and µs a tick: py_trees, ours kept, ours restored."""
    root = TreeNode.read(tree(leaves))
    live = grown(root, {"ready": True, "alarm": False})
    ticker = PyTrees().compile(root, "/tree", {}, "s")
    view = View(0.0, {"ready": Stamped(True, 0.0), "alarm": Stamped(False, 0.0)})
    state = ticker.tick(TreeState(), view, {}).state

    def kept() -> None:
        nonlocal state
        state = ticker.tick(state, view, {}).state

    other = TreeState(dict(state.nodes), state.leaves)
    return (
        sum(1 for _ in root.paths()),
        cpu_us(live.tick_once),
        cpu_us(kept),
        cpu_us(lambda: ticker.tick(other, view, {})),
    )


def main() -> None:
    print(f"{'nodes':>6} {'py_trees':>16} {'ours, kept':>16} {'ours, restored':>16}   µs a tick (µs a node and tick)")
    for leaves in SIZES:
        nodes, *each = measure(leaves)
        figure(f"a tick of a tree of {nodes} nodes, a node", each[1] / nodes, "µs", peer=("py_trees", each[0] / nodes))
        print(f"{nodes:>6} " + " ".join(f"{us:>8.1f} ({us / nodes:4.2f})" for us in each))


if __name__ == "__main__":
    main()
