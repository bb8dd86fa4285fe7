# SPDX-License-Identifier: Apache-2.0
"""A tree built of plain py_trees, with leaves that state what a script reports: what ours is compared with."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import py_trees
from py_trees import composites, decorators, timers
from py_trees.common import OneShotPolicy, ParallelPolicy, Status

from rai_missions.states import tree

CONVERTERS: Mapping[type, type] = {
    tree.Inverter: decorators.Inverter,
    tree.FailureIsSuccess: decorators.FailureIsSuccess,
    tree.FailureIsRunning: decorators.FailureIsRunning,
    tree.SuccessIsFailure: decorators.SuccessIsFailure,
    tree.SuccessIsRunning: decorators.SuccessIsRunning,
    tree.RunningIsFailure: decorators.RunningIsFailure,
    tree.RunningIsSuccess: decorators.RunningIsSuccess,
    tree.PassThrough: decorators.PassThrough,
}


class Script:
    """What leaves state at this tick, the time, and the calls that were recorded."""

    def __init__(self) -> None:
        self.at = 0.0
        self.facts: Mapping[str, bool | None] = {}
        self.outcomes: Mapping[str, str] = {}
        self.calls: list[tuple[str, str, str]] = []

    def time(self) -> float:
        return self.at


class CheckLeaf(py_trees.behaviour.Behaviour):
    script: Script
    key = ""

    def update(self) -> Status:
        return Status.SUCCESS if self.script.facts.get(self.key) is True else Status.FAILURE


class ActionLeaf(py_trees.behaviour.Behaviour):
    script: Script
    path = ""
    fresh = False

    def initialise(self) -> None:
        self.fresh = True

    def update(self) -> Status:
        outcome = "" if self.fresh else self.script.outcomes.get(self.path, "")
        self.fresh = False
        return {"": Status.RUNNING, "succeeded": Status.SUCCESS}.get(outcome, Status.FAILURE)


def recorded(kind: type) -> type:
    """A py_trees class whose three calls are written down as they are made."""

    class Recorded(kind):  # type: ignore[misc]
        script: Script
        path = ""

        def initialise(self) -> None:
            self.script.calls.append((self.path, "initialise", self.status.value.lower()))
            super().initialise()

        def update(self) -> Status:
            place = len(self.script.calls)
            self.script.calls.append((self.path, "update", ""))
            status: Status = super().update()
            self.script.calls[place] = (self.path, "update", status.value.lower())
            return status

        def terminate(self, new_status: Status) -> None:
            self.script.calls.append((self.path, "terminate", new_status.value.lower()))
            super().terminate(new_status)

    return Recorded


class Oracle:
    """The same tree in plain py_trees."""

    def __init__(self, root: tree.TreeNode, monkeypatch: Any) -> None:
        self.script = Script()
        monkeypatch.setattr(decorators, "time", type("Clock", (), {"monotonic": self.script.time}))
        monkeypatch.setattr(timers, "time", type("Clock", (), {"time": self.script.time}))
        self.nodes: dict[str, Any] = {}
        self.root = self.build(root, "")

    def build(self, node: tree.TreeNode, path: str) -> Any:
        children = [self.build(child, f"{path}/{at}" if path else at) for at, child in node.branches()]
        made = self.make(node, children)
        made.script, made.path = self.script, path
        self.nodes[path] = made
        return made

    def make(self, node: Any, children: list[Any]) -> Any:  # noqa: C901 - one case a kind
        name = node.word
        if type(node) in CONVERTERS:
            return recorded(CONVERTERS[type(node)])(name, children[0])
        match node:
            case tree.Sequence():
                return recorded(composites.Sequence)(name, node.memory, children)
            case tree.Selector():
                return recorded(composites.Selector)(name, node.memory, children)
            case tree.Parallel():
                return recorded(composites.Parallel)(name, self.policy(node, children), children)
            case tree.Retry():
                return recorded(decorators.Retry)(name, children[0], node.num_failures)
            case tree.Repeat():
                return recorded(decorators.Repeat)(name, children[0], node.num_success)
            case tree.Timeout():
                return recorded(decorators.Timeout)(name, children[0], node.duration_s)
            case tree.OneShot():
                return recorded(decorators.OneShot)(name, children[0], OneShotPolicy[node.policy.upper()])
            case tree.Condition():
                return recorded(decorators.Condition)(name, children[0], Status[node.status.upper()])
            case tree.EternalGuard():
                return recorded(decorators.EternalGuard)(name, children[0], self.condition(node.guard.key))
            case tree.Check():
                check = recorded(CheckLeaf)(name)
                check.key = node.check.key
                return check
            case tree.Wait():
                return recorded(timers.Timer)(name, node.wait_s)
        return recorded(ActionLeaf)(name)

    def condition(self, key: str) -> Any:
        return lambda: self.script.facts.get(key) is True

    @staticmethod
    def policy(node: Any, children: list[Any]) -> ParallelPolicy.Base:
        if node.policy == "success_on_one":
            return ParallelPolicy.SuccessOnOne()
        if node.policy == "success_on_all":
            return ParallelPolicy.SuccessOnAll(node.synchronise)
        return ParallelPolicy.SuccessOnSelected([children[number] for number in node.policy], node.synchronise)

    def tick(
        self, at: float, facts: Mapping[str, bool | None], outcomes: Mapping[str, str]
    ) -> list[tuple[str, str, str]]:
        script = self.script
        script.at, script.facts, script.outcomes, script.calls = at, facts, outcomes, []
        self.root.tick_once()
        return script.calls

    def stop(self) -> list[tuple[str, str, str]]:
        self.script.calls = []
        self.root.stop(Status.INVALID)
        return self.script.calls

    def statuses(self) -> dict[str, str]:
        return {path: node.status.value.lower() for path, node in self.nodes.items()}
