# SPDX-License-Identifier: Apache-2.0
"""A compiled tree is, node by node, where the same tree on py_trees is; what a tick leaves out changes nothing."""

from __future__ import annotations

import json
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.activities.ticker import Ticker, TickResult, TreeState
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.keys import stale_at
from rai_missions.states.tree import TreeNode
from rai_missions.trees import PyTrees
from tests.trees.growing import (
    FACTS,
    Moment,
    flipping_lives,
    guarded_trees,
    lasting,
    lasting_trees,
    long_lives,
    often,
    rich_trees,
    trees,
)
from tests.trees.polling import lives as happenings
from tests.trees.polling import mission_of, polled_trees
from tests.trees.test_state import KEYS, life_of, outcomes, stored, view


class Both:
    """One tree on py_trees and compiled, and what happened last."""

    def __init__(self, tree: Any) -> None:
        root = TreeNode.read(tree)
        self.ours = CompiledTrees().compile(root, "/states/s/tree", KEYS, "s")
        self.theirs: Ticker = PyTrees().compile(root, "/states/s/tree", KEYS, "s")
        self.state, self.their_state, self.last = TreeState(), TreeState(), view(0.0, Moment({}, (), 0))

    def tick(self, at: float, moment: Moment, *, is_known: bool = True) -> tuple[TickResult, TickResult]:
        now = view(at, moment)
        ends = outcomes(self.their_state, moment)
        changed = self.changed(now) if is_known else None
        ours = self.ours.tick(self.state, now, ends, 0.0, changed)
        theirs = self.theirs.tick(self.their_state, now, ends)
        self.state, self.their_state, self.last = ours.state, theirs.state, now
        return ours, theirs

    def changed(self, now: Any) -> set[str]:
        """As little as the contract of `Ticker.tick` allows."""

        def known(board: Any, key: str) -> Any:
            return board[key].value if key in board and now.at < stale_at(KEYS.get(key), board[key]) else None

        every = {key for key in KEYS if known(self.last.board, key) != known(now.board, key)}
        return every & self.ours.reads(self.state)


def comparable(ticked: TickResult) -> Any:
    """What a tick did, but for what was called within it."""
    return ticked._replace(trace=(), state=TreeState(dict(ticked.state.nodes), dict(ticked.state.leaves)))


def as_py_trees(tree: Any, life: list[Moment], *, unknown: int = 0) -> None:
    """Compares each tick; of each `unknown`th it is not known what has changed, of none for 0."""
    both, at = Both(tree), 0.0
    for number, moment in enumerate(life, 1):
        at += moment.later_s
        ours, theirs = both.tick(at, moment, is_known=not unknown or number % unknown > 0)
        assert comparable(ours) == comparable(theirs)
        assert both.ours.reads(ours.state) == both.theirs.reads(theirs.state)
        assert both.ours.wake_at(ours.state, both.last) == both.theirs.wake_at(theirs.state, both.last)
    ours, theirs = (
        ticker.stop(state, both.last) for ticker, state in ((both.ours, both.state), (both.theirs, both.their_state))
    )
    assert comparable(ours) == comparable(theirs)


@often
@given(trees, long_lives)
def test_a_compiled_tree_is_where_py_trees_is(tree: Any, life: list[Moment]) -> None:
    as_py_trees(tree, life)


@often
@given(rich_trees, long_lives)
def test_so_is_one_with_all_that_a_mission_can_write(tree: Any, life: list[Moment]) -> None:
    as_py_trees(tree, life)


@often
@given(lasting_trees, flipping_lives)
def test_so_is_one_that_runs_on_while_one_fact_after_the_other_changes(tree: Any, life: list[Moment]) -> None:
    as_py_trees(tree, life)


@often
@given(lasting_trees, flipping_lives, st.integers(1, 3))
def test_so_is_one_of_which_it_is_not_known_what_has_changed(tree: Any, life: list[Moment], unknown: int) -> None:
    as_py_trees(tree, life, unknown=unknown)


@often
@given(guarded_trees, long_lives, st.integers(0, 3))
def test_so_is_one_whose_branches_have_guards(tree: Any, life: list[Moment], unknown: int) -> None:
    as_py_trees(tree, life, unknown=unknown)


