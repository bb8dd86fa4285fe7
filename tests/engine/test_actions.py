# SPDX-License-Identifier: Apache-2.0
"""A goal belongs to the state that started it until its end is confirmed, in every window."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.step import CallService, CancelGoal, Handover, StartGoal, Step
from rai_missions.event import Event
from tests.rigs.charts import mission, sent, ticked, transition

BOARD = {"there": {"type": "boolean", "source": "robot", "max_age_s": 5}}
DONE = transition("succeeded", "done")
THERE = {"key": "there", "==": True}


def driving(**words: Any) -> dict[str, Any]:
    return {
        "drive": {"action": "go", "timeout_s": 60, "transitions": [DONE, transition("e", "other")], **words},
        "other": {"action": "turn", "timeout_s": 60, "transitions": [DONE, transition("rejected", "lost")]},
        "done": {}, "lost": {},
    }  # fmt: skip


def started(states: dict[str, Any], robot_facts: RobotFacts | None = None, **words: Any) -> tuple[Chart, int]:
    made = Chart(mission(states, **words), robot_facts=robot_facts)
    step = made.start(0.0)
    return made, starts(step)[0].number


def starts(step: Step) -> list[StartGoal]:
    return [effect for effect in step.effects if isinstance(effect, StartGoal)]


def cancels(step: Step) -> list[int]:
    return [effect.number for effect in step.effects if isinstance(effect, CancelGoal)]


def reports(made: Chart, name: str, number: int, at: float | None = None, **data: Any) -> Step:
    kind = "accepted" if name == "accepted" else "result"
    return made.send(Event(name, made.at if at is None else at, data, kind, number))


def test_an_action_that_succeeds_is_its_state_s_success() -> None:
    made, number = started(driving())
    reports(made, "accepted", number)
    assert reports(made, "succeeded", number).entered == ("done",)


def test_an_action_that_aborts_does_not_look_like_one_that_succeeded() -> None:
    made, number = started(driving())
    step = reports(made, "failed", number, why="wheel stuck")
    assert (step.outcome, step.why) == ("failed", "drive: failed (wheel stuck)")


def test_success_counts_only_while_the_facts_agree() -> None:
    made, number = started(driving(achieved=THERE), blackboard=BOARD)
    step = reports(made, "succeeded", number)
    assert step.outcome == "failed"
    assert (
        step.why == "drive: unverified (the server said succeeded, but 'there is true' is unknown (never heard: there))"
    )


def test_a_stale_fact_does_not_pass_for_a_fresh_one() -> None:
    made, number = started(driving(achieved=THERE), blackboard=BOARD)
    made.write("there", True, at=1.0)
    assert reports(made, "succeeded", number, at=6.0).outcome == "failed"


def test_facts_may_take_a_while_to_settle() -> None:
    made, number = started(driving(achieved=THERE, settle_s=2), blackboard=BOARD)
    assert reports(made, "succeeded", number, at=1.0).moves == ()
    assert made.wake_at == 3.0
    assert made.write("there", True, at=2.5).entered == ("done",)


def test_facts_that_do_not_settle_in_time_leave_it_unverified() -> None:
    made, number = started(driving(achieved=THERE, settle_s=2), blackboard=BOARD)
    reports(made, "succeeded", number, at=1.0)
    assert ticked(made, 3.0).outcome == "failed"


def test_leaving_the_state_cancels_its_goal_and_the_next_start_waits_for_its_end() -> None:
    made, number = started(driving())
    reports(made, "accepted", number)
    step = sent(made, "e")
    assert cancels(step) == [number] and not starts(step)
    step = reports(made, "canceled", number)
    assert [start.action for start in starts(step)] == ["turn"]


def test_a_cancel_before_the_acceptance_is_sent_as_soon_as_it_is_accepted() -> None:
    made, number = started(driving())
    assert cancels(sent(made, "e")) == []
    assert cancels(reports(made, "accepted", number)) == [number]
    assert starts(reports(made, "canceled", number))


def test_a_rejection_after_the_state_was_left_frees_the_resources() -> None:
    made, number = started(driving())
    sent(made, "e")
    assert starts(reports(made, "rejected", number))


def test_a_start_that_waited_and_fails_at_once_is_handled_in_the_step_that_frees_the_resources() -> None:
    keys = {"goal": {"type": "string", "source": "robot", "optional": True}}
    states = driving()
    states["other"]["goal"] = {"to": {"from": "goal"}}
    made, number = started(states, blackboard=keys)
    reports(made, "accepted", number)
    assert sent(made, "e").entered == ("other",)
    assert reports(made, "canceled", number).entered == ("lost",)


def test_a_late_success_of_the_old_goal_is_not_the_new_state_s_success() -> None:
    made, number = started(driving())
    reports(made, "accepted", number)
    sent(made, "e")
    step = reports(made, "succeeded", number)
    assert made.active == {"other"} and starts(step)


def test_a_result_that_comes_twice_changes_nothing_the_second_time() -> None:
    made, number = started(driving())
    reports(made, "succeeded", number)
    step = reports(made, "succeeded", number)
    assert step.ignored and step.why == f"stale: nothing that was started as {number} is running"


def test_actions_that_share_nothing_run_side_by_side() -> None:
    robot_facts = RobotFacts(uses={"go": frozenset({"base"}), "turn": frozenset({"arm"})})
    made, number = started(driving(), robot_facts)
    reports(made, "accepted", number)
    step = sent(made, "e")
    assert cancels(step) == [number] and starts(step)


def test_a_goal_whose_end_is_never_confirmed_is_orphaned_and_bars_the_next_start() -> None:
    made, number = started(driving(cancel_s=3))
    reports(made, "accepted", number, at=1.0)
    sent(made, "e", at=2.0)
    assert made.wake_at == 5.0
    step = ticked(made, 5.0)
    assert made.active == {"lost"} and not starts(step)
    assert f"goal {number} of 'go' never confirmed its end: orphaned" in step.notes


def test_only_a_cancel_can_be_overdue() -> None:
    """A server that gives up a goal which the mission still wants changes nothing: its timeout is the mission's."""
    made, number = started(driving())
    reports(made, "accepted", number, at=1.0)
    made.send(Event("go", 2.0, {"why": "it has not ended"}, "overdue", number))
    assert ticked(made, 3.0).outcome is None and made.wake_at == 60.0
    sent(made, "e", at=4.0)
    step = made.send(Event("go", 4.5, {"why": "it has not ended"}, "overdue", number))
    assert f"goal {number} of 'go' never confirmed its end: orphaned" in [*step.notes, *ticked(made, 4.6).notes]


