# SPDX-License-Identifier: Apache-2.0
"""What generated charts brought to light, each at its smallest."""

from __future__ import annotations

import pytest

from rai_missions.engine.step import CancelGoal
from rai_missions.event import Event, Tick
from tests.oracles.ours import logged, of_appendix_d
from tests.rigs.charts import chart, sent, transition

COUNTER = {"n": {"type": "integer", "initial": 0}}
ALWAYS = {"key": "n", "==": 0}


def test_passing_a_state_twice_is_no_circle_while_other_events_wait() -> None:
    states = {
        "a": {"transitions": [transition(to="b", when=ALWAYS)]},
        "b": {
            "transitions": [
                transition("x", "a", do=[{"raise": "z"}]),
                transition("y", "a", do=[{"raise": "z"}]),
                transition("z", "c"),
            ]
        },
        "c": {"transitions": [transition("y", "d")]},
        "d": {},
        "start": {"transitions": [transition("go", "a", do=[{"raise": "x"}, {"raise": "y"}])]},
    }
    made = chart(states, "start", blackboard=COUNTER)
    sent(made, "go")
    document = {
        "states": states,
        "initial": "start",
        "events": dict.fromkeys("xyz") | {"go": {}},
        "blackboard": COUNTER,
    }
    assert (made.active, made.outcome) == (of_appendix_d(document, [("event", "go", 0.0)])[-1].active, None)


def test_a_history_remembers_what_the_same_microstep_leaves() -> None:
    inside = {"b": {"transitions": [transition("e", "c")]}, "c": {}, "back": {"history": "deep"}}
    made = chart({"a": {"initial": "b", "states": inside, "transitions": [transition("again", "back")]}})
    sent(made, "e", "again")
    assert made.active == {"a", "c"}


def test_a_state_that_was_left_meanwhile_does_not_fail_the_mission() -> None:
    ends = {"end": {"final": "failed", "entry": [{"set": "n", "value": 1}]}}
    left = {"initial": "end", "states": ends, "transitions": [transition(to="b", when={"key": "n", "==": 1})]}
    made = chart({"a": left, "b": {}}, blackboard=COUNTER)
    assert (made.active, made.outcome) == ({"b"}, None)


def test_held_counts_from_the_last_entry_however_often_the_way_was_taken() -> None:
    states = {
        "a": {"transitions": [transition("go", "c"), transition(to="b", when={"held": ALWAYS, "for_s": 2})]},
        "b": {}, "c": {"transitions": [transition("back", "a")]},
    }  # fmt: skip
    made = chart(states, blackboard=COUNTER)
    for name, at in (("go", 0.1), ("back", 0.2), ("go", 1.0), ("back", 1.9)):
        made.send(Event(name, at))
    assert made.wake_at == pytest.approx(3.9)
    made.send(Tick(3.0))
    assert made.active == {"a"}


def test_an_option_may_be_called_round() -> None:
    options = {"round": {"about": "go round"}, "stay": {"about": "stay"}}
    asked = {"question": "Which way?", "options": options, "ask": ["rules"], "fallback": "round", "deadline_s": 5}
    states = {"a": {"decision": asked, "transitions": [transition("round", "b"), transition("stay", "a")]}, "b": {}}
    made = chart(states)
    made.send(Tick(6.0))
    assert made.active == {"b"}


def test_an_invariant_that_is_broken_on_the_way_into_the_final_is_not_overlooked() -> None:
    states = {
        "a": {"transitions": [transition("e", "end", do=[{"set": "n", "value": 1}])]},
        "end": {"final": "succeeded"},
    }
    made = chart(states, blackboard=COUNTER, invariants={"nothing_happens": ALWAYS})
    assert sent(made, "e").outcome == "aborted"


def test_a_goal_that_was_given_up_and_is_accepted_at_last_is_canceled() -> None:
    made = chart({"a": {"action": "drive", "timeout_s": 99, "transitions": [transition("stop", "b")]}, "b": {}})
    made.send(Event("stop", 1.0))
    assert any("orphaned" in note for note in made.send(Tick(20.0)).notes)
    assert CancelGoal(1, "drive") in made.send(Event("drive", 21.0, {}, "accepted", 1)).effects


def test_what_a_state_does_when_it_is_left_is_done_at_a_failing_end_too() -> None:
    states = {
        "a": {
            "initial": "b", "exit": [{"log": "lamp off"}],
            "states": {"b": {"transitions": [transition("e", "end")]}, "end": {"final": "failed"}},
        }
    }  # fmt: skip
    made = chart(states)
    step = sent(made, "e")
    assert (step.outcome, logged(step)) == ("failed", ("lamp off",))
