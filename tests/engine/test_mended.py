# SPDX-License-Identifier: Apache-2.0
"""What strangers have found: types, kills and predicates."""

from __future__ import annotations

import pytest

from rai_missions.engine import Chart
from rai_missions.errors import UsageError
from rai_missions.event import Event
from tests.rigs.charts import chart, mission, sent, transition

EACH = {
    "each": "stops",
    "as": "stop",
    "initial": "x",
    "states": {"x": {}},
    "transitions": [transition("failed", "no")],
}


def test_a_result_of_another_type_is_not_written() -> None:
    states = {
        "a": {"action": "go", "timeout_s": 9, "result": {"n": "x"}, "transitions": [transition("succeeded", "b")]},
        "b": {},
    }
    made = Chart(mission(states, blackboard={"n": {"type": "integer", "initial": 0}}))
    made.start(0.0)
    step = made.send(Event("succeeded", 1.0, {"x": "seven"}, "result", 1))
    assert step.entered == ("b",) and step.writes == ()
    assert "'n' was not written: 'seven' is not of type 'integer'" in step.notes
    assert made.view.board["n"].value == 0


def test_a_kill_is_a_kill_while_the_mission_is_being_canceled_too() -> None:
    made = Chart(mission({"a": {}, "park": {"exit": [{"log": "parked"}]}}, on_cancel="park"))
    made.start(0.0)
    made.send(Event("cancel", 1.0, {"by": "operator"}, "command"))
    step = made.send(Event("kill", 2.0, {"by": "button"}, "command"))
    assert (step.outcome, step.why, step.effects) == ("aborted", "e-stop by button", ())


def test_a_cancel_that_ends_in_an_aborted_final_is_a_cancel() -> None:
    states = {"a": {}, "park": {"transitions": [transition("e", "end")]}, "end": {"final": "aborted"}}
    made = Chart(mission(states, on_cancel="park"))
    made.start(0.0)
    made.send(Event("cancel", 1.0, {"by": "operator"}, "command"))
    assert sent(made, "e").outcome == "canceled"


def test_a_mission_that_names_a_predicate_is_not_begun_without_it() -> None:
    named = mission({"a": {"transitions": [transition("e", "b", when={"named": "is_far"})]}, "b": {}})
    with pytest.raises(UsageError, match="predicates that were not given: is_far"):
        Chart(named)
    Chart(named, named={"is_far": lambda board: True})


def test_a_list_that_is_stale_is_unknown_to_each() -> None:
    keys = {"stops": {"type": "list", "source": "robot", "max_age_s": 5}, "stop": {"type": "string"}}
    states = {"wait": {"transitions": [transition("e", "tour")]}, "tour": EACH, "no": {}}
    for at, entered in ((4.0, ("tour", "x")), (5.0, ("tour", "no"))):
        made = Chart(mission(states, blackboard=keys))
        made.write("stops", ["a", "b"], at=0.0)
        made.start(0.0)
        assert sent(made, "e", at=at).entered == entered


def test_a_round_that_a_transition_leaves_is_not_begun_again() -> None:
    inside = {"x": {"transitions": [{"when": {"not": {"fresh": "clear"}}, "to": "end"}]}, "end": {"final": "succeeded"}}
    way_out = {"when": {"in": "end"}, "to": "away"}
    each = {"each": "stops", "as": "stop", "initial": "x", "states": inside, "transitions": [way_out]}
    keys = {
        "stops": {"type": "list", "initial": ["a", "b"]}, "stop": {"type": "string"},
        "clear": {"type": "boolean", "source": "robot", "max_age_s": 5, "optional": True},
    }  # fmt: skip
    made = Chart(mission({"tour": each, "away": {}}, blackboard=keys, initial="tour"))
    made.start(0.0)
    assert made.active == {"away"}


def test_an_item_that_does_not_fit_ends_its_each_whatever_was_raised_before() -> None:
    made = Chart(
        mission(
            {"day": {"entry": [{"raise": "began"}], "initial": "tour", "states": {"tour": EACH}}, "no": {}},
            blackboard={"stops": {"type": "list", "initial": [1]}, "stop": {"type": "string"}},
            events=["began"],
        )
    )
    assert made.start(0.0).entered == ("day", "tour", "no")


def test_a_region_ends_as_the_final_that_it_reached_whatever_other_finals_it_has() -> None:
    finals = {"bad": {"final": "failed"}, "good": {"final": "succeeded"}}
    inner = {"initial": "on", "states": {"on": {"transitions": [transition("go", "good")]}, **finals}}
    other = {"initial": "well", "states": {"well": {"final": "succeeded"}}}
    both = {"parallel": {"one": inner, "two": other}, "transitions": [transition("succeeded", "c")]}
    made = chart({"both": both, "c": {}}, events=["go"])
    assert sent(made, "go").entered == ("good", "c")


def test_a_success_that_rests_on_a_stale_fact_names_its_age() -> None:
    there = {"key": "there", "==": True}
    keys = {"there": {"type": "boolean", "source": "robot", "max_age_s": 2, "optional": True}}
    made = chart(
        {"a": {"transitions": [transition("go", "end")]}, "end": {"final": "succeeded", "requires": there}},
        blackboard=keys,
    )
    made.write("there", True, at=1.0)
    step = sent(made, "go", at=7.0)
    assert step.outcome == "failed"
    assert step.why.endswith("is unknown (there is 6.0 s old)")
