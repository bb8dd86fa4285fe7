# SPDX-License-Identifier: Apache-2.0
"""The operator takes control: what needs it waits, and nothing fails for it."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.engine import Chart
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.step import Ask, CancelGoal, Handover, StartGoal, Step, Withdraw
from rai_missions.event import Event, Tick
from tests.rigs.charts import mission, transition

Json = dict[str, Any]
ASKED = {
    "question": "?",
    "options": {"no": {"about": "n"}},
    "ask": ["operator"],
    "deadline_s": 20,
    "fallback": "no",
}
OVER: Json = {"final": "aborted"}
ACT: Json = {"action": "go", "timeout_s": 60}


def taken(made: Chart, at: float) -> Step:
    return made.send(Event("operator", at, {"by": "operator", "role": "operator"}, "control"))


def given(made: Chart, to: str, at: float) -> Step:
    return made.send(Event(to, at, {"by": "operator", "role": "operator"}, "control"))


def of(step: Step, kind: type) -> list[Any]:
    return [effect for effect in step.effects if isinstance(effect, kind)]


def begun(states: Json, **words: Any) -> Chart:
    made = Chart(mission(states, **words))
    made.start(0.0)
    return made


@pytest.mark.parametrize("holder", ["operator", "nobody"])
def test_a_start_waits_without_a_deadline_and_is_asked_for_again_at_the_hand_back(holder: str) -> None:
    made = begun({"a": {"transitions": [transition("e", "b")]}, "b": {**ACT, "control": "agent", "handover_s": 5}})
    made.send(Event(holder, 1.0, {"by": "operator", "role": "operator"}, "control"))
    assert (made.held_by, made.held_since, made.held) == (holder, 1.0, frozenset())
    step = made.send(Event("e", 2.0))
    assert step.entered == ("b",) and not of(step, Handover) and step.wake_at is None
    assert made.held == {"b"} and made.waiting == {"b": "agent"}
    assert made.send(Tick(10_000.0)).ignored
    back = given(made, "autonomy", 10_001.0)
    assert of(back, Handover) == [Handover("agent")] and back.wake_at == 10_006.0
    assert (made.held_by, made.held_since) == ("", None)
    assert of(made.send(Event("agent", 10_002.0, {"by": "mission"}, "control")), StartGoal)


def test_control_that_is_taken_in_the_step_that_asks_for_it_is_not_asked_for() -> None:
    """A process that was held up learns of both at once; its request would come after the operator's, and undo it."""
    made = begun({"a": {"transitions": [transition(after_s=1, to="b")]}, "b": {**ACT, "control": "agent"}})
    step = taken(made, 2.0)
    assert step.entered == ("b",) and made.held == {"b"} and not of(step, Handover)
    assert of(given(made, "autonomy", 3.0), Handover) == [Handover("agent")]


def test_a_run_that_has_ended_holds_nothing() -> None:
    made = begun({"b": {**ACT, "control": "autonomy"}})
    taken(made, 1.0)
    assert made.held == {"b"}
    commanded(made, "cancel", 2.0)
    assert (made.outcome, made.held) == ("canceled", frozenset())


def test_a_start_whose_handover_is_under_way_waits_too() -> None:
    made = begun({"b": {**ACT, "control": "agent", "handover_s": 5}})
    taken(made, 4.0)
    assert made.wake_at is None and made.send(Tick(100.0)).ignored
    assert of(given(made, "agent", 101.0), StartGoal)


def test_what_runs_is_canceled_and_starts_again_with_the_time_that_it_had_left() -> None:
    made = begun({"a": {**ACT, "control": "autonomy", "transitions": [transition("timed_out", "over")]}, "over": OVER})
    made.send(Event("go", 0.0, {}, "accepted", 1))
    step = taken(made, 20.0)
    assert of(step, CancelGoal)
    made.send(Event("canceled", 20.5, {}, "result", 1))
    assert made.send(Tick(500.0)).ignored and made.outcome is None
    back = given(made, "autonomy", 1000.0)
    assert of(back, StartGoal) and back.wake_at == 1040.0
    assert made.send(Tick(1040.0)).outcome == "aborted"


