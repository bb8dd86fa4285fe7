# SPDX-License-Identifier: Apache-2.0
"""What no one should send to a chart, and what a robot may state all the same."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.step import CancelGoal
from rai_missions.engine.trees import CompiledTrees
from rai_missions.errors import UsageError
from rai_missions.event import Event, Tick
from tests.rigs.charts import chart, mission, transition

FACT = {"k": {"type": "integer", "source": "robot", "max_age_s": 2}}
DRIVE: dict[str, Any] = {
    "a": {"action": "drive", "timeout_s": 99, "transitions": [transition("stop", "b"), transition("failed", "c")]},
    "b": {},
    "c": {},
}


@pytest.mark.parametrize("at", [math.nan, math.inf, -math.inf])
def test_an_event_at_no_time_is_refused_and_changes_nothing(at: float) -> None:
    made = chart({"a": {"transitions": [transition("x", "b")]}, "b": {"transitions": [{"after_s": 3, "to": "a"}]}})
    with pytest.raises(UsageError, match="finite"):
        made.send(Event("x", at))
    assert (made.at, made.active) == (0.0, {"a"})


@pytest.mark.parametrize("given", ["go", "drive", 5, None, ("go", 1.0), {"name": "go"}, list("abcde")])
def test_what_is_no_event_is_refused_and_changes_nothing(given: Any) -> None:
    made = chart({"a": {"transitions": [transition("x", "b")]}, "b": {}})
    for each in (made, Chart(mission(DRIVE))):
        before = each.snapshot()
        with pytest.raises(UsageError, match=r"a chart is sent an Event, not .*; write Event\('go', at=3.2\)"):
            each.send(given)
        assert each.snapshot() == before


@pytest.mark.parametrize("given", ["mission.json", Path("mission.json"), {"name": "m"}, None])
def test_what_is_no_mission_makes_no_chart(given: Any) -> None:
    with pytest.raises(UsageError, match=r"a chart takes a Mission, not .*; load\(FILE\) makes one of a file"):
        Chart(given)


def test_an_event_of_no_kind_is_refused_with_the_nearest() -> None:
    step = chart({"a": {}}).send(Event("x", 1.0, {}, "resutl"))
    assert step.ignored and step.why == "there is no event of kind 'resutl'; did you mean 'result'?"


@pytest.mark.parametrize(
    "states",
    [
        {"a": {"transitions": [{"after_s": 0, "to": "b"}]}, "b": {"transitions": [{"after_s": 0, "to": "a"}]}},
        {
            "a": {
                "entry": [{"raise": "x", "after_s": 0}],
                "transitions": [transition("x", do=[{"raise": "x", "after_s": 0}])],
            }
        },
    ],
)
def test_timers_that_are_due_at_once_for_ever_end_the_mission(states: dict[str, Any]) -> None:
    step = chart(states).send(Tick(1.0))
    assert step.outcome == "failed" and step.why.startswith("timers without end in ")


def test_a_fact_without_a_time_is_of_now() -> None:
    made = Chart(
        mission({"a": {"transitions": [transition(when={"key": "k", "==": 1}, to="b")]}, "b": {}}, blackboard=FACT)
    )
    made.start(100.0)
    assert made.write("k", 1).entered == ("b",)


@pytest.mark.parametrize("kind", ["number", "integer", "pose"])
def test_an_integer_beyond_all_floating_point_numbers_is_not_written(kind: str) -> None:
    made = Chart(mission({"a": {}}, blackboard={"k": {"type": kind, "source": "robot"}}))
    made.start(0.0)
    step = made.write("k", {"x": 10**400, "y": 0} if kind == "pose" else 10**400)
    assert not step.writes and "is not of type" in step.why


def test_an_acceptance_after_an_e_stop_is_canceled_once_more() -> None:
    made = Chart(mission(DRIVE))
    made.start(0.0)
    made.send(Event("kill", 1.0, {}, "command"))
    assert CancelGoal(1, "drive") in made.send(Event("drive", 1.5, {}, "accepted", 1)).effects


def test_a_server_s_unknown_word_is_a_failure() -> None:
    made = Chart(mission(DRIVE))
    made.start(0.0)
    step = made.send(Event("ABORTED", 1.0, {}, "result", 1))
    assert step.entered == ("c",)
    assert "a failed: its server said 'ABORTED'" in step.notes


def asking(**named: Any) -> Chart:
    """A chart whose way on is a predicate over `k` and twice `k`."""
    guard = {"named": "far", "with": {"than": {"from": "k"}, "by": 2}}
    made = Chart(
        mission({"a": {"transitions": [transition("x", "b", when=guard)]}, "b": {}}, blackboard=FACT),
        named=named,
    )
    made.start(0.0)
    return made


def test_a_predicate_is_given_the_value_that_its_argument_is_taken_from() -> None:
    made = asking(far=lambda board, than, by: (board["k"], than, by) == (7, 7, 2))
    made.write("k", 7, at=1.0)
    assert made.send(Event("x", 2.0)).entered == ("b",)


def test_a_predicate_is_not_asked_about_what_is_unknown_and_is_shown_nothing_stale() -> None:
    asked = []
    made = asking(far=lambda board, than, by: asked.append(than) or True)
    assert made.send(Event("x", 1.0)).ignored and not asked
    made.write("k", 7, at=2.0)
    assert made.send(Event("x", 4.0)).ignored and not asked
    seen: list[dict[str, Any]] = []
    plain = Chart(
        mission({"a": {"transitions": [transition("x", when={"named": "far"})]}}, blackboard=FACT),
        named={"far": lambda board: seen.append(board) or False},
    )
    plain.start(0.0)
    plain.write("k", 7, at=1.0)
    plain.send(Event("x", 2.0))
    plain.send(Event("x", 3.0))
    assert seen == [{"k": 7}, {}]


def test_what_a_predicate_reported_is_in_its_own_step_whether_or_not_the_transition_fires() -> None:
    made = asking(far=lambda board, than, by: False)
    made.write("k", 7, at=1.0)
    assert ("named:far", False) in made.send(Event("x", 1.5)).guards
    assert made.send(Tick(1.6)).guards == ()


@pytest.mark.parametrize("value", [1, "true", [True], 0.0])
def test_a_predicate_that_returns_no_truth_is_unknown_and_the_step_notes_it(value: Any) -> None:
    made = asking(far=lambda board, than, by: value)
    made.write("k", 7, at=1.0)
    step = made.send(Event("x", 1.5))
    note = f"guard 'far' raised TypeError: it returned {value!r}; give True, False, or None for unknown"
    assert (step.entered, step.notes) == ((), (note,))
    assert ("named:far#0", None) in step.guards


def test_a_long_wait_does_at_each_instant_what_waking_there_does() -> None:
    late = {
        "tree": {"action": "cross", "timeout_s": 5},
        "transitions": [{"after_s": 5, "do": [{"set": "n", "value": 2}]}],
    }
    first = {
        "action": "drive",
        "timeout_s": 30,
        "transitions": [transition("timed_out", "b", do=[{"set": "n", "value": 1}])],
    }
    boards = []
    for instants in ((40.0,), (30.0, 35.0, 40.0)):
        made = Chart(mission({"a": first, "b": late}, blackboard={"n": {"type": "integer"}}), CompiledTrees())
        made.start(0.0)
        for at in instants:
            made.send(Tick(at))
        boards.append(made.view.board["n"])
    assert boards == [(2, 35.0)] * 2


def test_what_answers_nothing_does_not_tick_a_tree() -> None:
    tree = {"selector": [{"inverter": {"set": "n", "add": 1}}, {"call": "horn"}]}
    made = Chart(mission({"a": {"tree": tree}}, blackboard={"n": {"type": "integer"}}), CompiledTrees())
    made.start(0.0)
    step = made.send(Event("succeeded", 1.0, {}, "accepted", 99))
    assert step.writes == () and step.why == "stale: nothing that was started as 99 is running"