def test_a_goal_of_which_nothing_is_known_and_that_executes_has_five_seconds_to_end() -> None:
    made, _ = started(driving())
    assert cancels(made.send(Event("turn", 1.0, {}, "stray", 7))) == [7]
    ticked(made, 5.9)
    assert not made.loose_goals
    ticked(made, 6.0)
    assert [(goal.number, goal.action) for goal in made.loose_goals] == [(7, "turn")]


def test_a_start_over_an_orphan_is_made_where_the_state_states_it() -> None:
    states = driving(cancel_s=3)
    states["other"]["over_orphan"] = True
    made, number = started(states)
    reports(made, "accepted", number, at=1.0)
    sent(made, "e", at=2.0)
    assert starts(ticked(made, 5.0))


def test_a_timeout_is_reported_and_does_not_leave_the_action_running() -> None:
    made, number = started(driving(timeout_s=10))
    reports(made, "accepted", number, at=1.0)
    step = ticked(made, 10.0)
    assert cancels(step) == [number]
    assert (step.outcome, step.why) == ("failed", "drive: timed_out (10 s have passed)")


def test_a_goal_and_a_result_go_by_reference() -> None:
    board = {"speed": {"type": "number", "initial": 1.5}, "far": {"type": "number"}}
    states = driving(goal={"v": {"from": "speed"}}, result={"far": "distance"})
    made = Chart(mission(states, blackboard=board))
    start = starts(made.start(0.0))[0]
    assert start.goal == {"v": 1.5}
    assert reports(made, "succeeded", start.number, distance=7.0).writes == (("far", 7.0),)


