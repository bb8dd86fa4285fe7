# SPDX-License-Identifier: Apache-2.0
"""Trees inside a mission: what a chart makes of their ticks."""

from __future__ import annotations

from typing import Any

from rai_missions import Chart, Event, Mission, Tick
from rai_missions.event import Event as AnyEvent
from rai_missions.step import CallService, CancelGoal, StartGoal, Step
from rai_missions.trees import PyTrees

KEYS = {"near": {"type": "boolean", "source": "robot"}, "n": {"type": "integer", "initial": 0}}


def chart(tree: Any) -> Chart:
    states = {
        "work": {"tree": tree, "transitions": [{"on": "succeeded", "to": "over"}, {"on": "failed", "to": "lost"}]},
        "over": {"final": "aborted"},
        "lost": {"final": "failed"},
    }
    mission = {"format": 1, "name": "m", "initial": "work", "blackboard": KEYS, "events": {"go": {}}, "states": states}
    return Chart(Mission.model_validate(mission), ticker=PyTrees())


def kinds(step: Step) -> list[type]:
    return [type(effect) for effect in step.effects]


def result(step: Step, name: str, at: float, *, kind: str = "result") -> AnyEvent:
    """What is heard of what a step started last."""
    started = [effect for effect in step.effects if isinstance(effect, StartGoal | CallService)]
    return Event(name, at, {}, kind, started[-1].number)


def test_a_takeover_cancels_before_it_starts() -> None:
    run = chart(
        {"selector": [{"sequence": [{"check": {"key": "near", "==": True}}, {"call": "horn"}]}, {"action": "go"}]}
    )
    started = run.start(at=0.0)
    assert kinds(started) == [StartGoal]
    run.send(result(started, "go", 0.5, kind="accepted"))
    assert kinds(run.write("near", True, at=1.0)) == [CancelGoal, CallService]


def test_a_key_that_no_guard_looks_at_ticks_nothing() -> None:
    run = chart({"sequence": [{"wait_s": 5}, {"check": {"key": "near", "==": True}}]})
    assert run.start(at=0.0).wake_at == 5.0
    assert run.write("near", True, at=1.0).ignored
    assert run.send(Tick(5.0)).outcome == "aborted"


def test_a_retry_begins_anew_in_the_step_of_the_failure() -> None:
    run = chart({"retry": 2, "child": {"sequence": [{"set": "n", "add": 1}, {"call": "horn"}]}})
    first = run.start(at=0.0)
    second = run.send(result(first, "failed", 1.0))
    assert kinds(second) == [CallService]
    assert second.writes == (("n", 2),)
    assert run.send(result(second, "failed", 2.0)).outcome == "failed"


def test_a_loop_without_end_that_takes_no_time_ends_the_state() -> None:
    run = chart({"repeat": -1, "child": {"set": "n", "add": 1}})
    ended = run.start(at=0.0)
    assert ended.outcome == "failed"
    assert any("without coming to rest" in note for note in ended.notes)


def test_the_result_of_a_run_that_was_ended_does_not_complete_the_next() -> None:
    run = chart(
        {
            "selector": [
                {"sequence": [{"check": {"key": "near", "==": True}}, {"wait_s": 9}], "memory": False},
                {"call": "horn"},
            ]
        }
    )
    first = run.start(at=0.0)
    run.write("near", True, at=1.0)
    assert kinds(run.write("near", False, at=2.0)) == [CallService]
    assert run.send(result(first, "succeeded", 3.0)).outcome is None


def test_a_restored_chart_goes_on_inside_its_tree() -> None:
    run = chart({"sequence": [{"set": "n", "add": 1}, {"wait_s": 5}, {"call": "horn"}]})
    run.start(at=0.0)
    saved = run.snapshot()
    again = Chart.restore(run.mission, saved, ticker=PyTrees())
    assert kinds(again.send(Tick(5.0))) == kinds(run.send(Tick(5.0))) == [CallService]
