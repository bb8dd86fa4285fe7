# SPDX-License-Identifier: Apache-2.0
"""A tree is ticked as py_trees ticks it, but that an old branch ends before the one that takes over starts."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any, NamedTuple

import pytest
from hypothesis import event, given

from rai_missions.engine.activities.ticker import TickResult, TreeState
from rai_missions.states.tree import TreeNode
from rai_missions.trees import PyTrees
from tests.trees.growing import Moment, lives, often, seen, trees
from tests.trees.oracle import Oracle

Calls = list[tuple[str, str, str]]


class Lived(NamedTuple):
    """One tick in both."""

    ours: TickResult
    calls: Calls
    before: dict[str, str]
    after: dict[str, str]
    outcomes: dict[str, str]
    nodes: dict[str, Any]


def live(tree: Any, life: list[Moment]) -> Iterator[Lived]:
    root = TreeNode.read(tree)
    with pytest.MonkeyPatch.context() as monkeypatch:
        oracle = Oracle(root, monkeypatch)
        ticker, state, at = PyTrees().compile(root, "/tree", {}, "s"), TreeState(), 0.0
        for moment in life:
            at += moment.later_s
            outcomes = {path: end for path, end in zip(sorted(state.leaves), moment.ends, strict=False) if end}
            before = oracle.statuses()
            calls = oracle.tick(at, moment.facts, outcomes)
            ours = ticker.tick(state, seen(at, moment.facts), outcomes)
            state = ours.state
            yield Lived(ours, calls, before, oracle.statuses(), outcomes, oracle.nodes)


def ends_of_others(calls: Any) -> Any:
    return [call for call in calls if call[1:] == ("terminate", "invalid")]


def the_rest(calls: Any) -> Any:
    return [call for call in calls if call[1:] != ("terminate", "invalid")]


def taken_over(lived: Lived) -> Iterator[tuple[str, str]]:
    """Children of composites without memory: one that ran and was ended, and one that now is in for it."""
    closed = {path for path, call, _ in lived.calls if call == "terminate"}
    for path, node in lived.nodes.items():
        if not hasattr(node, "memory") or node.memory or lived.before[path] != "running":
            continue
        if path in closed and (path, "terminate", "success") not in lived.calls:
            continue
        for old in node.children:
            new = node.current_child
            if lived.before[old.path] == "running" and lived.after[old.path] == "invalid" and new not in (None, old):
                yield old.path, new.path


def is_turned(lived: Lived) -> bool:
    """Whether py_trees began a child before it ended a sibling that ran, in a composite that did not fail for it."""
    for path, node in lived.nodes.items():
        if getattr(node, "memory", True) or (path, "terminate", "failure") in lived.calls:
            continue
        begun: list[str] = []
        for called, call, status in lived.calls:
            siblings = [child.path for child in node.children if child.path != called]
            if (call, status) == ("terminate", "invalid") and lived.before[called] == "running":
                if len(siblings) < len(node.children) and set(begun) & set(siblings):
                    return True
            elif call == "initialise":
                begun.append(called)
    return False


def inside(path: str, outer: str) -> bool:
    return path == outer or path.startswith(f"{outer}/")


@often
@given(trees, lives)
def test_status_and_calls_are_those_of_py_trees(tree: Any, life: list[Moment]) -> None:
    for lived in live(tree, life):
        trace = list(lived.ours.trace)
        assert lived.ours.status == lived.after[""]
        assert the_rest(trace) == the_rest(lived.calls)
        assert sorted(ends_of_others(trace)) == sorted(ends_of_others(lived.calls))
        if not is_turned(lived):
            assert trace == lived.calls
        else:
            event("a branch is taken over")


@often
@given(trees, lives)
def test_an_old_branch_has_ended_before_the_new_one_starts(tree: Any, life: list[Moment]) -> None:
    for lived in live(tree, life):
        for old, new in taken_over(lived):
            ended = [at for at, (path, *_) in enumerate(lived.ours.trace) if inside(path, old)]
            begun = [at for at, (path, *_) in enumerate(lived.ours.trace) if inside(path, new)]
            if lived.after[new] == "running" or "selector" in new:
                assert max(ended) < min(begun)


@often
@given(trees, lives)
def test_a_node_remembers_the_status_that_py_trees_gives_it(tree: Any, life: list[Moment]) -> None:
    for lived in live(tree, life):
        report = {path: memory["status"] for path, memory in lived.ours.state.nodes.items()}
        assert {path: report.get(path, "invalid") for path in lived.after} == lived.after


@often
@given(trees, lives)
def test_what_is_started_and_ended_follows_from_the_calls(tree: Any, life: list[Moment]) -> None:
    """A leaf that was begun in a tick and runs after it is started; one that ran on and was stopped is ended."""
    for lived in live(tree, life):
        errands = [path for path, node in lived.nodes.items() if node.name in ("action", "call")]
        begun = {path for path, call, _ in lived.calls if call == "initialise"}
        stopped = {path for path, call, status in lived.calls if (call, status) == ("terminate", "invalid")}
        running = {path for path in errands if lived.after[path] == "running"}
        ran = {path for path in errands if lived.before[path] == "running" and path not in lived.outcomes}
        assert set(lived.ours.started) == begun & running
        assert set(lived.ours.ended) == stopped & ran
        assert set(lived.ours.state.leaves) == running


@often
@given(trees, lives)
def test_stopping_a_tree_calls_what_py_trees_calls(tree: Any, life: list[Moment]) -> None:
    root = TreeNode.read(tree)
    with pytest.MonkeyPatch.context() as monkeypatch:
        oracle = Oracle(root, monkeypatch)
        ticker, state = PyTrees().compile(root, "/tree", {}, "s"), TreeState()
        for at, moment in enumerate(life):
            oracle.tick(at, moment.facts, {})
            state = ticker.tick(state, seen(at, moment.facts), {}).state
        stopped = ticker.stop(state, seen(len(life), life[-1].facts))
        assert list(stopped.trace) == oracle.stop()
        assert stopped.status == "invalid"
        assert set(stopped.ended) == set(state.leaves)
        assert not stopped.state.leaves