def test_a_goal_with_an_unknown_part_is_not_sent() -> None:
    made = Chart(mission(driving(goal={"v": {"from": "far"}}), blackboard={"far": {"type": "number"}}))
    step = made.start(0.0)
    assert not starts(step)
    assert step.why == "drive: rejected (the goal's v is unknown)"


def test_a_composed_action_ends_by_the_profile_s_guard() -> None:
    from rai_missions.guards import Compare

    robot_facts = RobotFacts(succeeded={"go": Compare.read({"key": "there", "==": True})})
    made, number = started(driving(), robot_facts, blackboard=BOARD)
    made.write("there", True, at=0.5)
    assert reports(made, "accepted", number, at=1.0).entered == ("done",)


def test_kill_stops_every_goal_accepted_or_not() -> None:
    made, number = started(driving())
    step = made.send(Event("kill", 1.0, {"by": "button"}, "command"))
    assert cancels(step) == [number]
    assert (step.outcome, step.why, made.holder) == ("aborted", "e-stop by button", "nobody")


@pytest.mark.parametrize("end", ["canceled", "failed"])
def test_pause_cancels_the_goal_and_resume_starts_it_again_with_the_time_that_was_left(end: str) -> None:
    made, number = started(driving(timeout_s=10))
    reports(made, "accepted", number, at=1.0)
    assert cancels(made.send(Event("pause", 4.0, {}, "command"))) == [number]
    reports(made, end, number, at=5.0)
    assert ticked(made, 500.0).moves == ()
    step = made.send(Event("resume", 1000.0, {}, "command"))
    assert starts(step) and step.wake_at == 1006.0


def put_down(made: Chart, word: str, at: float) -> Step:
    """A pause, or the operator takes control: what runs is to end."""
    return made.send(Event("pause", at, {}, "command") if word == "pause" else control("operator", at))


def picked_up(made: Chart, word: str, at: float) -> Step:
    """The same is over."""
    return made.send(Event("resume", at, {}, "command") if word == "pause" else control("autonomy", at))


def control(holder: str, at: float) -> Event:
    return Event(holder, at, {"role": "operator", "by": "operator"}, "control")


STOPS = pytest.mark.parametrize("word", ["pause", "control"])


@STOPS
def test_a_goal_that_succeeds_while_its_cancel_is_under_way_is_not_done_once_more(word: str) -> None:
    made, number = started(driving(control="autonomy"))
    reports(made, "accepted", number, at=1.0)
    assert cancels(put_down(made, word, 4.0)) == [number]
    assert reports(made, "succeeded", number, at=5.0).moves == ()
    assert made.awaited_goals == 0 and not ticked(made, 500.0).moves
    step = picked_up(made, word, 1000.0)
    assert not starts(step) and step.entered == ("done",)


@STOPS
@pytest.mark.parametrize("end", ["canceled", "succeeded"])
def test_what_continues_before_its_goal_has_ended_waits_how_it_ends(word: str, end: str) -> None:
    made, number = started(driving(control="autonomy"))
    reports(made, "accepted", number, at=1.0)
    put_down(made, word, 2.0)
    assert not starts(picked_up(made, word, 3.0)), "the robot still does it"
    step = reports(made, end, number, at=4.0)
    assert (step.entered == ("done",), len(starts(step))) == (end == "succeeded", int(end == "canceled"))


@STOPS
def test_facts_that_a_result_waits_for_have_their_whole_time_after_a_pause(word: str) -> None:
    given = driving(control="autonomy", achieved={"key": "there", "==": True}, settle_s=10)
    made, number = started(given, blackboard=BOARD)
    reports(made, "accepted", number, at=1.0)
    reports(made, "succeeded", number, at=2.0)
    assert not cancels(put_down(made, word, 3.0)), "its server has ended it"
    step = picked_up(made, word, 1000.0)
    assert not starts(step) and step.wake_at == 1010.0
    assert made.write("there", True, at=1001.0).entered == ("done",)