def test_a_branch_deep_inside_is_looked_at_where_it_is_not_known_what_has_changed() -> None:
    first, second = FACTS[:2]
    way = {"sequence": [{"check": {"key": second, "==": True}}, {"call": "horn"}], "memory": False}
    ways = {"selector": [way, {"call": "bell"}], "memory": False}
    both = Both({"sequence": [{"check": {"key": first, "==": True}}, ways], "memory": False})
    both.tick(0.0, Moment({first: True, second: False}, (), 0))
    ours, theirs = both.tick(1.0, Moment({first: True, second: True}, (), 0), is_known=False)
    assert comparable(ours) == comparable(theirs)
    assert ours.started and ours.ended


def test_what_wants_a_tick_is_asked_for_in_each_state_of_a_tree() -> None:
    first, second = FACTS[:2]
    inside = [{"check": {"key": key, "==": True}} for key in (first, second)]
    ways = [{"sequence": [*inside, {"call": "horn"}], "memory": False}, {"call": "bell"}]
    chart = Chart(mission_of({"selector": ways, "memory": False}))
    chart.start(0.0)
    assert chart.write(second, True, 1.0).effects == ()  # not looked at, as the first is false
    for key, value in ((first, True), (second, False), (second, True)):
        assert chart.write(key, value, chart.at + 1.0).effects


@pytest.mark.drill
@pytest.mark.timeout(14_400)
@pytest.mark.parametrize(
    ("grown", "lived"),
    [(trees, long_lives), (rich_trees, long_lives), (lasting_trees, flipping_lives)],
    ids=["plain", "rich", "lasting"],
)
def test_so_it_is_for_many_trees(grown: Any, lived: Any) -> None:
    @settings(max_examples=50_000, deadline=None, suppress_health_check=list(HealthCheck))
    @given(grown, lived)
    def law(tree: Any, life: list[Moment]) -> None:
        as_py_trees(tree, life)

    law()


def compiled(tree: Any) -> Ticker:
    return CompiledTrees().compile(TreeNode.read(tree), "/states/s/tree", KEYS, "s")


@given(rich_trees, long_lives)
def test_a_restored_tree_has_the_same_future(tree: Any, life: list[Moment]) -> None:
    for state, now, ended, ticked in life_of(compiled(tree), life):
        assert compiled(tree).tick(stored(state), now, ended) == ticked


@given(rich_trees, long_lives)
def test_a_state_can_be_ticked_again_whatever_was_ticked_in_between(tree: Any, life: list[Moment]) -> None:
    ticker = compiled(tree)
    every = list(life_of(ticker, life))
    stored_before = [json.dumps(dict(ticked.state.nodes)) for *_, ticked in every]
    for state, now, ended, ticked in every[::2] + every[1::2]:
        assert ticker.tick(state, now, ended) == ticked
    assert [json.dumps(dict(ticked.state.nodes)) for *_, ticked in every] == stored_before


@given(lasting_trees, flipping_lives)
def test_from_a_state_of_before_a_tick_visits_what_has_changed_since(tree: Any, life: list[Moment]) -> None:
    """Two runs on one ticker in turn, each with what has changed in it alone."""
    alone, first, second, at = Both(tree), Both(tree), Both(tree), 0.0
    second.ours = first.ours
    for moment, other in zip(life, reversed(life), strict=True):
        at += moment.later_s
        expected, _ = alone.tick(at, moment)
        found, _ = first.tick(at, moment)
        second.tick(at, other)
        assert comparable(found) == comparable(expected)


def charts_alike(drawn: Any, life: list[Any]) -> None:
    """A chart whose trees are compiled makes the steps of one whose trees are on py_trees."""
    mission = mission_of(drawn)
    ours, theirs, half_s = Chart(mission), Chart(mission, PyTrees()), 0
    assert ours.start(0.0) == theirs.start(0.0)
    for each in life:
        half_s += each.later
        at, running = half_s / 2, ours.state.running.get("work")
        assert ours.send(Tick(at)) == theirs.send(Tick(at))
        if each.fact is not None:
            assert ours.write(*each.fact, at) == theirs.write(*each.fact, at)
        elif running is not None and running.leaves:
            number, end = each.ends
            leaf = running.leaves[sorted(running.leaves)[number % len(running.leaves)]]
            ended = Event(end, at, {}, "result", leaf.state.number)
            assert ours.send(ended) == theirs.send(ended)
        assert ours.snapshot() == theirs.snapshot()


@often
@given(polled_trees, happenings)
def test_a_chart_makes_the_same_steps_on_both(drawn: Any, life: list[Any]) -> None:
    charts_alike(drawn, life)


@given(lasting(polled_trees), happenings)
def test_so_does_one_whose_tree_runs_on(drawn: Any, life: list[Any]) -> None:
    charts_alike(drawn, life)
