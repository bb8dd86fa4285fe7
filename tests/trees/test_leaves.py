# SPDX-License-Identifier: Apache-2.0
"""What the leaves and decorators of a tree do, one example each."""

from __future__ import annotations

import math
from typing import Any

import pytest

from rai_missions.engine.activities.ticker import Leaf, LoopRound, TickResult, TreeState
from rai_missions.keys import Key, Stamped
from rai_missions.states.tree import TreeNode
from rai_missions.trees import PyTrees
from tests.trees.growing import Facts, asked, is_true, seen

KEYS = {
    "a": Key("boolean"),
    "battery": Key("number", source="robot", max_age_s=5),
    "n": Key("integer"),
    "spoken": Key("string"),
    "target": Key("object"),
}


class Run:
    """One tree, ticked where it is."""

    def __init__(self, tree: Any) -> None:
        self.ticker = PyTrees().compile(TreeNode.read(tree), "/states/s/tree", KEYS, "s")
        self.state = TreeState()

    def tick(self, at: float = 0.0, outcomes: dict[str, str] | None = None, **facts: Any) -> TickResult:
        ticked = self.ticker.tick(self.state, seen(at, facts), outcomes or {})
        self.state = ticked.state
        return ticked

    def wake_at(self, at: float, **facts: Any) -> float:
        return self.ticker.wake_at(self.state, seen(at, facts))


@pytest.mark.parametrize(("fact", "status"), [(True, "success"), (False, "failure"), (None, "failure")])
def test_a_check_fails_where_its_guard_is_false_or_unknown(fact: bool | None, status: str) -> None:
    assert Run({"check": is_true("a")}).tick(a=fact).status == status


def test_what_is_looked_at_before_a_branch_that_takes_over_comes_before_the_end_of_the_old_one() -> None:
    run = Run({"selector": [{"check": is_true("a")}, {"sequence": [{"check": is_true("b")}, {"action": "turn"}]},
                            {"action": "drive"}], "memory": False})  # fmt: skip
    assert run.tick(a=False, b=False).started == ("selector/2",)
    calls = [path for path, _, status in run.tick(a=False, b=True).trace if path.startswith("selector/")]
    old, new, looked = (calls.index(f"selector/{each}") for each in ("2", "1/sequence/0", "0"))
    assert looked < old < new


@pytest.mark.parametrize("outcome", ["failed", "timed_out", "rejected", "canceled", "unverified", "left"])
def test_an_action_succeeds_with_succeeded_and_with_nothing_else(outcome: str) -> None:
    run = Run({"action": "drive"})
    first = run.tick()
    assert (first.status, first.started, first.state.leaves) == ("running", ("",), {"": Leaf(1)})
    assert run.tick().status == "running"
    assert run.ticker.tick(run.state, seen(0.0, {}), {"": "succeeded"}).status == "success"
    assert run.ticker.tick(run.state, seen(0.0, {}), {"": outcome}).status == "failure"


def test_an_outcome_may_be_in_the_state_instead() -> None:
    run = Run({"call": "horn"})
    run.tick()
    run.state = run.state._replace(leaves={"": Leaf(1, "succeeded")})
    assert run.tick().status == "success"


def test_an_outcome_of_a_leaf_that_does_not_run_changes_nothing() -> None:
    run = Run({"sequence": [{"wait_s": 1.0}, {"action": "drive"}]})
    assert run.tick(0.0, {"sequence/1": "succeeded"}).started == ()
    ticked = run.tick(1.0, {"sequence/1": "succeeded"})
    assert (ticked.status, ticked.started) == ("running", ("sequence/1",))


def test_what_is_started_and_stopped_in_one_tick_is_neither_started_nor_ended() -> None:
    ticked = Run({"running_is_failure": {"action": "drive"}}).tick()
    assert (ticked.status, ticked.started, ticked.ended, ticked.state.leaves) == ("failure", (), (), {})


def test_a_wait_succeeds_at_its_deadline() -> None:
    run = Run({"wait_s": 2.5})
    assert run.tick(1.0).status == "running"
    assert run.wake_at(1.0) == 3.5
    assert run.tick(3.4).status == "running"
    assert run.tick(3.5).status == "success"


def test_a_timeout_ends_its_child_at_its_deadline() -> None:
    run = Run({"timeout": 2, "child": {"action": "drive"}})
    run.tick(1.0)
    assert run.wake_at(1.0) == 3.0
    timed_out = run.tick(3.0)
    assert (timed_out.status, timed_out.ended) == ("failure", ("child",))
    assert run.wake_at(3.0) == math.inf


def test_later_nodes_of_a_tick_see_what_was_set() -> None:
    over = {"check": {"key": "n", ">": 2}}
    run = Run(
        {
            "sequence": [
                {"set": "n", "add": 1},
                over,
                {"set": "spoken", "value": "over"},
                {"publish": "t", "message": {"n": {"from": "n"}}},
            ]
        }
    )
    assert run.tick(n=1).writes == (("n", 2),)
    ticked = run.tick(n=2)
    assert ticked.status == "success"
    assert ticked.writes == (("n", 3), ("spoken", "over"))
    assert [(topic, message.fields) for topic, message in ticked.published] == [("t", {"n": 3})]


