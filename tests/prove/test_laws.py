# SPDX-License-Identifier: Apache-2.0
"""What holds of every exploration: no run of the real chart leaves it."""

from __future__ import annotations

import json
import math
from functools import lru_cache
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.mission.mission import Mission
from rai_missions.prove.environment.environment import Environment
from tests.prove.explored import WORK, Forgetless, RecordingSpace, explored, facts, scripts, walked
from tests.strategies import mission_documents

Json = dict[str, Any]
lenient = settings(suppress_health_check=list(HealthCheck), deadline=None)
MOST = 100
SMALL = 50
"""In `make test`; what has more states is explored that far for nothing."""


@lru_cache(1)
def explored_of(text: str, most: int) -> RecordingSpace:
    """The space of a mission as JSON: hypothesis often draws one several times in a row, with other runs."""
    return explored(Mission.model_validate(json.loads(text)), most)


def hold_against(document: Json, runs: list[Any], alleys: int, waypoints: list[str], most: int = MOST) -> None:
    space = explored_of(json.dumps(document), most)
    assume(space.is_whole)
    mission = space.environment.chart.mission
    given, assumed = {"alleys": alleys, "waypoints": waypoints}, space.environment.world.assumed
    for known, script in runs:
        for number, found in enumerate(walked(mission, script, assumed, **given, **known)):
            assert found in space.seen, f"step {number} of {script}, started with {known}"


def runs() -> st.SearchStrategy[list[Any]]:
    return st.lists(st.tuples(facts(), scripts()), min_size=3, max_size=8)


@settings(lenient, max_examples=6)
@given(mission_documents(), runs(), st.integers(0, 3), st.lists(st.sampled_from(["a", "b"]), max_size=4))
def test_no_run_leaves_what_was_explored(document: Json, runs: list[Any], alleys: int, waypoints: list[str]) -> None:
    hold_against(document, runs, alleys, waypoints, SMALL)


@pytest.mark.long
@settings(lenient, max_examples=3)
@given(mission_documents())
def test_what_no_one_reads_again_makes_no_difference(document: Json) -> None:
    hold_against_forgetless(document, MOST)


def hold_against_forgetless(document: Json, most: int) -> None:
    mission = Mission.model_validate(document)
    every = explored(mission, most, Forgetless)
    assume(every.is_whole)
    few = explored(mission, most)
    assert few.is_whole and few.states <= every.states
    assert (few.seen, few.findings.taken, few.findings.entered) == (
        every.seen,
        every.findings.taken,
        every.findings.entered,
    )
    assert (
        few.findings.flaws.keys() == every.findings.flaws.keys()
        and few.environment.instruments.answered == every.environment.instruments.answered
    )
    assert few.environment.instruments.seen == every.environment.instruments.seen
    lengths = [
        {name: len(space.path(flaw.state)) for name, flaw in space.findings.flaws.items()} for space in (few, every)
    ]
    assert lengths[0] == lengths[1]


@settings(lenient)
@given(st.sampled_from((1, 2)))
def test_what_a_parallel_state_reads_on_entry_makes_a_difference_where_a_region_enters_it(wanted: int) -> None:
    numbers = [{"on": f"take_{n}", "do": [{"set": "k", "value": n}], "to": "taken"} for n in (1, 2)]
    taken: Json = {"transitions": [{"on": "cross", "to": "crossed"}]}
    crossed: Json = {"transitions": [{"when": {"key": "copy", "==": wanted}, "to": "over"}]}
    hold_against_forgetless({
        "name": "crossing", "initial": "both", "events": {"take_1": {}, "take_2": {}, "cross": {}},
        "blackboard": {name: {"type": "integer", "initial": 0} for name in ("k", "copy")},
        "states": {
            "both": {"entry": [{"set": "copy", "from": "k"}], "parallel": {
                "here": {"initial": "free", "states": {"free": {"transitions": numbers}, "taken": taken}},
                "there": {"initial": "waiting", "states": {"waiting": {}, "crossed": crossed}},
            }},
            "over": {"final": "aborted"},
        },
    }, MOST)  # fmt: skip


@pytest.mark.long
@settings(lenient, max_examples=3)
@given(mission_documents())
def test_what_is_reported_again_is_what_happens_again(document: Json) -> None:
    hold_against_patient(document, MOST)


