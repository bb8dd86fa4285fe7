# SPDX-License-Identifier: Apache-2.0
"""What an answer brings is left open parameter by parameter: that finds what choosing all of it at once finds."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest
from hypothesis import HealthCheck, assume, given, settings
from hypothesis import strategies as st

from rai_missions.cli.proof_report import report
from rai_missions.engine import Chart
from rai_missions.engine.activities.activity import ActivityHost, Turn
from rai_missions.engine.activities.decision import DecisionActivity, DecisionMachine
from rai_missions.event import Event
from rai_missions.journal import Header
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.prove import prove, record
from rai_missions.prove.abstraction.state_key import Place
from rai_missions.prove.environment.answer_values import Parameters
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.environment.input_env import InputEnvironment
from rai_missions.replay.replay import replay
from tests.prove.explored import HANDS, Backwards, RecordingSpace, seen
from tests.prove.test_laws import hold_against_forgetless, hold_against_patient
from tests.prove.test_sights import hold_alike, lengths
from tests.rigs.charts import ScriptedRobot
from tests.rigs.laws import drill
from tests.strategies import mission_documents

Json = dict[str, Any]
lenient = settings(suppress_health_check=list(HealthCheck), deadline=None)
MOST = 150
NONE: Json = {}
KEYS: Json = {
    "n": {"type": "integer", "initial": 0}, "word": {"type": "string", "initial": ""},
    "kept": {"type": "integer", "source": "answer", "initial": 0},
    "battery": {"type": "number", "source": "robot", "max_age_s": 5},
}  # fmt: skip
PARAMETERS: Json = {
    "n": {"type": "integer"},
    "word": {"type": "string", "enum": ["a", "b"]},
    "kept": {"type": "integer"},
}
GUARDS: list[Json] = [
    {"key": "answer.n", "==": 1}, {"key": "answer.n", ">": 1}, {"key": "answer.word", "==": "a"},
    {"fresh": "answer.word"}, {"key": "answer.kept", "<": 2}, {"key": "n", "==": 1}, {"key": "word", "==": "b"},
    {"key": "kept", "==": 2}, {"key": "battery", "<": 0.2},
]  # fmt: skip
EFFECTS: list[Json] = [
    {"set": "n", "from": "answer.n"}, {"set": "word", "from": "answer.word"}, {"set": "n", "value": 1},
]  # fmt: skip
ANSWERS: list[Json] = [
    {}, {"n": 1}, {"n": 0, "word": "a"}, {"n": 2, "word": "b", "kept": 2}, {"word": "a", "kept": 3}, {"kept": 1},
]  # fmt: skip


class AtOnce(InputEnvironment):
    """All that an answer brings is chosen before it is given."""

    def leave_answers_open(self, machine: DecisionMachine) -> None:
        super().leave_answers_open(machine)
        receive = machine.receive

        def receiving(state: DecisionActivity, event: Event, host: ActivityHost) -> Turn | None:
            turn = receive(state, event, host)
            if turn is not None and turn.outcome is not None and isinstance(turn.outcome.data, Parameters):
                return turn._replace(outcome=turn.outcome._replace(data=turn.outcome.data.whole()))
            return turn

        machine.receive = receiving  # type: ignore[method-assign]


def at_once(mission: Mission) -> Environment:
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr("rai_missions.prove.environment.environment.InputEnvironment", AtOnce)
        return Environment(mission)


@st.composite
def asking(draw: st.DrawFn) -> Json:
    names = draw(st.lists(st.sampled_from(sorted(PARAMETERS)), min_size=1, max_size=3, unique=True))
    parameters = {
        "type": "object",
        "properties": {name: PARAMETERS[name] for name in names},
        "required": draw(st.lists(st.sampled_from(names), max_size=2, unique=True)),
    }
    if draw(st.booleans()):
        parameters["additionalProperties"] = False
    give: Json = {"parameters": parameters}
    if draw(st.integers(0, 3)) == 0:
        give["when"] = {"key": "battery", ">": 0.2}
    return {"question": "Which?", "ask": ["operator"], "fallback": "leave", "deadline_s": 5,
            "options": {"give": give, "leave": {}}}  # fmt: skip


@st.composite
def answered(draw: st.DrawFn) -> Json:
    """A mission that asks, and whose rules look at what the last answer brought, now or later."""
    names = ["one", "two", "three"]
    guard = st.one_of(st.sampled_from(GUARDS), st.sampled_from(GUARDS).map(lambda each: {"not": each}))
    do = st.lists(st.sampled_from(EFFECTS), max_size=2)
    states: Json = {}
    for at, name in enumerate(names):
        to, later = st.sampled_from([*names, "over", "odd"]), st.sampled_from([*names[at + 1 :], "over", "odd"])
        states[name] = {"transitions": [
            {"on": "next", "when": draw(guard), "to": draw(to), "do": draw(do)},
            {"when": draw(guard), "to": draw(later)}, {"after_s": 5, "to": draw(later)},
        ]}  # fmt: skip
        if at == 0 or draw(st.booleans()):
            states[name] = {"decision": draw(asking()), "transitions": [
                {"on": "give", "when": draw(guard), "to": draw(to), "do": draw(do)},
                {"on": draw(st.sampled_from(["give", "leave"])), "when": draw(guard), "to": draw(to), "do": draw(do)},
                {"on": ["give", "leave"], "to": draw(later), "do": draw(do)},
            ]}  # fmt: skip
    ends: Json = {"over": {"final": "aborted"}, "odd": {"final": "failed"}}
    document: Json = {"format": 1, "name": "answered", "version": "1.0.0", "blackboard": KEYS, "events": {"next": {}},
                      "initial": "one", "states": states | ends}  # fmt: skip
    if draw(st.integers(0, 2)) == 0:
        document["states"] = {"both": {"parallel": {
            "left": {"initial": "one", "states": states},
            "right": {"initial": draw(st.sampled_from(["idle", "waiting"])), "states": {
                "idle": {"transitions": [{"when": draw(guard), "to": "waiting"}]},
                "waiting": {"control": "autonomy", "transitions": [
                    {"on": "give", "of": "one", "when": draw(guard), "to": "there", "do": draw(do)}]},
                "there": {"transitions": [{"on": "next", "when": draw(guard), "to": "odd"}]},
            }},
        }}, **ends}  # fmt: skip
        document["initial"] = "both"
    if draw(st.booleans()):
        document["invariants"] = {"kept": {"not": {"all": [{"in": draw(st.sampled_from(names))}, draw(guard)]}}}
    return document


def space_of(environment: Environment) -> RecordingSpace:
    space = RecordingSpace(environment, MOST, work=200)
    space.explore()
    return space


def hold_against_at_once(document: Json) -> None:
    mission = Mission.model_validate(document)
    few, every = space_of(Environment(mission)), space_of(at_once(mission))
    hold_alike(few, every)
    assert few.environment.instruments.answered == every.environment.instruments.answered
    assert lengths(few) == lengths(every) and few.states == every.states and few.steps <= every.steps


def hold_against_backwards(document: Json) -> None:
    """A step does the same whatever was made before it."""
    mission = Mission.model_validate(document)
    one, other = space_of(Environment(mission)), space_of(Backwards(mission))
    hold_alike(one, other)
    assert one.environment.instruments.answered == other.environment.instruments.answered
    assert (lengths(one), one.states, one.steps) == (lengths(other), other.states, other.steps)


HAPPENS = st.lists(
    st.one_of(
        st.tuples(st.just("answer"), st.sampled_from(ANSWERS)),
        st.tuples(st.just("answer"), st.sampled_from(ANSWERS)),
        st.tuples(st.just("event"), st.just("next")),
        st.tuples(st.just("tick"), st.just("")),
        st.tuples(st.just("write"), st.just("battery"), st.sampled_from([0.1, 0.5])),
        st.tuples(st.just("control"), st.sampled_from(["", *HANDS]), st.sampled_from(["operator", "robot"])),
        st.sampled_from([("command", "pause"), ("command", "resume"), ("command", "resume")]),
    ),
    max_size=20,
)


def hold_against_walk(document: Json, script: list[tuple[Any, ...]]) -> None:
    """No run of the real chart leaves what was explored."""
    mission = Mission.model_validate(document)
    space = space_of(Environment(mission))
    assume(space.is_whole)
    chart, robot = Chart(mission), ScriptedRobot()
    robot.follow(chart.start(0.0))
    for at, drawn in enumerate(script, 1):
        event = (
            robot.event(drawn, float(at))
            if drawn[0] != "answer"
            else Event(
                robot.answerer,
                float(at),
                {"option": "give", "parameters": drawn[1]},
                "proposal",
                robot.questions[-1] if robot.questions else 0,
            )
        )
        robot.follow(chart.send(event))
        assert seen(chart) in space.seen, f"step {at} of {script}"


@settings(lenient, max_examples=8)
@given(answered())
def test_an_answer_that_is_left_open_finds_what_every_answer_finds(document: Json) -> None:
    hold_against_at_once(document)


test_an_answer_that_is_left_open_finds_what_every_answer_finds_however_often_it_is_tried = drill(
    hold_against_at_once, answered(), tried=settings(lenient, max_examples=1500)
)


@settings(lenient, max_examples=5)
@given(answered())
def test_the_order_in_which_things_are_tried_makes_no_difference(document: Json) -> None:
    hold_against_backwards(document)


test_the_order_in_which_things_are_tried_makes_no_difference_however_often_it_is_tried = drill(
    hold_against_backwards, st.one_of(answered(), mission_documents()), tried=settings(lenient, max_examples=1000)
)


@pytest.mark.drill
@settings(lenient, max_examples=1000)
@given(answered())
def test_what_is_not_read_of_an_answer_makes_no_difference(document: Json) -> None:
    hold_against_forgetless(document, MOST)
    hold_against_patient(document, MOST)


@settings(lenient, max_examples=8)
@given(answered(), HAPPENS)
def test_no_answer_leads_out_of_what_was_explored(document: Json, script: list[tuple[Any, ...]]) -> None:
    hold_against_walk(document, script)


test_no_answer_leads_out_of_what_was_explored_however_often_it_is_tried = drill(
    hold_against_walk, answered(), HAPPENS, tried=settings(lenient, max_examples=3000)
)


ASKING: Json = {
    "decision": {
        "question": "Which?",
        "ask": ["operator"],
        "fallback": "leave",
        "deadline_s": 5,
        "options": {
            "give": {
                "parameters": {
                    "type": "object",
                    "properties": {name: PARAMETERS[name] for name in ("n", "word")},
                    "required": ["n", "word"],
                    "additionalProperties": False,
                }
            },
            "leave": {},
        },
    },
    "transitions": [{"on": "give", "when": {"key": "answer.n", "==": 1}, "to": "odd"}, {"on": "leave", "to": "over"}],
}


def asking_mission(keys: Json = NONE, /, **states: Json) -> Mission:
    return Mission.model_validate({
        "format": 1, "name": "answered", "version": "1.0.0", "initial": next(iter(states)), "blackboard": keys,
        "events": {"next": {}},
        "states": states | {"over": {"final": "aborted"}, "odd": {"final": "failed"}},
        "invariants": {"never": {"not": {"in": "odd"}}},
    })  # fmt: skip


def test_a_refutation_by_an_answer_brings_all_that_is_asked_for_and_is_done_again(tmp_path: Path) -> None:
    """No rule looks at the word, and without it the answer would be refused."""
    mission = asking_mission(asking=ASKING)
    run = prove(mission).ways["invariants"]
    assert [event.data for each in run if (event := each.event) is not None] == [
        {"option": "give", "parameters": {"n": 1, "word": "a"}}
    ]
    lines = [*report(mission, prove(mission), {})]
    assert any("to 'asking': give (n 1, word a)" in line for line in lines), lines
    assert record(tmp_path / "run.journal", Header(dump(mission)), mission, run)
    assert replay(tmp_path / "run.journal").holds


def test_a_fallback_brings_nothing_of_the_answer_that_was_refused() -> None:
    give = {**ASKING["decision"]["options"]["give"], "when": {"key": "battery", ">": 0.5}}
    decision = {"question": "Which?", "ask": ["operator"], "attempts": 1, "fallback": "leave",
                "options": {"give": give, "leave": {}}}  # fmt: skip
    asked: Json = {"decision": decision, "transitions": [
        {"on": "leave", "when": {"key": "answer.n", "==": 1}, "to": "odd"}, {"on": ["give", "leave"], "to": "over"},
    ]}  # fmt: skip
    proof = prove(asking_mission({"battery": KEYS["battery"]}, asked=asked))
    assert "odd" in proof.never and not proof.ways


def test_a_deadline_brings_nothing_of_an_answer_that_was_tried_before() -> None:
    leave: Json = {"on": "leave", "when": {"fresh": "answer.n"}, "to": "odd"}
    asked: Json = {**ASKING, "transitions": [leave, {"on": ["give", "leave"], "to": "over"}]}
    assert space_of(Backwards(asking_mission(asked=asked))).findings.entered == {"asked", "over"}


class Keeping(RecordingSpace):
    """A space that remembers what the events bring that wait for a hand-back in its states."""

    def __init__(self, mission: Mission) -> None:
        super().__init__(Environment(mission), MOST)
        self.kept: list[Json] = []

    def _leave(self, number: int, run_key: bytes, place: Place) -> None:
        super()._leave(number, run_key, place)
        self.kept += [event.data.get("data", event.data) for event in place.saved.run.held_events]


def kept_in(mission: Mission, field: str) -> set[Any]:
    """The values of a field in all that waits for a hand-back anywhere."""
    space = Keeping(mission)
    space.explore()
    assert space.is_whole
    return {each[field] for each in space.kept}


def test_answers_that_wait_for_a_hand_back_are_states_of_their_own() -> None:
    drives: Json = {"control": "autonomy", "transitions": [
        {"on": "give", "of": "asking", "when": {"key": "answer.n", "==": 1}, "to": "there"},
        {"on": "give", "of": "asking", "to": "there"},
    ]}  # fmt: skip
    regions: Json = {
        "left": {"initial": "driving", "states": {"driving": drives, "there": {"about": "waits"}}},
        "right": {"initial": "asking", "states": {"asking": {**ASKING, "transitions": [{"on": "leave", "to": "quiet"}]},
                                                  "quiet": {"about": "waits"}}},
    }  # fmt: skip
    both = asking_mission(both={"parallel": regions, "transitions": [{"after_s": 60, "to": "over"}]})
    assert kept_in(both, "n") == {0, 1}


def test_failures_that_wait_for_a_hand_back_are_states_of_their_own() -> None:
    calls: Json = {"control": "autonomy", "entry": [{"call": "reset"}], "transitions": [
        {"on": "call_failed", "when": {"key": "event.why", "==": "broken"}, "to": "odd"}, {"after_s": 60, "to": "over"},
    ]}  # fmt: skip
    assert {"broken", "unavailable"} < kept_in(asking_mission(calls=calls), "why")


def test_an_answer_that_has_to_wait_only_since_it_was_given_waits_with_all_that_it_brings() -> None:
    """It writes a key by which a state is entered that the operator holds; that state's transitions name the answer."""
    asked = dict(
        ASKING["decision"],
        options={
            "leave": {},
            "give": {
                "parameters": {
                    "type": "object",
                    "properties": {name: PARAMETERS[name] for name in ("n", "kept")},
                    "required": ["n", "kept"],
                    "additionalProperties": False,
                }
            },
        },
    )
    late: Json = {"on": "give", "of": "asking", "to": "odd", "when": {
        "all": [{"key": "n", "==": 1}, {"key": "answer.n", "==": 1}]}}  # fmt: skip
    signed: Json = {"on": "next", "when": {"in": "driving"}, "to": "on", "do": [{"set": "n", "value": 1}]}
    regions: Json = {
        "left": {"initial": "asking", "states": {
            "asking": {"decision": asked, "transitions": [{"on": "leave", "to": "quiet"}]},
            "quiet": {"about": "waits"}}},
        "right": {"initial": "idle", "states": {
            "idle": {"transitions": [{"when": {"key": "kept", "==": 2}, "to": "driving"}]},
            "driving": {"control": "autonomy", "transitions": [late]}}},
        "signs": {"initial": "off", "states": {"off": {"transitions": [signed]}, "on": {"about": "waits"}}},
    }  # fmt: skip
    both: Json = {"parallel": regions, "transitions": [{"after_s": 60, "to": "over"}]}
    mission = asking_mission({name: KEYS[name] for name in ("n", "kept")}, both=both)
    assert prove(mission).ways["invariants"][-1].outcome == "aborted"


def test_a_parameter_that_is_read_later_can_be_anything_then() -> None:
    later: Json = {"transitions": [{"after_s": 1, "when": {"key": "answer.n", "==": 1}, "to": "odd"},
                                   {"after_s": 2, "to": "over"}]}  # fmt: skip
    asked: Json = {**ASKING, "transitions": [{"on": "give", "to": "later"}, {"on": "leave", "to": "over"}]}
    space = space_of(Environment(asking_mission(asking=asked, later=later)))
    assert space.is_whole and {"odd", "over"} <= space.findings.entered
