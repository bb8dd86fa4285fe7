# SPDX-License-Identifier: Apache-2.0
"""A tree that goes round: as often as it reports, as far as a step has room, and it never fails for it."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.activities.tree_rounds import MOST_ROUNDS, MOST_WAKES
from rai_missions.engine.snapshot_json import packed, unpacked
from rai_missions.engine.step import CallService, PublishMessage, Step
from rai_missions.engine.trees import CompiledTrees
from rai_missions.event import Event, Tick
from rai_missions.journal.codec import decode, encode
from rai_missions.mission.mission import Mission

COUNT = {"set": "n", "add": 1}
KEYS = {
    "n": {"type": "integer", "initial": 0},
    "waiting": {"type": "boolean", "initial": False},
    "door": {"type": "boolean", "source": "robot", "max_age_s": 30},
    "target": {"type": "string", "source": "robot"},
}


def above(number: int) -> dict[str, Any]:
    return {"check": {"key": "n", ">": number}}


def working(tree: Any, **neighbours: Any) -> Chart:
    """A chart that runs a tree; other states next to it make it a region."""
    ends = [{"on": "succeeded", "to": "good"}, {"on": "failed", "to": "bad"}]
    states: dict[str, Any] = {
        "work": {"tree": tree, "transitions": ends}, "good": {"final": "aborted"}, "bad": {"final": "failed"}
    }  # fmt: skip
    if neighbours:
        one, other = {"initial": "work", "states": states}, {"initial": next(iter(neighbours)), "states": neighbours}
        states = {"both": {"parallel": {"one": one, "other": other}}}
    data = {"name": "m", "initial": next(iter(states)), "blackboard": KEYS, "states": states, "events": {"poke": {}}}
    return Chart(Mission.model_validate(data), CompiledTrees())


def count(chart: Chart) -> int:
    value: int = chart.view.board["n"].value
    return value


# -- what a tree writes ---------------------------------------------------------------------------------------------


def test_a_transition_next_to_a_tree_sees_what_it_writes() -> None:
    keep = {"sequence": [COUNT, {"check": {"key": "waiting", "==": True}}], "memory": False}
    pokes = {"on": "poke", "do": [{"set": "waiting", "value": True}]}
    waits = {"waits": {"transitions": [pokes, {"when": {"key": "n", ">=": 2}, "to": "there"}]}, "there": {}}
    chart = working({"selector": [{"success_is_failure": keep}, {"wait_s": 99}]}, **waits)
    chart.start()
    assert "waits" in chart.active
    assert chart.send(Event("poke", 1.0)).entered == ("there",)


def test_a_tree_sees_what_it_writes_itself() -> None:
    chart = working({"selector": [{"sequence": [COUNT, above(5)], "memory": False}, {"wait_s": 9}]})
    assert (chart.start().outcome, count(chart)) == ("aborted", 6)


def test_writing_the_same_value_again_is_no_reason_to_tick() -> None:
    keep = {"sequence": [{"set": "waiting", "value": True}, {"check": {"key": "waiting", "==": False}}]}
    chart = working({"selector": [keep | {"memory": False}, {"wait_s": 9}]})
    assert chart.start().writes == (("waiting", True), ("waiting", True))


def test_a_reading_of_the_same_value_begins_no_round_and_keeps_the_key_fresh() -> None:
    chart = working({"failure_is_running": {"sequence": [COUNT, {"check": {"key": "door", "==": True}}]}})
    chart.start()
    counts = [count(chart)]
    for at, value in [(1.0, False), (2.0, False), (31.9, False), (40.0, False)]:
        chart.write("door", value, at)
        counts.append(count(chart))
    assert counts == [1, 2, 2, 2, 2]
    chart.send(Tick(69.0))
    assert (count(chart), chart.wake_at) == (2, 70.0)
    chart.send(Tick(70.0))
    assert count(chart) == 3


def test_trees_that_wake_one_another_rest() -> None:
    def follows(own: int) -> dict[str, Any]:
        turn = {"check": {"key": "n", "==": 1 - own}}
        return {"selector": [{"sequence": [turn, {"set": "n", "value": own}], "memory": False}, {"wait_s": 9}]}

    ever = {"repeat": -1, "child": {"failure_is_success": follows(0)["selector"][0]}}
    chart = working(
        {"repeat": -1, "child": {"failure_is_success": follows(1)["selector"][0]}}, other_tree={"tree": ever}
    )
    step = chart.start()
    assert step.outcome is None
    assert set(step.resting) == {"work", "other_tree"}
    assert len(step.writes) <= 2 * (MOST_WAKES + 1)


# -- loops ----------------------------------------------------------------------------------------------------------


def test_a_loop_without_a_number_rests_until_something_concerns_it() -> None:
    waits = [{"set": "waiting", "value": True}, {"check": {"key": "door", "==": True}}]
    chart = working({"failure_is_running": {"sequence": waits}})
    started = chart.start()
    assert (started.outcome, started.resting) == (None, ())
    assert chart.write("door", False, 1.0).outcome is None
    assert chart.write("door", True, 2.0).outcome == "aborted"


@pytest.mark.parametrize("rounds", [999, 1000, 1001, MOST_ROUNDS])
def test_a_loop_with_a_number_goes_round_so_often(rounds: int) -> None:
    chart = working({"repeat": rounds, "child": COUNT})
    assert (chart.start().outcome, count(chart)) == ("aborted", rounds)


def test_rounds_without_room_follow_at_the_same_instant_in_the_next_step() -> None:
    chart = working({"repeat": 30, "child": {"repeat": 1000, "child": COUNT}})
    step, steps, before = chart.start(5.0), 1, 0
    while step.outcome is None:
        assert (step.resting, step.at, step.wake_at) == (("work",), 5.0, 5.0)
        assert MOST_ROUNDS - 10 <= count(chart) - before <= MOST_ROUNDS
        before = count(chart)
        step, steps = chart.send(Tick(5.0)), steps + 1
    assert (count(chart), steps, step.outcome, step.resting) == (30_000, 4, "aborted", ())


def test_rounds_that_follow_come_before_what_happens_later() -> None:
    chart = working({"repeat": 20, "child": {"repeat": 1000, "child": COUNT}})
    chart.start(5.0)
    before = count(chart)
    step = chart.write("n", 0, 9.0)
    assert (step.writes[0], step.writes[-1]) == (("n", before + 1), ("n", 0))


def test_a_tree_that_rests_at_its_limit_continues_in_a_restored_chart() -> None:
    chart = working({"repeat": 12, "child": {"repeat": 1000, "child": COUNT}})
    chart.start()
    restored = Chart.restore(chart.mission, unpacked(packed(chart.snapshot())), CompiledTrees())
    assert restored.send(Tick(0.0)) == chart.send(Tick(0.0))
    assert restored.outcome == "aborted"


def test_a_tree_that_writes_what_it_looks_at_rests_after_a_thousand_times() -> None:
    chart = working({"repeat": -1, "child": {"sequence": [COUNT, above(0)]}})
    step = chart.start()
    assert (step.resting, step.outcome, step.wake_at, count(chart)) == (("work",), None, None, MOST_WAKES + 1)
    assert chart.write("door", True, 1.0).resting == ("work",)  # concerns it not
    assert count(chart) == MOST_WAKES + 1
    chart.write("n", 7, 2.0)
    assert count(chart) == 7 + MOST_WAKES + 1


def test_a_step_that_takes_the_short_way_reports_what_rests_too() -> None:
    data = working({"repeat": -1, "child": {"sequence": [COUNT, above(0)]}}).mission.written()
    data |= {"transitions": [{"on": "poke", "do": [{"log": "poked"}]}]}
    chart = Chart(Mission.model_validate(data), CompiledTrees())
    chart.start()
    assert chart.send(Event("poke", 1.0)).resting == ("work",)


def test_a_journal_holds_which_trees_rest() -> None:
    step = working({"repeat": 30, "child": {"repeat": 1000, "child": COUNT}}).start()
    assert encode(step)["resting"] == ["work"]
    assert decode(encode(step)) == step


def calls(step: Step) -> list[int]:
    return [effect.number for effect in step.effects if isinstance(effect, CallService)]


def test_a_round_that_took_time_is_followed_by_the_next_at_once_also_at_the_same_stamp() -> None:
    chart = working({"repeat": -1, "child": {"call": "look", "timeout_s": 5}})
    step = chart.start()
    for number in range(1, 200):
        assert calls(step) == [number]
        step = chart.send(Event("succeeded", 0.0, {}, "result", number))
        assert step.outcome is None


def test_what_is_refused_as_soon_as_it_is_begun_is_asked_again_when_it_could_do() -> None:
    call = {"call": "look", "timeout_s": 5, "request": {"at": {"from": "target"}}}
    chart = working({"failure_is_running": call})
    assert calls(chart.start()) == []
    assert calls(chart.write("door", True, 1.0)) == []
    assert len(calls(chart.write("target", "tree", 2.0))) == 1


def test_refused_calls_without_memory_do_not_hold_a_step() -> None:
    call = {"call": "look", "timeout_s": 5, "request": {"at": {"from": "target"}}}
    chart = working({"selector": [call, call, {"wait_s": 9}]})
    step = chart.start()
    assert (step.outcome, step.resting) == (None, ("work",))
    assert len(calls(chart.write("target", "tree", 1.0))) == 1


def test_a_loop_over_what_a_tree_publishes_publishes_once_a_reason() -> None:
    loop = {"repeat": -1, "child": {"sequence": [{"check": {"fresh": "door"}}, {"publish": "lamp", "message": {}}]}}
    chart = working({"failure_is_running": loop})
    chart.start()
    published = [chart.write("door", value, at).effects for at, value in [(1.0, True), (2.0, True), (3.0, False)]]
    assert published == [(PublishMessage("lamp", {}),), (), (PublishMessage("lamp", {}),)]


def test_one_jump_goes_round_like_small_ticks() -> None:
    tree = {"repeat": -1, "child": {"sequence": [{"wait_s": 2}, {"repeat": 3, "child": COUNT}]}}
    jumped, ticked = working(tree), working(tree)
    jumped.start()
    ticked.start()
    jumped.send(Tick(100.0))
    for at in range(1, 201):
        ticked.send(Tick(at / 2))
    assert count(jumped) == count(ticked) == 150
    assert jumped.snapshot()["_running"] == ticked.snapshot()["_running"]


def test_what_ended_once_for_all_is_not_looked_at_any_more() -> None:
    chart = working({"selector": [{"one_shot": {"check": {"key": "door", "==": True}}}, {"wait_s": 99}]})
    chart.start()
    assert chart.write("door", True, 1.0).outcome is None
    assert chart.wake_at == 99.0