def test_a_way_that_looks_at_what_differs_is_gone_again() -> None:
    """Of the same happening, one way looks at the counter and another does not."""
    counted: Json = {"on": "more", "do": [{"set": "tries", "add": 1}]}
    guard: Json = {"any": [{"key": "event.kind", "==": "sure"}, {"key": "tries", ">": 2}]}
    hold_against_patient(
        {
            "format": 1,
            "name": "counted",
            "version": "1.0.0",
            "initial": "here",
            "blackboard": {"tries": {"type": "integer", "initial": 0}},
            "events": {"go": {"fields": {"kind": "string"}}, "more": {}},
            "states": {
                "here": {"transitions": [counted, {"on": "go", "when": guard, "to": "there"}]},
                "there": {"transitions": [{"on": "more", "when": {"key": "tries", "<": 2}, "to": "here"}]},
                "over": {"final": "aborted"},
            },
            "transitions": [{"on": "go", "when": {"key": "event.kind", "==": "stop"}, "to": "over"}],
        },
        MOST,
        work=math.inf,
    )


def test_a_step_that_counts_is_the_same_from_every_number_that_guards_treat_alike() -> None:
    def more(key: str, many: int) -> Json:
        return {"set": key, "add": many}

    hold_against_patient(
        {
            "format": 1,
            "name": "counted",
            "version": "1.0.0",
            "initial": "here",
            "blackboard": {"n": {"type": "integer", "initial": 0}, "m": {"type": "integer", "initial": 0}},
            "events": {"one": {}, "two": {}, "again": {}, "other": {}, "stop": {}},
            "states": {
                "here": {
                    "transitions": [
                        {"on": "one", "when": {"key": "n", "<": 9}, "do": [more("n", 1)], "to": "looking"},
                        {
                            "on": "two",
                            "when": {"key": "n", "<": 9},
                            "do": [more("n", 2), more("m", -1)],
                            "to": "looking",
                        },
                        {"on": "again", "do": [{"set": "n", "value": 1}]},
                        {"on": "other", "when": {"key": "m", "<": 3}, "do": [more("m", 1)]},
                    ]
                },
                "looking": {
                    "transitions": [
                        {"when": {"key": "n", "==": 7}, "to": "over"},
                        {"when": {"key": "n", ">": 4}, "do": [{"set": "m", "value": 0}], "to": "here"},
                        {"on": "one", "to": "here"},
                        {"on": "two", "do": [more("n", 1)], "to": "looking"},
                    ]
                },
                "over": {"final": "aborted"},
            },
            "transitions": [{"on": "stop", "to": "over"}],
        },
        30 * MOST,
        work=math.inf,
    )


def test_a_step_is_the_same_from_every_list_that_it_does_not_look_into() -> None:
    hold_against_patient(
        {
            "format": 1,
            "name": "listed",
            "version": "1.0.0",
            "initial": "going_over",
            "blackboard": {"places": {"type": "list", "source": "argument"}, "place": {"type": "string"}},
            "events": {"next": {}, "other": {}, "again": {}, "stop": {}},
            "states": {
                "going_over": {
                    "each": "places",
                    "as": "place",
                    "initial": "first",
                    "transitions": [{"on": ["succeeded", "failed"], "to": "over"}, {"on": "again", "to": "going_over"}],
                    "states": {
                        "first": {"transitions": [{"on": "other", "to": "second"}]},
                        "second": {
                            "transitions": [
                                {"on": "next", "to": "gone"},
                                {"on": "other", "when": {"key": "place", "==": "a"}, "to": "first"},
                            ]
                        },
                        "gone": {"final": "succeeded"},
                    },
                },
                "over": {"final": "aborted"},
            },
            "transitions": [{"on": "stop", "to": "over"}],
        },
        30 * MOST,
        work=math.inf,
    )


def test_guards_that_are_held_come_in_one_order_whichever_was_true_first() -> None:
    hold_against_patient(
        {
            "name": "held_in_turn",
            "initial": "driving",
            "events": {"poke": {}},
            "blackboard": {"battery": {"type": "number", "source": "robot"}},
            "states": {
                "driving": {
                    "action": "drive",
                    "control": "autonomy",
                    "transitions": [
                        {
                            "on": "poke",
                            "when": {"not": {"held": {"key": "battery", ">": 0.25}, "for_s": 2}},
                            "do": [{"log": "poked"}],
                        },
                        {
                            "when": {"held": {"held": {"key": "battery", "!=": 0.5}, "for_s": 2}, "for_s": 2},
                            "to": "over",
                        },
                    ],
                },
                "over": {"final": "aborted"},
            },
        },
        30 * MOST,
        work=math.inf,
    )


