# SPDX-License-Identifier: Apache-2.0
"""A stop: a pause that ends the goals which a pause would keep."""

from __future__ import annotations

from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.modes import refusal
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.step import CancelGoal, StartGoal, Step
from rai_missions.event import Event
from tests.rigs.charts import mission

KEPT = RobotFacts(keep=frozenset({"go"}))


def begun(**state: Any) -> tuple[Chart, int]:
    """A mission whose one goal is accepted, and that goal's number; its profile keeps it in a pause."""
    made = Chart(mission({"a": {"action": "go", "timeout_s": 60, **state}}), robot_facts=KEPT)
    started = next(each for each in made.start(0.0).effects if isinstance(each, StartGoal))
    made.send(Event("go", 0.5, {}, "accepted", started.number))
    return made, started.number


def commanded(made: Chart, name: str, at: float) -> Step:
    return made.send(Event(name, at, {"by": "operator"}, "command"))


def canceled(step: Step) -> list[int]:
    return [each.number for each in step.effects if isinstance(each, CancelGoal)]


def test_a_stop_cancels_a_goal_that_a_pause_keeps_and_starts_it_again_when_resumed() -> None:
    made, number = begun()
    assert canceled(commanded(made, "pause", 1.0)) == [], "the profile keeps it"
    stopped = commanded(made, "stop", 2.0)
    assert (stopped.mode, canceled(stopped)) == ("paused", [number])
    made.send(Event("canceled", 3.0, {}, "result", number))
    assert made.mode == "paused" and made.awaited_goals == 0
    resumed = commanded(made, "resume", 4.0)
    assert [type(each) for each in resumed.effects] == [StartGoal] and resumed.mode == "running"


def test_a_second_stop_changes_nothing() -> None:
    made, number = begun()
    assert canceled(commanded(made, "stop", 1.0)) == [number]
    again = commanded(made, "stop", 2.0)
    assert again.effects == () and again.mode == "paused"


def test_a_goal_that_is_kept_while_the_operator_has_control_ends_with_a_stop_and_waits_for_the_hand_back() -> None:
    made, number = begun(control="autonomy")
    made.send(Event("operator", 1.0, {"by": "operator", "role": "operator"}, "control"))
    assert canceled(commanded(made, "stop", 2.0)) == [number]
    made.send(Event("canceled", 2.5, {}, "result", number))
    assert not [each for each in commanded(made, "resume", 3.0).effects if isinstance(each, StartGoal)]
    back = made.send(Event("autonomy", 4.0, {"by": "operator", "role": "operator"}, "control"))
    assert [each.action for each in back.effects if isinstance(each, StartGoal)] == ["go"]


def test_a_mission_that_is_being_canceled_is_not_stopped() -> None:
    assert refusal("canceling", "stop") == "only a running or paused mission can be stopped; it is canceling"


@given(
    st.lists(st.sampled_from(["pause", "resume", "stop", "accepted", "canceled", "operator", "autonomy"]), max_size=12)
)
def test_after_a_stop_no_goal_executes_that_has_not_been_canceled(words: list[str]) -> None:
    made, number = begun(control="autonomy")
    sent: set[int] = set()
    for at, word in enumerate([*words, "stop"], start=1):
        if made.outcome is not None:
            return
        kind = {"accepted": "accepted", "canceled": "result", "operator": "control", "autonomy": "control"}.get(word)
        name = "go" if word == "accepted" else word
        step = made.send(Event(name, float(at), {"by": "operator"}, kind or "command", number))  # type: ignore[arg-type]
        sent.update(canceled(step))
        for each in step.effects:
            if isinstance(each, StartGoal):
                number = each.number
                made.send(Event("go", at + 0.5, {}, "accepted", number))
    goals = [Goal(*each) for each in made.snapshot()["goals"]]
    assert all(goal.phase != "running" for goal in goals), (words, goals)
    assert made.outcome is not None or made.mode == "paused"