def test_a_goal_that_the_profile_keeps_continues_and_its_result_waits() -> None:
    states = {"a": {**ACT, "control": "autonomy", "transitions": [transition("succeeded", "over")]}, "over": OVER}
    made = Chart(mission(states), robot_facts=RobotFacts(keep=frozenset({"go"})))
    made.start(0.0)
    made.send(Event("go", 0.0, {}, "accepted", 1))
    assert not of(taken(made, 1.0), CancelGoal)
    assert made.send(Event("succeeded", 2.0, {}, "result", 1)).moves == ()
    assert given(made, "autonomy", 100.0).outcome == "aborted"


def test_the_end_of_a_kept_goal_that_waited_is_known_once_its_state_is_left() -> None:
    states = {"a": {**ACT, "control": "autonomy"}, "park": {"action": "park", "timeout_s": 60}}
    made = Chart(mission(states, on_cancel="park"), robot_facts=RobotFacts(keep=frozenset({"go"})))
    made.start(0.0)
    made.send(Event("go", 0.0, {}, "accepted", 1))
    taken(made, 1.0)
    made.send(Event("succeeded", 2.0, {}, "result", 1))
    step = made.send(Event("cancel", 3.0, {"by": "operator"}, "command"))
    assert not of(step, CancelGoal) and [each.action for each in of(step, StartGoal)] == ["park"]


def test_transitions_of_held_states_wait_and_those_of_free_states_continue() -> None:
    states = {
        "both": {
            "parallel": {
                "left": {"initial": "l1", "control": "agent", "states": {
                    "l1": {"transitions": [transition(["e", "f"], "l2"), {"after_s": 5, "to": "l2"}]}, "l2": {}}},
                "right": {"initial": "r1", "states": {
                    "r1": {"transitions": [transition("f", "r2"), {"after_s": 7, "to": "r2"}]}, "r2": {}}},
            },
        },
    }  # fmt: skip
    made = begun(states)
    given(made, "agent", 0.0)
    taken(made, 1.0)
    assert made.held == {"left", "l1"}
    assert made.send(Event("e", 2.0)).moves == ()
    assert made.send(Tick(6.5)).moves == ()
    assert made.send(Tick(7.0)).entered == ("r2",)
    assert given(made, "agent", 50.0).entered == ("l2",)


def test_an_event_that_a_free_state_takes_is_consumed() -> None:
    states = {
        "a": {"control": "agent", "transitions": [transition(["e", "f"], "b")]}, "b": {"transitions": []},
    }  # fmt: skip
    made = begun(states, transitions=[{"on": "e", "do": [{"log": "noted"}]}])
    taken(made, 1.0)
    assert made.send(Event("e", 2.0)).effects
    assert given(made, "agent", 3.0).moves == ()
    taken(made, 4.0)
    made.send(Event("f", 5.0))
    assert given(made, "agent", 6.0).entered == ("b",)


def test_events_are_handled_in_the_order_in_which_they_came() -> None:
    states = {
        "a": {"control": "agent", "transitions": [transition("e", "b"), transition("f", "c")]},
        "b": {"control": "agent", "transitions": [transition("f", "d")]}, "c": {}, "d": {},
    }  # fmt: skip
    made = begun(states)
    taken(made, 1.0)
    made.send(Event("e", 2.0))
    made.send(Event("f", 2.0))
    assert given(made, "agent", 6.0).entered == ("b", "d")