FAILED = ["failed", "rejected", "timed_out", "unverified"]
GOALS: Json = {
    "la": {"action": "lift", "timeout_s": 5, "transitions": [
        {"on": "l", "to": "lb", "do": [{"set": "armed", "value": True}]},
        {"on": "succeeded", "when": {"key": "armed", "==": True}, "to": "lend"},
        {"on": ["succeeded", *FAILED], "to": "lb"}]},
    "lb": {"transitions": [{"on": "l", "to": "la"}]}, "lend": {"final": "succeeded"},
}  # fmt: skip
LOOKING: Json = {
    "ra": {"action": "look", "timeout_s": 5, "transitions": [{"on": ["r", "succeeded", *FAILED], "to": "rb"}]},
    "rb": {"transitions": [{"on": "r", "to": "ra"}]},
}  # fmt: skip
CALLS: list[Json] = [
    {"on": "l", "do": [{"call": "horn"}]}, {"on": "r", "do": [{"call": "bell"}, {"set": "armed", "value": True}]},
    {"on": "call_failed", "when": {"all": [{"key": "event.name", "==": "horn"}, {"key": "armed", "==": True}]},
     "to": "over"},
    {"on": "call_failed", "do": [{"set": "armed", "value": False}]},
]  # fmt: skip
BEGUN: dict[str, Json] = {
    "goals": {"parallel": {"left": {"initial": "la", "states": GOALS}, "right": {"initial": "ra", "states": LOOKING}},
              "transitions": [{"on": "succeeded", "to": "over"}]},
    "calls": {"transitions": CALLS},
}  # fmt: skip
"""What is begun in either order → the state that begins it."""


@pytest.mark.parametrize("what", BEGUN)
def test_what_was_begun_comes_in_one_order_whichever_began_first(what: str) -> None:
    apart = RobotFacts(uses={"lift": frozenset(["arm"]), "look": frozenset(["camera"])})
    hold_against_patient(
        {
            "name": "begun_in_turn",
            "initial": "work",
            "events": {"l": {}, "r": {}, "stop": {}},
            "blackboard": {"armed": {"type": "boolean", "initial": False}},
            "states": {"work": BEGUN[what], "over": {"final": "aborted"}},
            "transitions": [{"on": "stop", "to": "over"}],
        },
        30 * MOST,
        work=math.inf,
        robot_facts=apart,
    )


def hold_against_patient(document: Json, most: int, work: float = WORK, robot_facts: RobotFacts | None = None) -> None:
    """Whatever the mission's own keys are: each step is made, none is taken from a state that differs in them alone."""
    mission = Mission.model_validate(document)
    quick, patient = (
        RecordingSpace(Environment(mission, robot_facts=robot_facts), most, work, by_parts=False) for _ in range(2)
    )
    patient.environment.world.own_fade = True  # then nothing is remembered of other states
    for space in (quick, patient):
        space.explore()
        if work < math.inf:
            assume(not space.meter.ended)  # what is reported again costs less
    hold_alike(quick, patient)


def hold_alike(one: RecordingSpace, other: RecordingSpace) -> None:
    """The same states in the same order, the same steps between them, and the same learned of them."""
    for what in ("states", "sets", "waiting", "ends", "steps", "seen"):
        assert getattr(one, what) == getattr(other, what), what
    for what in ("flaws", "taken", "entered"):
        assert getattr(one.findings, what) == getattr(other.findings, what), what
    assert [one.path(number) for number in range(one.states)] == [other.path(number) for number in range(other.states)]
    assert list(one.edges()) == list(other.edges()) and list(one.silent()) == list(other.silent())
    assert list(one.edges(time_only=True)) == list(other.edges(time_only=True))
    measured, expected = one.environment.instruments, other.environment.instruments
    assert measured.seen == expected.seen and measured.answered == expected.answered


@pytest.mark.drill
@settings(lenient, max_examples=1000)
@given(mission_documents())
def test_what_is_reported_again_is_what_happens_again_however_often_it_is_tried(document: Json) -> None:
    hold_against_patient(document, 4 * MOST)


@pytest.mark.drill
@settings(lenient, max_examples=1000)
@given(mission_documents())
def test_what_no_one_reads_again_makes_no_difference_however_often_it_is_tried(document: Json) -> None:
    hold_against_forgetless(document, 4 * MOST)


@pytest.mark.drill
@settings(lenient, max_examples=3000)
@given(mission_documents(), runs(), st.integers(0, 3), st.lists(st.sampled_from(["a", "b"]), max_size=4))
def test_no_run_leaves_what_was_explored_however_often_it_is_tried(
    document: Json, runs: list[Any], alleys: int, waypoints: list[str]
) -> None:
    hold_against(document, runs, alleys, waypoints)