@pytest.mark.parametrize(
    ("leaf", "facts", "value"),
    [
        ({"set": "n", "value": 3}, {}, 3),
        ({"set": "n", "add": 2}, {"n": 1}, 3),
        ({"set": "battery", "add": 0.5}, {"battery": 1}, 1.5),
        ({"set": "n", "from": "target.count"}, {"target": {"count": 3}}, 3),
        ({"set": "n", "value": {"from": "target.count"}}, {"target": {"count": 3}}, 3),
    ],
)
def test_a_set_takes_a_value_another_key_or_a_sum(leaf: Any, facts: dict[str, Any], value: Any) -> None:
    ticked = Run(leaf).tick(**facts)
    assert ticked.status == "success"
    assert ticked.writes == ((leaf["set"], value),)
    assert type(ticked.writes[0][1]) is type(value)


@pytest.mark.parametrize(
    ("leaf", "facts"),
    [
        ({"set": "n", "add": 1}, {}),
        ({"set": "n", "add": 0.5}, {"n": 1}),
        ({"set": "n", "from": "target.count"}, {"target": {}}),
        ({"set": "n", "from": "spoken"}, {"spoken": "three"}),
    ],
)
def test_a_set_without_a_value_that_fits_fails_and_writes_nothing(leaf: Any, facts: dict[str, Any]) -> None:
    ticked = Run(leaf).tick(**facts)
    assert (ticked.status, ticked.writes) == ("failure", ())


def test_a_decision_runs_the_subtree_of_its_option() -> None:
    run = Run(asked({"left": {"sequence": [{"wait_s": 1.0}, {"action": "turn"}]}}))
    assert run.tick(0.0).started == ("",)
    assert run.tick(1.0, {"": "left"}).started == ()
    assert run.state.leaves == {}
    assert run.tick(2.0).started == ("then/left/sequence/1",)
    stopped = run.ticker.stop(run.state, seen(2.0, {}))
    assert stopped.ended == ("then/left/sequence/1",)
    assert run.tick(3.0, {"then/left/sequence/1": "succeeded"}).status == "success"


def test_a_decision_succeeds_with_an_option_without_subtree_and_fails_without_an_option() -> None:
    for outcome, status in (("right", "success"), ("timed_out", "failure"), ("succeeded", "failure")):
        run = Run(asked({"left": {"wait_s": 1.0}}))
        run.tick()
        assert run.tick(1.0, {"": outcome}).status == status


def test_a_question_that_is_open_is_withdrawn() -> None:
    run = Run({"eternal_guard": is_true("a"), "child": asked({})})
    run.tick(a=True)
    assert run.tick(a=False).ended == ("child",)


def test_a_branch_that_takes_over_starts_after_the_old_one_has_ended() -> None:
    run = Run({"selector": [{"sequence": [{"check": is_true("a")}, {"action": "flee"}]}, {"action": "work"}]})
    assert run.tick(a=False).started == ("selector/1",)
    ticked = run.tick(a=True)
    assert (ticked.ended, ticked.started) == (("selector/1",), ("selector/0/sequence/1",))
    assert ticked.trace[0] == ("selector/1", "terminate", "invalid")
    assert ("selector/0/sequence/1", "update", "running") in ticked.trace[1:]


def test_a_higher_branch_that_succeeds_at_once_is_reported_after_the_old_one_has_ended() -> None:
    run = Run({"selector": [{"check": is_true("a")}, {"action": "work"}]})
    run.tick(a=False)
    ticked = run.tick(a=True)
    assert (ticked.status, ticked.ended) == ("success", ("selector/1",))
    assert [path for path, *_ in ticked.trace] == ["selector/1", *["selector/0"] * 3, ""]


def test_a_guard_that_fails_in_a_sequence_is_reported_before_what_it_ends() -> None:
    run = Run({"sequence": [{"check": is_true("a")}, {"action": "work"}], "memory": False})
    run.tick(a=True)
    ticked = run.tick(a=False)
    assert (ticked.status, ticked.ended) == ("failure", ("sequence/1",))
    assert ticked.trace[-2:] == (("sequence/1", "terminate", "invalid"), ("", "terminate", "failure"))


def test_a_tick_that_breaks_off_leaves_no_trace() -> None:
    def broken(name: str, arguments: Any) -> Any:
        raise ZeroDivisionError

    class Broken(Facts):
        named = staticmethod(broken)

    run = Run({"sequence": [{"wait_s": 1.0}, {"action": "drive"}, {"check": {"named": "is_crossable"}}]})
    run.tick(0.0)
    run.tick(1.0)
    with pytest.raises(ZeroDivisionError):
        run.ticker.tick(run.state, Broken(2.0, {}), {"sequence/1": "succeeded"})
    assert run.tick(2.0).state.leaves == {"sequence/1": Leaf(1)}


