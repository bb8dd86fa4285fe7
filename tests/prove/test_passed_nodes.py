# SPDX-License-Identifier: Apache-2.0
"""What a tree remembers of nodes that it has passed makes no difference to what it does."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from benchmarks.tree_missions import DELIVER
from rai_missions.engine.activities.ticker import Ticker, TickResult, Trees, TreeState
from rai_missions.engine.activities.tree_rounds import Rounds
from rai_missions.engine.trees import CompiledTrees
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from rai_missions.prove.analysis.passed_nodes import PassedNodes
from rai_missions.states.tree import TreeNode
from rai_missions.trees import PyTrees
from tests.prove.test_laws import hold_against_forgetless
from tests.trees.growing import (
    CONVERTERS,
    STATUSES,
    Moment,
    asked,
    facts,
    lasting,
    leaves,
    long_lives,
    often,
    parallel,
    rich_trees,
)
from tests.trees.test_state import KEYS, outcomes, view

Json = dict[str, Any]
Drawn = st.SearchStrategy[Any]
Memories = Mapping[str, Any]
MOST_ROUNDS = 20
STEPS = st.one_of(
    leaves,
    st.sampled_from(
        [
            {"action": "drive"},
            {"call": "horn"},
            {"set": "n", "add": 1},
            {"action": "drive", "goal": {"to": {"from": "a"}}},
        ]
    ),
    leaves.map(lambda leaf: {"one_shot": leaf}),
)


def in_a_row(inner: Drawn, *, memory: bool = True) -> Drawn:
    """Composites of two or three."""
    return st.builds(
        lambda word, given: {word: given, "memory": memory},
        st.sampled_from(["sequence", "selector"]),
        st.lists(inner, min_size=2, max_size=3),
    )


def side_by_side(inner: Drawn) -> Drawn:
    policies = st.sampled_from(["success_on_all", "success_on_one", [0]])
    return st.builds(parallel, st.lists(inner, min_size=2, max_size=3), policies, st.booleans())


def around(inner: Drawn) -> Drawn:
    """Whatever may look at the end of what is inside, or begin it again."""
    return st.one_of(
        inner,
        in_a_row(st.one_of(inner, STEPS), memory=False),
        in_a_row(st.one_of(inner, STEPS)),
        side_by_side(st.one_of(inner, STEPS)),
        st.builds(lambda child, word: {word: child}, inner, st.sampled_from(CONVERTERS)),
        st.builds(lambda child, word: {"condition": word, "child": child}, inner, st.sampled_from(STATUSES)),
        inner.map(lambda child: {"retry": 3, "child": child}),
        inner.map(lambda child: {"repeat": -1, "child": child}),
        inner.map(lambda child: {"one_shot": child}),
        inner.map(lambda child: {"status_to_blackboard": "spoken", "child": child}),
        inner.map(lambda child: asked({"left": child})),
    )


BRANCHES = st.one_of(in_a_row(STEPS), side_by_side(in_a_row(STEPS)), in_a_row(st.one_of(in_a_row(STEPS), STEPS)))
INSIDE = around(around(BRANCHES))
PASSING = st.one_of(
    INSIDE.map(lambda child: {"parallel": [child, {"wait_s": 999.5}]}),
    INSIDE.map(lambda child: {"repeat": -1, "child": child}),
    INSIDE.map(lambda child: {"sequence": [{"failure_is_success": child}, {"wait_s": 999.5}]}),
    lasting(INSIDE),
)
"""Trees with branches that are passed, in which something runs on."""
ENDS = ("", "succeeded", "succeeded", "failed", "rejected", "left")
MOMENTS = st.builds(
    Moment, facts, st.lists(st.sampled_from(ENDS), min_size=3, max_size=3).map(tuple), st.integers(0, 2)
)


def done(ticked: TickResult) -> TickResult:
    """What a tick did, without what the tree remembers of it and what was called within it."""
    return ticked._replace(state=TreeState(), trace=())


def life_at_rest(ticker: Ticker, life: list[Moment], forgotten: Callable[[Memories], Memories]) -> Iterator[Any]:
    """What a tree does, and what it waits for then; between two moments it forgets.

    Loops begin their next rounds as in a chart; a life ends where that does not end.
    """
    state, at = TreeState(), 0.0
    for moment in life:
        at += moment.later_s
        now, rounds = view(at, moment), Rounds(ticker.loops)
        ticked = ticker.tick(state, now, outcomes(state, moment))
        yield done(ticked)
        for _ in range(MOST_ROUNDS):
            if not rounds.next_begins(ticked) or ticked.status != "running":
                break
            ticked = ticker.tick(ticked.state, now, {})
            yield done(ticked)
        else:
            return
        if ticked.status != "running":
            return
        state = ticked.state._replace(nodes=forgotten(ticked.state.nodes))
        yield ticker.reads(state), ticker.wake_at(state, now), done(ticker.stop(state, now))


def holds_for(tree: Json, life: list[Moment], trees: Trees) -> None:
    root = TreeNode.read(tree)
    passed = PassedNodes(root)

    def forgotten(memories: Memories) -> Memories:
        left = passed.forgotten(memories)
        return {
            path: memory
            for path, memory in left.items()
            if not path or memory["status"] != "invalid" or "end" in memory or "refused" in memory
        }

    lives = (
        [*life_at_rest(trees.compile(root, "/states/s/tree", KEYS, "s"), life, how)]
        for how in (lambda memories: memories, forgotten)
    )
    assert next(lives) == next(lives)


@often
@given(rich_trees, long_lives)
def test_what_was_passed_makes_no_difference(tree: Json, life: list[Moment]) -> None:
    holds_for(tree, life, CompiledTrees())


@often
@given(PASSING, st.lists(MOMENTS, min_size=3, max_size=12))
def test_nor_does_it_in_a_tree_that_runs_on(tree: Json, life: list[Moment]) -> None:
    holds_for(tree, life, CompiledTrees())


@given(PASSING, st.lists(MOMENTS, min_size=3, max_size=12))
def test_nor_does_it_on_py_trees(tree: Json, life: list[Moment]) -> None:
    holds_for(tree, life, PyTrees())


@pytest.mark.drill
@pytest.mark.timeout(7_200)
def test_nor_does_it_in_many_trees() -> None:
    @settings(max_examples=20_000, deadline=None, suppress_health_check=list(HealthCheck))
    @given(PASSING, st.lists(MOMENTS, min_size=3, max_size=12))
    def law(tree: Json, life: list[Moment]) -> None:
        holds_for(tree, life, CompiledTrees())

    law()


CHECK_A = {"check": {"key": "a", "==": True}}
DRIVE = {"action": "drive"}
GIVEN = {"a": True, "b": True, "c": True}


@pytest.mark.parametrize(
    ("tree", "ends"),
    [
        pytest.param(
            {"selector": [{"selector": [DRIVE, DRIVE], "memory": True}, {"call": "horn"}], "memory": False},
            ["", "rejected", "failed", ""], id="one that is looked at again where it has ended",
        ),
        pytest.param(
            {"repeat": -1, "child": {"sequence": [{"one_shot": CHECK_A}, DRIVE]}},
            ["", "succeeded", "succeeded", "succeeded"], id="one that ends but once",
        ),
        pytest.param(
            {"parallel": [{"sequence": [{"set": "n", "add": 1}, CHECK_A]}, DRIVE], "synchronise": False},
            ["", ""], id="one that is ticked again next to one that runs",
        ),
    ],
)  # fmt: skip
def test_what_may_be_looked_at_again_is_remembered(tree: Json, ends: list[str]) -> None:
    life = [Moment({**GIVEN, "a": not number % 2}, (end,), 1) for number, end in enumerate(ends)]
    holds_for(tree, life, CompiledTrees())


SMALL_STEPS = st.sampled_from([
    {"check": {"key": "clear", "==": True}}, {"action": "drive", "timeout_s": 9}, {"call": "horn", "timeout_s": 2},
    {"set": "n", "add": 1}, {"wait_s": 1.5},
])  # fmt: skip


@st.composite
def tree_missions(draw: Callable[[Drawn], Any]) -> Json:
    """A tree of some branches one after the other, in a mission."""
    row = in_a_row(SMALL_STEPS)
    inner = st.one_of(row, side_by_side(SMALL_STEPS), row.map(lambda child: {"retry": 2, "child": child}))
    return {
        "format": 1, "name": "passing", "initial": "work",
        "blackboard": {"clear": {"type": "boolean", "source": "robot", "max_age_s": 2}, "n": {"type": "integer"}},
        "states": {
            "work": {
                "tree": draw(in_a_row(inner)), "timeout_s": 60,
                "transitions": [{"on": "succeeded", "when": {"key": "n", "<": 1}, "to": "over"},
                                {"on": ["succeeded", "failed", "timed_out"], "to": "lost"}],
            },
            "over": {"final": "aborted"}, "lost": {"final": "failed"},
        },
    }  # fmt: skip


@pytest.mark.long
@settings(suppress_health_check=list(HealthCheck), deadline=None, max_examples=5)
@given(tree_missions())
def test_a_proof_finds_what_one_finds_that_remembers_all(document: Json) -> None:
    hold_against_forgetless(document, 150)


def test_a_mission_of_one_tree_is_proved_in_few_states() -> None:
    proof = prove(Mission.model_validate(DELIVER))
    assert proof.is_whole and proof.states < 200