def test_an_open_question_stays_open_and_a_proposal_is_judged_at_the_hand_back() -> None:
    yes = {"about": "y", "when": {"key": "k", "==": True}}
    asked = {"question": "?", "options": {"yes": yes, "no": {"about": "n"}},
             "ask": ["operator"], "deadline_s": 20, "fallback": "no", "attempts": 2}  # fmt: skip
    keys = {"k": {"type": "boolean", "source": "robot"}}
    leads = [transition("yes", "b"), transition("no", "c")]
    states = {"q": {"control": "agent", "decision": asked, "transitions": leads}, "b": {}, "c": {}}
    made = Chart(mission(states, blackboard=keys))
    made.write("k", True)
    given(made, "agent", 0.0)
    (question,) = of(made.start(0.0), Ask)
    step = taken(made, 5.0)
    assert not of(step, Withdraw) and step.wake_at is None
    number = question.question.number
    assert made.send(Event("operator", 1000.0, {"option": "yes"}, "proposal", number)).moves == ()
    assert [each.number for each in made.questions] == [number]
    made.write("k", False, at=1001.0)
    back = given(made, "agent", 1002.0)
    assert back.moves == () and of(back, Ask), "it is judged on what is known then"
    assert made.send(Event("operator", 1003.0, {"option": "no"}, "proposal", number + 1)).entered == ("c",)


def test_a_question_continues_where_control_comes_back_elsewhere_and_is_asked_for() -> None:
    made = Chart(
        mission({"q": {"control": "agent", "decision": ASKED, "transitions": [transition("no", "c")]}, "c": {}})
    )
    given(made, "agent", 0.0)
    (question,) = of(made.start(0.0), Ask)
    taken(made, 5.0)
    made.send(Event("operator", 10.0, {"option": "no"}, "proposal", question.question.number))
    assert given(made, "autonomy", 30.0).entered == ("c",)


@pytest.mark.parametrize("guard", [{"elapsed_s": 10}, {"held": {"key": "k", "==": True}, "for_s": 10}])
def test_ages_in_held_states_are_still(guard: Json) -> None:
    keys = {"k": {"type": "boolean", "source": "robot"}}
    made = Chart(
        mission({"a": {"control": "agent", "transitions": [{"when": guard, "to": "b"}]}, "b": {}}, blackboard=keys)
    )
    made.write("k", True)
    given(made, "agent", 0.0)
    made.start(0.0)
    taken(made, 4.0)
    assert made.send(Tick(100.0)).moves == ()
    assert given(made, "agent", 100.0).wake_at == 106.0
    assert made.send(Tick(105.9)).moves == () and made.send(Tick(106.0)).entered == ("b",)


def test_what_held_before_the_operator_took_control_is_not_looked_at_until_the_hand_back() -> None:
    guard = {"held": {"key": "k", "==": True}, "for_s": 10}
    states = {"a": {"control": "agent", "transitions": [{"when": guard, "to": "b"}]}, "b": {}}
    made = agents(states, blackboard={"k": {"type": "boolean", "source": "robot"}})
    made.write("k", True)
    made.start(0.0)
    taken(made, 4.0)
    made.write("k", False, at=5.0)
    made.write("k", True, at=6.0)
    assert given(made, "agent", 100.0).wake_at == 106.0


def test_a_delayed_raise_of_a_held_state_has_the_time_that_it_had_left() -> None:
    states = {
        "a": {"control": "agent", "entry": [{"raise": "e", "after_s": 10}],
              "transitions": [transition("e", "b"), {"after_s": 12, "to": "c"}]}, "b": {}, "c": {},
    }  # fmt: skip
    made = begun(states)
    taken(made, 4.0)
    assert given(made, "agent", 100.0).wake_at == 106.0
    assert made.send(Tick(200.0)).entered == ("b",)


def test_a_state_that_is_entered_while_it_is_held_counts_its_time_from_the_hand_back() -> None:
    timed = {"control": "agent", "transitions": [{"after_s": 5, "to": "c"}]}
    made = begun({"a": {"transitions": [transition("e", "b")]}, "b": timed, "c": {}})
    taken(made, 1.0)
    made.send(Event("e", 50.0))
    assert given(made, "agent", 100.0).wake_at == 105.0