@STOPS
def test_a_state_that_is_left_while_it_is_stopped_forgets_that_its_goal_succeeded(word: str) -> None:
    made, number = started(driving(control="autonomy", timeout_s=10))
    reports(made, "accepted", number, at=1.0)
    put_down(made, word, 2.0)
    reports(made, "succeeded", number, at=3.0)
    made.send(Event("cancel", 4.0, {}, "command"))
    assert made.outcome == "canceled" and made.awaited_goals == 0


def test_events_wait_while_the_mission_is_paused() -> None:
    made, _ = started(driving())
    made.send(Event("pause", 1.0, {}, "command"))
    assert sent(made, "e", at=2.0).moves == ()
    assert made.send(Event("resume", 3.0, {}, "command")).entered == ("other",)


def test_an_action_that_the_profile_keeps_continues_while_paused() -> None:
    made, number = started(driving(), RobotFacts(keep=frozenset({"go"})))
    assert cancels(made.send(Event("pause", 1.0, {}, "command"))) == []
    assert reports(made, "succeeded", number, at=2.0).moves == ()
    assert made.send(Event("resume", 3.0, {}, "command")).entered == ("done",)


def test_cancel_leads_through_on_cancel_and_ends_canceled_whatever_it_reaches() -> None:
    states = {**driving(), "park": {"transitions": [transition("parked", "end")]}, "end": {"final": "succeeded"}}
    made, number = started(states, on_cancel="park")
    reports(made, "accepted", number)
    step = made.send(Event("cancel", 1.0, {"by": "operator"}, "command"))
    assert step.entered == ("park",) and cancels(step) == [number] and step.outcome is None
    assert made.send(Event("cancel", 1.0, {}, "command")).ignored
    step = sent(made, "parked")
    assert (step.outcome, step.why) == ("canceled", "canceled by operator")


def test_what_runs_in_on_cancel_begins_with_the_cancel() -> None:
    made, _ = started({**driving(), "park": {"call": "brake"}}, on_cancel="park")
    step = made.send(Event("cancel", 1.0, {"by": "operator"}, "command"))
    assert [each.service for each in step.effects if isinstance(each, CallService)] == ["brake"]


def test_a_cancel_that_takes_too_long_ends_canceled_all_the_same() -> None:
    states = {**driving(), "park": {}}
    made, _ = started(states, on_cancel="park", cancel_s=5)
    made.send(Event("cancel", 1.0, {"by": "operator"}, "command"))
    assert ticked(made, 6.0).outcome == "canceled"


def test_an_activity_starts_when_control_is_where_its_state_wants_it() -> None:
    made = Chart(mission(driving(control="agent", handover_s=2)))
    step = made.start(0.0)
    assert [effect.to for effect in step.effects] == ["agent"]  # type: ignore[union-attr]
    assert starts(made.send(Event("agent", 1.0, {}, "control")))


def test_a_handover_that_takes_too_long_rejects_the_start() -> None:
    made = Chart(mission(driving(control="agent", handover_s=2)))
    made.start(0.0)
    assert ticked(made, 2.0).why == "drive: rejected (agent was not given control in time)"


def test_control_that_was_asked_for_in_vain_is_asked_back() -> None:
    states = driving(control="agent", handover_s=20)
    states["other"] |= {"control": "autonomy"}
    made = Chart(mission(states))
    made.start(0.0)
    left = made.send(Event("e", 1.0))
    assert starts(left) and [each.to for each in left.effects if isinstance(each, Handover)] == ["autonomy"]
    made.send(Event("agent", 1.5, {}, "control"))  # it was on its way
    assert made.waiting == {"other": "autonomy"}
    number = next(iter(made.awaited))
    reports(made, "canceled", number)
    assert starts(made.send(Event("autonomy", 2.0, {}, "control")))


def test_control_that_comes_too_late_is_asked_back() -> None:
    states = driving(control="agent", handover_s=2)
    states["drive"]["transitions"].append(transition("rejected", "other"))
    made = Chart(mission(states))
    made.start(0.0)
    assert [each.to for each in ticked(made, 2.0).effects if isinstance(each, Handover)] == ["autonomy"]


