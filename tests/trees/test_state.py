# SPDX-License-Identifier: Apache-2.0
"""All that a tree remembers is in its state; time and facts matter when it states it."""

from __future__ import annotations

import json
import math
from collections.abc import Iterator
from typing import Any

from hypothesis import assume, given
from hypothesis import strategies as st

from rai_missions.engine.activities.ticker import Leaf, Ticker, TickResult, TreeState
from rai_missions.keys import Key, Stamped
from rai_missions.states.tree import TreeNode
from rai_missions.trees import PyTrees
from tests.trees.growing import FACTS, Facts, Moment, is_true, lives, often, rich_trees, seen

KEYS = {
    "a": Key("boolean", source="robot", max_age_s=1.5),
    "b": Key("boolean", source="robot", max_age_s=2.25),
    "c": Key("boolean"),
    "n": Key("integer"),
    "m": Key("integer"),
    "spoken": Key("string"),
}


def compiled(tree: Any) -> Ticker:
    return PyTrees().compile(TreeNode.read(tree), "/states/s/tree", KEYS, "s")


def stored(state: TreeState) -> TreeState:
    """As it comes back from a journal."""
    nodes, leaves = json.loads(json.dumps([dict(state.nodes), state.leaves], allow_nan=False))
    return TreeState(nodes, {path: Leaf(*leaf) for path, leaf in leaves.items()})


def outcomes(state: TreeState, moment: Moment) -> dict[str, str]:
    return {path: end for path, end in zip(sorted(state.leaves), moment.ends, strict=False) if end}


def view(at: float, moment: Moment) -> Any:
    return seen(at, {**moment.facts, "n": 1, "m": 2})


def life_of(ticker: Ticker, life: list[Moment]) -> Iterator[tuple[TreeState, Any, dict[str, str], TickResult]]:
    """Each tick: the state before, the view, the outcomes, and what came of them."""
    state, at = TreeState(), 0.0
    for moment in life:
        at += moment.later_s
        given = (state, view(at, moment), outcomes(state, moment))
        ticked = ticker.tick(*given)
        yield *given, ticked
        state = ticked.state


def essence(ticked: TickResult) -> Any:
    """What a tick did, without the instants that it noted."""
    return ticked._replace(state=TreeState())


@often
@given(rich_trees, lives)
def test_a_restored_tree_has_the_same_future(tree: Any, life: list[Moment]) -> None:
    for state, seen_now, ended, ticked in life_of(compiled(tree), life):
        assert compiled(tree).tick(stored(state), seen_now, ended) == ticked


@often
@given(rich_trees, lives)
def test_ticking_a_state_again_gives_the_same_whatever_was_ticked_in_between(tree: Any, life: list[Moment]) -> None:
    ticker = compiled(tree)
    for state, seen_now, ended, ticked in list(life_of(ticker, life)):
        assert ticker.tick(state, seen_now, ended) == ticked
        ticker.stop(ticked.state, seen_now)
        ticker.wake_at(TreeState(), seen_now)
        assert ticker.tick(state, seen_now, ended) == ticked


@often
@given(rich_trees, lives)
def test_a_tick_changes_neither_the_state_nor_the_view_that_it_was_given(tree: Any, life: list[Moment]) -> None:
    for state, seen_now, ended, _ in life_of(compiled(tree), life):
        before = repr((state, seen_now, ended))
        compiled(tree).tick(state, seen_now, ended)
        assert repr((state, seen_now, ended)) == before


@often
@given(rich_trees, lives, st.floats(0, 1))
def test_until_the_time_that_it_names_time_alone_changes_nothing(tree: Any, life: list[Moment], share: float) -> None:
    ticker = compiled(tree)
    for _, now, _, ticked in life_of(ticker, life):
        wake_at = ticker.wake_at(ticked.state, now)
        assert wake_at > now.at
        last = math.nextafter(min(wake_at, now.at + 100.0), -math.inf)
        later = now._replace(at=max(now.at, now.at + (last - now.at) * share))
        assume(later.at <= last)
        for at in (later.at, last):
            later = now._replace(at=at)
            assert essence(ticker.tick(ticked.state, later, {})) == essence(ticker.tick(ticked.state, now, {}))


@often
@given(rich_trees, lives, st.sampled_from(FACTS), st.sampled_from([True, False, None]))
def test_a_key_that_it_does_not_read_changes_nothing(tree: Any, life: list[Moment], key: str, value: Any) -> None:
    ticker = compiled(tree)
    for _, now, _, ticked in life_of(ticker, life):
        if key in ticker.reads(ticked.state):
            continue
        board = {name: entry for name, entry in now.board.items() if name != key}
        if value is not None:
            board[key] = Stamped(value, now.at)
        other = now._replace(board=board)
        assert essence(ticker.tick(ticked.state, other, {})) == essence(ticker.tick(ticked.state, now, {}))


@often
@given(rich_trees, lives, st.integers(1, 50))
def test_a_pause_moves_a_tree_as_a_whole(tree: Any, life: list[Moment], paused_s: int) -> None:
    ticker = compiled(tree)
    for _, now, _, ticked in life_of(ticker, life):
        later = Facts(now.at + paused_s, {key: Stamped(value, at + paused_s) for key, (value, at) in now.board.items()})
        shift = ticker.shift(ticked.state, float(paused_s))
        assert ticker.wake_at(shift, later) == ticker.wake_at(ticked.state, now) + paused_s
        assert essence(ticker.tick(shift, later, {})) == essence(ticker.tick(ticked.state, now, {}))


@often
@given(rich_trees, lives)
def test_what_is_started_was_not_running_and_what_is_ended_was(tree: Any, life: list[Moment]) -> None:
    for state, _, ended, ticked in life_of(compiled(tree), life):
        running = set(state.leaves) - set(ended)
        assert set(ticked.ended) <= running
        assert not set(ticked.started) & (running - set(ticked.ended))
        assert set(ticked.state.leaves) >= set(ticked.started)
        for path in ticked.started:
            earlier = state.leaves.get(path, Leaf(0)).run
            assert ticked.state.leaves[path].run > earlier


@often
@given(rich_trees, lives)
def test_two_runs_of_a_leaf_never_have_the_same_number(tree: Any, life: list[Moment]) -> None:
    started: set[tuple[str, int]] = set()
    for _, _, _, ticked in life_of(compiled(tree), life):
        runs = {(path, ticked.state.leaves[path].run) for path in ticked.started}
        assert not runs & started
        started |= runs


def test_two_trees_share_nothing() -> None:
    tree = {"retry": 2, "child": {"sequence": [{"check": is_true("a")}, {"action": "drive"}]}}
    trees = PyTrees()
    one, other = (trees.compile(TreeNode.read(tree), "/tree", {}, "s") for _ in range(2))
    first = one.tick(TreeState(), seen(0.0, {"a": True}), {})
    assert first.started == ("child/sequence/1",)
    assert other.tick(TreeState(), seen(0.0, {"a": False}), {}).started == ()
    assert one.tick(first.state, seen(1.0, {"a": True}), {"child/sequence/1": "succeeded"}).status == "success"


def test_py_trees_own_blackboard_stays_empty() -> None:
    import py_trees

    tree = {"eternal_guard": is_true("a"), "child": {"status_to_blackboard": "spoken", "child": {"wait_s": 1.0}}}
    before = dict(py_trees.blackboard.Blackboard.storage), len(py_trees.blackboard.Blackboard.clients)
    compiled(tree).tick(TreeState(), seen(0.0, {"a": True}), {})
    assert (dict(py_trees.blackboard.Blackboard.storage), len(py_trees.blackboard.Blackboard.clients)) == before
