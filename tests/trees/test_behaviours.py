# SPDX-License-Identifier: Apache-2.0
"""Behaviours written in Python: a leaf in the tree, and the live one next to the mission."""

from __future__ import annotations

from typing import Any

import py_trees
import pytest
from py_trees.common import Status

from rai_missions import Mission, On, dump
from rai_missions.engine import Chart
from rai_missions.engine.activities.ticker import TreeState
from rai_missions.errors import DefinitionError, UsageError
from rai_missions.event import Event
from rai_missions.states.final import Final
from rai_missions.states.tree import Behaviour, Check, EternalGuard, Tree, Wait
from rai_missions.trees import PyTrees
from rai_missions.trees.python_behaviour import LiveBehaviour
from tests.trees.growing import is_true, seen


class Worker(py_trees.behaviour.Behaviour):
    """Reports what it is asked to state, and writes down its calls."""

    def __init__(self, *states: Any) -> None:
        super().__init__("worker")
        self.statuses, self.calls = list(states), []  # type: ignore[var-annotated]

    def setup(self, **kwargs: Any) -> None:
        self.calls.append("setup")

    def update(self) -> Status:
        reported = self.statuses.pop(0)
        if isinstance(reported, Exception):
            raise reported
        return reported  # type: ignore[no-any-return]

    def terminate(self, new_status: Status) -> None:
        self.calls.append(f"terminate {new_status.value}")

    def shutdown(self) -> None:
        self.calls.append("shutdown")


def make() -> Worker:
    return Worker(Status.RUNNING)


def test_a_state_may_run_a_factory() -> None:
    state = Tree(make, tick_s=0.5, timeout_s=10.0)
    assert state.tree == Behaviour(make, 0.5)
    assert state.timeout_s == 10.0
    assert Tree(make).tree.tick_s == 0.1


def test_a_period_without_a_factory_is_refused() -> None:
    with pytest.raises(DefinitionError, match="tick_s"):
        Tree(Check({"in": "s"}), tick_s=0.5)
    with pytest.raises(DefinitionError, match="/factory: 3 cannot be called; give a function that makes a behaviour"):
        Behaviour(3)


def test_a_behaviour_in_python_is_not_written_as_json() -> None:
    reported = r"test_behaviours\.make': a behaviour in Python cannot be written as JSON, which holds no code"
    with pytest.raises(UsageError, match=reported):
        Behaviour(make).written()
    mission = Mission("m", initial="work", states={"work": Tree(make), "over": Final("aborted")})
    with pytest.raises(UsageError, match="state 'work' runs '.*" + reported):
        dump(mission)


def test_a_leaf_reports_what_its_behaviour_reported() -> None:
    ticker = PyTrees().compile(Tree(make).tree, "/tree", {}, "s")
    first = ticker.tick(TreeState(), seen(0.0, {}), {})
    assert (first.status, first.started) == ("running", ("",))
    for reported, status in (
        ("running", "running"),
        ("success", "success"),
        ("failure", "failure"),
        ("invalid", "failure"),
    ):
        assert ticker.tick(first.state, seen(1.0, {}), {"": reported}).status == status


@pytest.mark.parametrize(
    ("data", "ended"), [({}, ("child",)), ({"child": "running"}, ("child",)), ({"child": "success"}, ())]
)
def test_a_behaviour_that_runs_on_is_ended_and_one_that_has_ended_is_not(data: dict[str, str], ended: Any) -> None:
    ticker = PyTrees().compile(EternalGuard(Behaviour(make), is_true("a")), "/tree", {}, "s")
    state = ticker.tick(TreeState(), seen(0.0, {"a": True}), {}).state
    assert ticker.tick(state, seen(1.0, {"a": False}), data).ended == ended


def test_a_live_behaviour_is_set_up_ticked_and_put_away() -> None:
    worker = Worker(Status.RUNNING, Status.RUNNING)
    with LiveBehaviour(Behaviour(lambda: worker)) as live:
        assert (live.tick(), live.tick()) == ("running", "running")
    assert worker.calls == ["setup", "terminate INVALID", "shutdown"]


def test_a_live_behaviour_that_has_ended_is_not_interrupted() -> None:
    worker = Worker(Status.SUCCESS)
    with LiveBehaviour(Behaviour(lambda: worker)) as live:
        assert live.tick() == "success"
    assert worker.calls == ["setup", "terminate SUCCESS", "shutdown"]


@pytest.mark.parametrize("states", [ValueError("no"), Status.INVALID, Status.FAILURE])
def test_a_behaviour_that_raises_or_reports_nothing_has_failed(states: Any) -> None:
    assert LiveBehaviour(Behaviour(lambda: Worker(states))).tick() == "failure"


def test_a_factory_that_makes_something_else_is_refused() -> None:
    with pytest.raises(UsageError, match=r"made 3; it must make a py_trees\.behaviour\.Behaviour"):
        LiveBehaviour(Behaviour(lambda: 3))


def test_the_end_of_another_behaviour_ends_none() -> None:
    working = Tree(make, tick_s=0.5, timeout_s=60.0, transitions=[On("succeeded", to="over")])
    made = Chart(Mission("m", initial="working", states={"working": working, "over": Final("canceled")}), PyTrees())
    made.start(0.0)
    (number,) = made.awaited
    assert made.send(Event("w", 1.0, {"status": "success"}, "behaviour", number + 1)).ignored
    assert made.send(Event("w", 1.0, {"status": "success"}, "result", number)).ignored
    assert made.send(Event("w", 1.0, {"status": "success"}, "behaviour", number)).outcome == "canceled"


@pytest.mark.parametrize(
    ("made", "sentence"),
    [
        (lambda: Tree(Worker("ok")), r"/factory: <.*> cannot be called; give a function that makes a behaviour of"),
        (lambda: Tree(Worker("ok"), tick_s=0.2), r"/factory: <.*> cannot be called; give a function that makes"),
        (lambda: Tree(Wait), r"/tree: a tree node is an object, not .*; write WaitLeaf\(…\)$"),
        (lambda: Tree([Wait(1)]), r"/tree: a tree node is an object, not \["),
        (
            lambda: Tree(Wait(1), tick_s=0.2),
            r"/tick_s: a tree of nodes is ticked when something changes; leave 'tick_s'",
        ),
    ],
)
def test_what_is_no_tree_and_makes_none_is_refused_with_what_would_be_right(made: Any, sentence: str) -> None:
    with pytest.raises(DefinitionError, match=sentence):
        made()
