# SPDX-License-Identifier: Apache-2.0
"""Lists of any length: rounds that end in the step in which they began are gone as often as they bring anything new."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.engine.compiled.states import CompiledState
from rai_missions.engine.semantics import macrostep
from rai_missions.engine.state import RunState
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove
from rai_missions.prove.abstraction import step_chains, step_circles
from rai_missions.prove.abstraction.nondeterminism import Choices
from rai_missions.prove.abstraction.step_circles import StepCircles
from rai_missions.prove.environment.environment import Environment
from tests.prove.explored import RecordingSpace
from tests.prove.test_laws import lenient

Json = dict[str, Any]
ENDS = ["succeeded", "failed", "timed_out", "rejected"]
MOST, WORK = 3_000, 1_000


def patrol(end: list[Json], do: list[Json] = [], **achieved: Any) -> Json:  # noqa: B006 - left as it is
    """Each place is driven to; what is rejected, because an earlier goal never ended, is passed over at once."""
    return {
        "format": 1, "name": "patrol", "initial": "going",
        "blackboard": {
            "places": {"type": "list", "source": "argument"}, "place": {"type": "string"},
            "at": {"type": "string", "source": "robot"}, "n": {"type": "integer", "initial": 0},
        },
        "states": {
            "going": {
                "each": "places", "as": "place", "initial": "driving", "entry": [{"set": "n", "value": 0}],
                "states": {
                    "driving": {"action": "drive", "timeout_s": 60, **achieved,
                                "transitions": [{"on": [*ENDS, *(["unverified"] if achieved else [])], "to": "next"}]},
                    "next": {"final": "succeeded", "entry": do},
                },
                "transitions": [*end, {"on": "failed", "to": "lost"}],
            },
            "over": {"final": "aborted"}, "lost": {"final": "aborted"},
        },
    }  # fmt: skip


THERE: Json = {"achieved": {"key": "at", "==": {"key": "place"}}, "settle_s": 1}
COUNT: Json = {"set": "n", "add": 1}
OVER: Json = {"on": "succeeded", "to": "over"}


@pytest.mark.parametrize("achieved", [{}, THERE], ids=["by report", "by fact"])
def test_a_patrol_that_passes_over_what_is_rejected_is_explored_whole(achieved: Json) -> None:
    proof = prove(Mission.model_validate(patrol([OVER], [COUNT], **achieved)), most=MOST, work=WORK * MOST)
    assert {each.verdict for each in proof.claims} == {"proved"}


@pytest.mark.drill
@pytest.mark.parametrize("items", [3])
def test_a_circle_that_needs_a_long_list_each_time_is_not_taken_for_one_that_ends(
    items: int, monkeypatch: pytest.MonkeyPatch
) -> None:
    for each in (macrostep, step_chains, step_circles):
        monkeypatch.setattr(each, "MOST_MICROSTEPS", 100)
    again: Json = {"on": "succeeded", "when": {"key": "n", ">=": items}, "to": "going"}
    proof = prove(Mission.model_validate(patrol([again, OVER], [COUNT])), most=MOST, work=40_000)
    assert {each.verdict for each in proof.claims if each.name == "comes to rest"} != {"proved"}


def with_lists_of(most: int, document: Json) -> RecordingSpace:
    """What is explored where every list of up to so many items is tried; 0: of any length."""

    def is_short(circles: StepCircles, state: RunState, node: CompiledState) -> bool:
        return len(state.rounds[node.name][0]) < most

    with pytest.MonkeyPatch.context() as patch:
        if most:
            patch.setattr(StepCircles, "is_new_round", is_short)
        space = RecordingSpace(Environment(Mission.model_validate(document)), MOST, WORK, by_parts=False)
        space.explore()
    return space


@st.composite
def patrols(draw: st.DrawFn) -> Json:
    """What a round does, and where it leads after so many."""
    effects = st.sampled_from([COUNT, {"set": "n", "add": 2}, {"set": "n", "value": 1}, {"call": "horn"}])
    limit = draw(st.integers(1, 3))
    other: Json = {"on": "succeeded", "when": {"key": "n", draw(st.sampled_from(["==", ">=", "<"])): limit}}
    end = [{**other, "to": draw(st.sampled_from(["lost", "over"]))}, OVER]
    return patrol(end, draw(st.lists(effects, max_size=2)), **draw(st.sampled_from([{}, {}, THERE])))


def hold_against_long_lists(document: Json, items: int) -> None:
    """What lists of so many items lead to in one step, those of any length lead to, and to nothing else."""
    found, expected = with_lists_of(0, document), with_lists_of(items, document)
    assert not found.meter.ended and not expected.meter.ended
    assert (found.states, found.seen, found.ends) == (expected.states, expected.seen, expected.ends)
    assert (found.findings.taken, found.findings.entered) == (expected.findings.taken, expected.findings.entered)
    assert found.findings.flaws.keys() == expected.findings.flaws.keys()


@settings(lenient, max_examples=4)
@given(patrols())
def test_a_list_of_any_length_leads_where_long_lists_lead(document: Json) -> None:
    hold_against_long_lists(document, 5)


@pytest.mark.drill
@settings(lenient, max_examples=200)
@given(patrols())
def test_a_list_of_any_length_leads_where_long_lists_lead_however_often_it_is_tried(document: Json) -> None:
    hold_against_long_lists(document, 6)


def retried(bound: Any = None, *, again: bool = False) -> Json:
    """Each place has a number of tries of its own; what is rejected is tried as often at once."""
    document = patrol([OVER])
    document["blackboard"]["place"] = {"type": "object"}
    driving = document["states"]["going"]["states"]["driving"]
    guard: Json = {"key": "n", "<": bound if bound is not None else {"key": "place.limit"}}
    retry = {"on": ENDS[1:], "when": guard, "to": "driving", "do": [COUNT]}
    forget = [{"set": "n", "value": 0}] if again else []
    driving["transitions"] = [retry, {"on": ENDS, "to": "next", "do": forget}]
    return document


@pytest.mark.parametrize("again", [False, True], ids=["one counter", "a counter for each"])
def test_a_counter_up_to_a_field_of_each_item_costs_a_few_ways_for_each_state(*, again: bool) -> None:
    space = RecordingSpace(Environment(Mission.model_validate(retried(again=again))), 500, 100, by_parts=False)
    space.explore()
    assert space.is_whole and space.made < 40 * space.states


def hold_against_every_way(document: Json) -> None:
    """What is explored where a step continues from a place once, and once for each way to it."""
    mission, spaces = Mission.model_validate(document), list[RecordingSpace]()
    for is_first_at in (Choices.is_first_at, lambda *given: True):
        with pytest.MonkeyPatch.context() as patch:
            patch.setattr(Choices, "is_first_at", is_first_at)
            space = RecordingSpace(Environment(mission), MOST, WORK, by_parts=False)
            space.explore()
            spaces.append(space)
    once, every = spaces
    assert not once.meter.ended and not every.meter.ended and once.made <= every.made
    assert (once.states, once.seen, once.ends) == (every.states, every.seen, every.ends)
    assert (once.findings.taken, once.findings.entered) == (every.findings.taken, every.findings.entered)
    assert once.findings.flaws.keys() == every.findings.flaws.keys()
    assert {*once.silent()} == {*every.silent()}


@pytest.mark.parametrize("bound", [1, 2])
def test_a_step_continues_once_from_a_place_that_several_ways_pass(bound: int) -> None:
    hold_against_every_way(retried(bound))


@settings(lenient, max_examples=4)
@given(patrols())
def test_a_place_that_several_ways_pass_leads_where_each_of_them_leads(document: Json) -> None:
    hold_against_every_way(document)


@pytest.mark.drill
@settings(lenient, max_examples=200)
@given(patrols())
def test_a_place_that_several_ways_pass_leads_where_each_leads_however_often_it_is_tried(document: Json) -> None:
    hold_against_every_way(document)


def waiting(after: list[Json], *, is_nested: bool = False, **inner: Json) -> Json:
    """A list whose every item is waited for, and what follows it; no report of a robot moves it."""
    wait: Json = {"transitions": [{"after_s": 5, "to": "next"}]}
    items: Json = {
        "each": "places", "as": "place", "initial": "wait",
        "states": {"wait": wait, "next": {"final": "succeeded"}, **inner},
    }  # fmt: skip
    if is_nested:
        items["states"] |= {
            "wait": {
                "each": "places",
                "as": "other",
                "initial": "stay",
                "transitions": [{"on": "succeeded", "to": "next"}],
                "states": {"stay": {"transitions": [{"after_s": 1, "to": "seen"}]}, "seen": {"final": "succeeded"}},
            }
        }
    return {
        "format": 1, "name": "waiting", "initial": "going",
        "blackboard": {
            "places": {"type": "list", "source": "argument"}, "place": {"type": "string"}, "other": {"type": "string"},
        },
        "states": {
            "going": {**items, "transitions": after},
            "break": {"transitions": [{"after_s": 1, "to": "going"}]},
            "over": {"final": "aborted"},
        },
    }  # fmt: skip


AGAIN: list[Json] = [{"on": "succeeded", "to": "break"}]
STAYS: Json = {"transitions": [{"after_s": 5, "to": "turn"}, {"after_s": 9, "to": "next"}]}
TURNS: Json = {"turn": {"transitions": [{"after_s": 5, "to": "wait"}]}}


@pytest.mark.parametrize("is_nested", [False, True])
def test_a_list_that_is_waited_for_comes_to_its_end(is_nested: bool) -> None:
    proof = prove(Mission.model_validate(waiting([OVER], is_nested=is_nested)), most=MOST, work=WORK * MOST)
    assert {each.verdict for each in proof.claims} == {"proved"}


@pytest.mark.parametrize(
    "document",
    [waiting(AGAIN), waiting(AGAIN, is_nested=True), waiting([OVER], wait=STAYS, **TURNS)],
    ids=["list after list", "nested, list after list", "within an item"],
)
def test_timers_that_go_round_with_lists_are_found(document: Json) -> None:
    proof = prove(Mission.model_validate(document), most=MOST, work=WORK * MOST)
    assert {each.verdict for each in proof.claims if each.name == "comes to rest"} == {"refuted"}