def test_achieved_is_not_looked_at() -> None:
    keys = {"k": {"type": "boolean", "source": "robot"}}
    act = {**ACT, "control": "agent", "achieved": {"key": "k", "==": True}, "settle_s": 5,
           "transitions": [transition("succeeded", "b"), transition("unverified", "c")]}  # fmt: skip
    made = Chart(mission({"a": act, "b": {}, "c": {}}, blackboard=keys), robot_facts=RobotFacts(keep=frozenset({"go"})))
    made.write("k", False)
    given(made, "agent", 0.0)
    made.start(0.0)
    made.send(Event("go", 0.0, {}, "accepted", 1))
    made.send(Event("succeeded", 1.0, {}, "result", 1))
    taken(made, 2.0)
    assert made.write("k", True, at=100.0).moves == ()
    assert given(made, "agent", 101.0).entered == ("b",)


def test_cancel_acts_at_once_and_a_held_on_cancel_ends_with_cancel_s() -> None:
    states = {"a": {**ACT, "control": "agent"}, "home": {**ACT, "control": "autonomy"}, "done": OVER}
    made = begun(states, on_cancel="home", cancel_s=30)
    taken(made, 1.0)
    step = made.send(Event("cancel", 2.0, {"by": "operator"}, "command"))
    assert step.entered == ("home",) and not of(step, StartGoal) and step.wake_at == 32.0
    assert made.send(Tick(32.0)).outcome == "canceled"
    made = begun(states)
    taken(made, 1.0)
    assert made.send(Event("kill", 2.0, {}, "command")).outcome == "aborted"


def test_control_that_the_mission_gave_to_the_operator_is_no_hold() -> None:
    states = {"a": {"control": "operator", "transitions": [transition("e", "b")]}, "b": {**ACT, "control": "agent"}}
    for data in ({"by": "mission"}, {"by": "robot"}, {}):
        made = begun(states)
        made.send(Event("operator", 1.0, data, "control"))
        assert made.held_by == ""
        step = made.send(Event("e", 2.0))
        assert of(step, Handover) == [Handover("agent")] and step.wake_at == 7.0
    taken(made, 3.0)
    assert made.held_by == "operator" and made.held == {"b"} and made.wake_at is None


def test_a_state_of_the_operator_runs_while_the_operator_holds_control_and_waits_while_no_one_does() -> None:
    states = {"a": {"control": "operator", "transitions": [transition("e", "b"), {"after_s": 10, "to": "b"}]}, "b": {}}
    made = begun(states)
    given(made, "nobody", 2.0)
    assert made.held == {"a"} and made.send(Event("e", 3.0)).moves == ()
    assert taken(made, 50.0).entered == ("b",)


def test_a_hold_that_begins_or_ends_in_a_pause_counts_no_time_twice() -> None:
    def left(*moments: tuple[float, Event]) -> float | None:
        made = begun({"a": {"control": "autonomy", "transitions": [{"after_s": 100, "to": "b"}]}, "b": {}})
        for at, event in moments:
            step = made.send(event._replace(at=at))
        return step.wake_at

    pause, resume = (Event(name, 0.0, {}, "command") for name in ("pause", "resume"))
    take, back = (
        Event("operator", 0.0, {"by": "operator", "role": "operator"}, "control"),
        Event("autonomy", 0.0, {}, "control"),
    )
    assert left((10.0, pause), (20.0, take), (30.0, back), (40.0, resume)) == 130.0
    assert left((10.0, take), (20.0, pause), (30.0, back), (40.0, resume)) == 130.0
    assert left((10.0, pause), (20.0, take), (30.0, resume), (40.0, back)) == 130.0
    assert left((10.0, take), (20.0, pause), (30.0, resume), (40.0, back)) == 130.0


def test_invariants_continue() -> None:
    keys = {"k": {"type": "boolean", "source": "robot"}}
    made = begun({"a": {"control": "agent"}}, blackboard=keys, invariants={"never": {"key": "k", "!=": True}})
    taken(made, 1.0)
    assert made.write("k", True, at=2.0).outcome == "aborted"