def test_control_that_another_state_still_waits_for_is_not_asked_back() -> None:
    states = driving(control="agent", handover_s=20)
    states["other"] |= {"control": "agent"}
    made = Chart(mission(states))
    made.start(0.0)
    assert [each.to for each in made.send(Event("e", 1.0)).effects if isinstance(each, Handover)] == ["agent"]


def test_a_round_in_which_another_has_control_asks_for_no_one_elses() -> None:
    states = {
        "tour": {
            "each": "stops", "as": "stop", "control": "agent", "initial": "inside",
            "states": {"inside": {"action": "go", "timeout_s": 60, "control": "autonomy"}},
        },
        "done": {"final": "succeeded"},
    }  # fmt: skip
    keys = {"stops": {"type": "list", "source": "argument", "initial": ["a"]}, "stop": {"type": "string"}}
    step = Chart(mission(states, blackboard=keys)).start(0.0)
    assert starts(step) and not [each for each in step.effects if isinstance(each, Handover)]


def test_control_taken_away_ends_the_goal_and_control_given_back_starts_it_again() -> None:
    made = Chart(mission(driving(control="autonomy")))
    number = starts(made.start(0.0))[0].number
    reports(made, "accepted", number)
    taken = made.send(Event("operator", 1.0, {}, "control"))
    assert cancels(taken) == [number]
    assert "drive waits until control is given back" in taken.notes
    assert made.waiting == {"drive": "autonomy"}
    reports(made, "canceled", number)
    assert starts(made.send(Event("autonomy", 9.0, {}, "control")))
    assert made.waiting == {}


def test_control_that_comes_in_a_pause_starts_what_waits_for_it_at_the_end_of_the_pause() -> None:
    made = Chart(mission(driving(control="agent", handover_s=20)))
    made.start(0.0)
    made.send(Event("pause", 1.0, {"by": "operator"}, "command"))
    assert not starts(made.send(Event("agent", 1.5, {}, "control")))
    assert starts(made.send(Event("resume", 2.0, {"by": "operator"}, "command")))


def test_a_held_state_that_is_left_waits_for_no_control() -> None:
    work = {"initial": "drive", "states": driving(control="autonomy"), "transitions": [transition("away", "rest")]}
    made = Chart(mission({"work": work, "rest": {}}, initial="work"))
    made.start(0.0)
    made.send(Event("operator", 1.0, {"by": "operator", "role": "operator"}, "control"))
    assert made.waiting == {"drive": "autonomy"}
    assert made.send(Event("away", 2.0)).entered == ("rest",)
    assert made.waiting == {}


def test_a_state_that_is_held_again_within_a_pause_waits_once() -> None:
    made = Chart(mission({"rest": {"control": "autonomy", "transitions": [transition("go", "done")]}, "done": {}}))
    made.start(0.0)
    by: dict[str, Any] = {"by": "operator", "role": "operator"}
    made.send(Event("operator", 1.0, by, "control"))
    made.send(Event("pause", 2.0, by, "command"))
    made.send(Event("autonomy", 3.0, by, "control"))
    taken = made.send(Event("operator", 4.0, by, "control"))
    assert taken.notes == ("control: operator",), "it waits for the end of the pause already"
    made.send(Event("resume", 5.0, by, "command"))
    assert made.waiting == {"rest": "autonomy"} and made.snapshot()["_laid_by"] == ("rest",)


def test_control_taken_and_given_back_in_a_pause_starts_the_goal_once_at_its_end() -> None:
    made = Chart(mission(driving(control="autonomy")))
    number = starts(made.start(0.0))[0].number
    reports(made, "accepted", number)
    made.send(Event("pause", 1.0, {"by": "operator"}, "command"))
    reports(made, "canceled", number)
    taken = made.send(Event("operator", 2.0, {"by": "operator", "role": "operator"}, "control"))
    assert not [note for note in taken.notes if "waits until control" in note]
    made.send(Event("autonomy", 3.0, {"by": "operator", "role": "operator"}, "control"))
    assert len(starts(made.send(Event("resume", 4.0, {"by": "operator"}, "command")))) == 1
