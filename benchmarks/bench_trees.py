# SPDX-License-Identifier: Apache-2.0
"""What trees cost, next to plain py_trees: `python -m benchmarks.bench_trees`.

First a tick in which every node that py_trees visits is visited, a node: nothing is known of what has changed. Checks
of py_trees read a Python dict; its own blackboard would add 1.7 µs each. Then a whole step of a chart: one guard of
many is written, which changes its branch; on py_trees the same chart looks at the whole tree. Last, a reading that a
tree watches and that changes no guard: next to a reading that nothing watches, and to py_trees, where it is written to
the blackboard and the tree is ticked.
"""

from __future__ import annotations

import itertools
import operator
import statistics
import time
from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

import py_trees

from benchmarks.figures import figure, peak_bytes
from rai_missions.engine import Chart
from rai_missions.engine.activities.ticker import TreeState
from rai_missions.engine.trees import CompiledTrees
from rai_missions.guards.view import Truth
from rai_missions.keys import Stamped
from rai_missions.mission.mission import Mission
from rai_missions.states.tree import TreeNode
from rai_missions.trees import PyTrees

TICKS, ROUNDS = 300, 7
Status = py_trees.common.Status


class View(NamedTuple):
    at: float
    board: dict[str, Stamped]
    active: frozenset[str] = frozenset()
    entered: Mapping[str, float] = {}
    true_since: Mapping[str, float] = {}
    event: Mapping[str, Any] = {}
    answer: Mapping[str, Any] = {}

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        return None

    def note(self, text: str) -> None:
        return None


def is_true(key: str) -> dict[str, Any]:
    return {"check": {"key": key, "==": True}}


def in_a_row() -> dict[str, Any]:
    """A sequence of ten: nine checks, and an action that runs."""
    return {"sequence": [*(is_true("ready") for _ in range(9)), {"action": "work"}], "memory": False}


def guarded() -> dict[str, Any]:
    """A selector of guarded branches, 50 nodes; all guards are false, and the last child runs."""
    branches = [{"sequence": [is_true("alarm"), {"action": "stop"}]} for _ in range(16)]
    return {"selector": [*branches, {"action": "work"}]}


def bushy(depth: int = 3) -> dict[str, Any]:
    """Sequences of ten in sequences of ten, 1,111 nodes; all checks are true."""
    return is_true("ready") if not depth else {"sequence": [bushy(depth - 1) for _ in range(10)], "memory": False}


TREES = {"sequence of 10": in_a_row(), "50 guarded": guarded(), "1,111 nodes": {"success_is_running": bushy()}}


def branch(number: int) -> dict[str, Any]:
    """A branch with a guard of its own, and one for all that is false: a guard that becomes true starts nothing."""
    return {"sequence": [is_true(f"g{number}"), is_true("on"), {"action": "work"}]}


def nested(depth: int, width: int, numbers: Any) -> dict[str, Any]:
    """Selectors in selectors of such branches."""
    if not depth:
        return branch(next(numbers))
    return {"selector": [nested(depth - 1, width, numbers) for _ in range(width)]}


def stepping(tree: dict[str, Any], keys: int, trees: Any = None) -> Callable[[], object]:
    """A chart that runs a tree, and writes the guard in its middle at each step."""
    names = [*(f"g{number}" for number in range(keys)), "on"]
    states = {"w": {"tree": {"selector": [tree, {"action": "rest"}]}, "transitions": [{"on": "succeeded", "to": "e"}]}}
    board = {name: {"type": "boolean", "source": "robot"} for name in names}
    chart = Chart(
        Mission.model_validate(
            {"name": "m", "initial": "w", "blackboard": board, "states": {**states, "e": {"final": "failed"}}}
        ),
        trees,
    )
    for name in names:
        chart.write(name, False, at=0.0)
    chart.start(0.0)
    value = False

    def step() -> None:
        nonlocal value
        value = not value
        chart.write(f"g{keys // 2}", value, chart.at + 0.001)

    return step


WATCHES: dict[str, Any] = {
    "sequence": [{"check": {"key": "battery", ">": 0.2}}, {"timeout": 3600, "child": {"wait_s": 3000}}], "memory": False
}  # fmt: skip