# -- given back in a pause ------------------------------------------------------------------------------------------


def commanded(made: Chart, name: str, at: float) -> Step:
    return made.send(Event(name, at, kind="command"))


def given_back_in_a_pause(made: Chart) -> Step:
    commanded(made, "pause", 3.0)
    given(made, "agent", 4.0)
    return commanded(made, "resume", 5.0)


def agents(states: Json, **words: Any) -> Chart:
    made = Chart(mission(states, **words))
    made.send(Event("agent", 0.0, {"by": "robot"}, "control"))
    return made


def test_an_outcome_that_waited_is_handled_though_control_came_back_in_a_pause() -> None:
    waiting = {"a": {"transitions": [transition("succeeded", "b", of="x")]}, "b": {}}
    made = agents({"p": {"parallel": {"r1": {"initial": "a", "control": "agent", "states": waiting},
                                      "r2": {"initial": "x", "states": {"x": {"call": "horn"}}}}}})  # fmt: skip
    number = made.start(0.0).effects[0].number  # type: ignore[attr-defined]
    taken(made, 1.0)
    made.send(Event("succeeded", 2.0, {}, "result", number))
    assert given_back_in_a_pause(made).entered == ("b",)


def test_a_question_for_which_control_came_back_elsewhere_in_a_pause_asks_for_it() -> None:
    made = agents({"q": {"control": "agent", "decision": ASKED, "transitions": [transition("no", "c")]}, "c": {}})
    made.start(0.0)
    taken(made, 1.0)
    commanded(made, "pause", 2.0)
    given(made, "autonomy", 3.0)
    assert of(commanded(made, "resume", 4.0), Handover) == [Handover("agent")]


@pytest.mark.parametrize("name", ["call_failed", "uncertain"])
def test_an_event_of_the_engine_that_waited_is_handled_though_control_came_back_in_a_pause(name: str) -> None:
    here = {"control": "agent", "entry": [{"call": "horn"}], "transitions": [transition(name, "b")]}
    made = agents({"a": here, "b": {}}, events=[])
    number = made.start(0.0).effects[0].number  # type: ignore[attr-defined]
    taken(made, 1.0)
    received = Event("failed", 2.0, {}, "result", number) if name == "call_failed" else Event(name, 2.0, {}, "doubt")
    made.send(received)
    step = given_back_in_a_pause(made)
    assert step.entered == ("b",) and not step.why


def test_a_call_that_fails_in_a_pause_is_reported_at_its_end() -> None:
    made = Chart(
        mission({"a": {"entry": [{"call": "horn"}], "transitions": [transition("call_failed", "b")]}, "b": {}})
    )
    number = made.start(0.0).effects[0].number  # type: ignore[attr-defined]
    commanded(made, "pause", 1.0)
    assert not made.send(Event("failed", 2.0, {}, "result", number)).moves
    assert commanded(made, "resume", 3.0).entered == ("b",)


def test_a_goal_that_is_orphaned_in_a_pause_is_reported_at_its_end() -> None:
    states = {"a": {**ACT, "cancel_s": 5, "transitions": [transition("e", "b")]},
              "b": {"transitions": [transition("orphaned", "c")]}, "c": {}}  # fmt: skip
    made = Chart(mission(states))
    goal = made.start(0.0).effects[0]
    made.send(Event("go", 0.5, {}, "accepted", goal.number))  # type: ignore[attr-defined]
    made.send(Event("e", 1.0))
    commanded(made, "pause", 2.0)
    assert "orphaned" in made.send(Tick(7.0)).notes[0]
    assert commanded(made, "resume", 8.0).entered == ("c",)


def test_an_event_that_no_one_declares_is_refused_in_a_pause_as_it_comes() -> None:
    made = Chart(mission({"a": {}}))
    made.start(0.0)
    commanded(made, "pause", 1.0)
    assert "declares no event" in made.send(Event("unheard_of", 2.0)).why
    assert not commanded(made, "resume", 3.0).why