def test_a_tick_reports_which_rounds_of_loops_have_ended() -> None:
    run = Run({"retry": 2, "child": {"action": "grasp"}})
    first = run.tick()
    assert (first.begun, first.rounds) == (("child",), ())
    failed = run.tick(1.0, {"child": "failed"})
    assert (failed.rounds, failed.started) == ((LoopRound("child", True, False, True),), ())
    assert run.tick(1.0).started == ("child",)
    last = run.tick(2.0, {"child": "failed"})
    assert (last.rounds, last.status) == ((LoopRound("child", True, False, False),), "failure")


def test_a_round_may_end_in_the_tick_in_which_it_began() -> None:
    run = Run({"failure_is_running": {"check": is_true("a")}})
    for _ in range(2):
        assert run.tick(a=False).rounds == (LoopRound("failure_is_running", False, True, True),)
    assert run.ticker.reads(run.state) == {"a"}
    assert run.tick(a=True).status == "success"


def test_the_round_of_a_loop_without_a_number_may_take_time() -> None:
    run = Run({"repeat": -1, "child": {"wait_s": 1.0}})
    assert run.tick(0.0).begun == ("child",)
    assert run.tick(1.0).rounds == (LoopRound("child", False, False, True),)
    assert run.tick(1.0).begun == ("child",)
    assert run.wake_at(1.0) == 2.0


def test_a_condition_waits_for_what_its_child_reports() -> None:
    run = Run({"condition": "failure", "child": {"check": is_true("a")}})
    assert run.tick(a=True).status == "running"
    assert run.tick(a=False).status == "success"


def test_a_status_is_written_where_it_is_new() -> None:
    run = Run({"status_to_blackboard": "spoken", "child": {"wait_s": 1.0}})
    assert run.tick(0.0).writes == (("spoken", "running"),)
    assert run.tick(0.5, spoken="running").writes == ()
    assert run.tick(1.0, spoken="running").writes == (("spoken", "success"),)


def test_a_held_guard_counts_from_when_it_became_true() -> None:
    run = Run(
        {
            "sequence": [
                {"wait_s": 1.5},
                {"condition": "success", "child": {"check": {"held": is_true("a"), "for_s": 2}}},
            ]
        }
    )
    run.tick(0.0, a=False)
    assert run.ticker.reads(run.state) == {"a"}
    run.tick(1.0, a=True)
    assert run.wake_at(1.0, a=True) == 1.5
    assert run.tick(1.5, a=True).status == "running"
    assert run.wake_at(1.5, a=True) == 3.0
    assert run.tick(2.9, a=True).status == "running"
    assert run.tick(3.0, a=True).status == "success"


def test_a_held_guard_counts_again_after_a_break() -> None:
    run = Run({"condition": "success", "child": {"check": {"held": is_true("a"), "for_s": 2}}})
    for at, fact in ((0.0, True), (1.0, False), (1.5, True), (2.5, True)):
        assert run.tick(at, a=fact).status == "running"
    assert run.tick(3.5, a=True).status == "success"


def test_a_held_guard_counts_from_what_the_tree_itself_wrote() -> None:
    held = {"condition": "success", "child": {"check": {"held": is_true("a"), "for_s": 2}}}
    run = Run({"sequence": [{"wait_s": 1.0}, {"set": "a", "value": True}, {"wait_s": 0.5}, held]})
    run.tick(0.0)
    run.tick(1.0)
    run.tick(2.0, a=True)
    assert run.wake_at(2.0, a=True) == 3.0


def test_elapsed_counts_from_the_entry_of_the_state_or_else_from_the_first_tick() -> None:
    waits = {"condition": "success", "child": {"check": {"elapsed_s": 3}}}
    run = Run(waits)
    run.tick(1.0)
    assert run.wake_at(1.0) == 4.0
    ticked = run.ticker.tick(run.state, Facts(3.5, {}, entered={"s": 0.5}), {})
    assert ticked.status == "success"


def test_a_guard_that_grows_old_wants_a_tick_then() -> None:
    run = Run(
        {"selector": [{"sequence": [{"check": {"not": {"fresh": "battery"}}}, {"action": "stop"}]}, {"action": "work"}]}
    )
    known = {"battery": Stamped(0.5, 1.0)}
    run.state = run.ticker.tick(run.state, Facts(2.0, known), {}).state
    assert run.ticker.wake_at(run.state, Facts(2.0, known)) == 6.0
    assert run.ticker.tick(run.state, Facts(6.0, known), {}).started == ("selector/0/sequence/1",)


def test_what_an_interrupted_branch_does_not_look_at_is_not_read() -> None:
    run = Run({"sequence": [{"check": is_true("a")}, {"wait_s": 1.0}, {"check": {"key": "n", "==": 1}}]})
    assert run.ticker.reads(run.state) == {"a", "n"}
    run.tick(a=True)
    assert run.ticker.reads(run.state) == frozenset()


def test_a_named_guard_reads_everything() -> None:
    assert Run({"check": {"named": "is_crossable"}}).ticker.reads(TreeState()) == {"*"}