def receiving(tree: dict[str, Any] | None) -> Callable[[], object]:
    """A chart that receives a reading at each step; without a tree nothing watches it."""
    work = {"tree": tree} if tree is not None else {}
    states = {"w": {**work, "transitions": [{"on": "stop", "to": "e"}]}, "e": {"final": "failed"}}
    board = {"battery": {"type": "number", "source": "robot"}}
    chart = Chart(
        Mission.model_validate(
            {"name": "m", "initial": "w", "events": {"stop": {}}, "blackboard": board, "states": states}
        )
    )
    chart.write("battery", 0.5, at=0.0)
    chart.start(0.0)
    level = 0.5

    def step() -> None:
        nonlocal level
        level = 1.25 - level
        chart.write("battery", level, chart.at + 0.001)

    return step


def receiving_by_py_trees() -> Callable[[], object]:
    """The same tree in plain py_trees: a reading is written to the blackboard, and the tree is ticked."""
    board = py_trees.blackboard.Client(name="robot")
    board.register_key("battery", access=py_trees.common.Access.WRITE)
    above = py_trees.common.ComparisonExpression("battery", 0.2, operator.gt)
    wait = py_trees.decorators.Timeout("timeout", py_trees.timers.Timer("wait", 3000.0), 3600.0)
    check = py_trees.behaviours.CheckBlackboardVariableValue("check", above)
    root = py_trees.composites.Sequence("sequence", memory=False, children=[check, wait])
    level = 0.5

    def step() -> None:
        nonlocal level
        level = 1.25 - level
        board.battery = level
        root.tick_once()

    return step


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
    if node.word == "success_is_running":
        return py_trees.decorators.SuccessIsRunning(node.word, grown(node.child, facts))
    kind = py_trees.composites.Sequence if node.word == "sequence" else py_trees.composites.Selector
    return kind(node.word, node.memory, [grown(child, facts) for _, child in node.branches()])


def cpu_us(tick: Callable[[], object], ticks: int = TICKS) -> float:
    """CPU time of one tick in microseconds, the median of some rounds."""
    tick()
    rounds = []
    for _ in range(ROUNDS):
        start = time.process_time()
        for _ in range(ticks):
            tick()
        rounds.append((time.process_time() - start) / ticks * 1e6)
    return statistics.median(rounds)


def measure(tree: dict[str, Any]) -> tuple[int, float, float]:
    """Nodes that py_trees visits, and µs a tick: py_trees, compiled."""
    root, facts = TreeNode.read(tree), {"ready": True, "alarm": False}
    live = grown(root, facts)
    live.tick_once()
    visited = sum(1 for _ in live.tick())
    ticker = CompiledTrees().compile(root, "/tree", {}, "s")
    view = View(0.0, {key: Stamped(value, 0.0) for key, value in facts.items()})
    state = ticker.tick(TreeState(), view, {}).state

    def kept() -> None:
        nonlocal state
        state = ticker.tick(state, view, {}).state

    return visited, cpu_us(live.tick_once), cpu_us(kept)


def main() -> None:
    print(f"{'tree':>16} {'visited':>8} {'py_trees':>16} {'compiled':>16}   µs a tick (µs a visited node)")
    for name, tree in TREES.items():
        nodes, theirs, ours = measure(tree)
        figure(f"a visited node, {name}", ours / nodes, "µs", peer=("py_trees", theirs / nodes), most=0.3)
        print(f"{name:>16} {nodes:>8} " + " ".join(f"{us:>8.1f} ({us / nodes:5.2f})" for us in (theirs, ours)))
    print(f"{'step of a chart':>16} {'nodes':>8} {'py_trees':>16} {'compiled':>16}   µs a step")
    for name, keys, tree in (
        ("50 guards", 50, {"selector": [branch(number) for number in range(50)]}),
        ("2,401 guards", 7**4, nested(4, 7, itertools.count())),
    ):
        nodes = sum(1 for _ in TreeNode.read(tree).paths())
        ours = cpu_us(stepping(tree, keys))
        theirs = cpu_us(stepping(tree, keys, PyTrees()), 30 if keys == 50 else 1)
        most = 15 if keys == 50 else 25
        figure(f"a step that changes one guard of {keys}", ours, "µs", peer=("on py_trees", theirs), most=most)
        figure(f"the same, of {keys}: memory at its peak", peak_bytes(stepping(tree, keys)), "bytes")
        print(f"{name:>16} {nodes:>8} {theirs:>16.1f} {ours:>16.1f}")
    ours, theirs = cpu_us(receiving(WATCHES)), cpu_us(receiving_by_py_trees())
    figure("a reading that a tree watches", ours, "µs", peer=("py_trees", theirs))
    figure("a reading that nothing watches", unwatched := cpu_us(receiving(None)), "µs")
    print(f"{'a reading':>16} {4:>8} {theirs:>16.1f} {ours:>16.1f}   unwatched {unwatched:.1f}")


if __name__ == "__main__":
    main()
