# SPDX-License-Identifier: Apache-2.0
"""What events, answers, results and arguments bring along: every value that guards report apart is tried."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

from rai_missions.journal import Header
from rai_missions.mission.files import dump
from rai_missions.mission.mission import Mission
from rai_missions.prove import Proof, prove, record
from tests.prove.test_flaws import ABORTED, DONE, DRIVING, ENDS, asking

Json = dict[str, Any]
AT_HOME: Json = {"type": "boolean", "source": "robot", "max_age_s": 5}
WRONG: Json = {**DRIVING, "transitions": [{"on": "succeeded", "to": "done"}, {"on": ENDS, "to": "aborted"}]}
NEVER: Json = {"never": {"not": {"in": "wrong"}}}


def proof_of(states: Json, keys: Json | None = None, **words: Any) -> Proof:
    return prove(
        Mission.model_validate(
            {
                "format": 1,
                "name": "surroundings",
                "initial": next(iter(states)),
                **words,
                "blackboard": {"at_home": AT_HOME, **(keys or {})},
                "states": {**states, "done": DONE, "aborted": ABORTED},
            }
        ),
        most=2000,
    )


def refuted(proof: Proof) -> dict[str, list[str]]:
    """Claim → its run."""
    return {
        each.name: [scene.words for scene in proof.ways.get(each.name, ())]
        for each in proof.claims
        if each.verdict == "refuted"
    }


# -- events ----------------------------------------------------------------------------------------------------------


def test_an_event_brings_each_payload_that_guards_report_apart() -> None:
    waiting = {"transitions": [{"on": "seen", "when": {"key": "event.height_m", ">": 3}, "to": "driving"}]}
    events = {"seen": {"fields": {"height_m": "number"}}}
    assert refuted(proof_of({"waiting": waiting, "driving": DRIVING}, events=events)) == {}


def test_events_whose_fields_share_a_name_each_bring_their_own_type() -> None:
    transitions = [
        {"on": "seen", "when": {"key": "event.what", ">": 3}, "to": "driving"},
        {"on": "heard", "when": {"key": "event.what", "==": "horn"}, "to": "wrong"},
    ]
    events = {"seen": {"fields": {"what": "number"}}, "heard": {"fields": {"what": "string"}}}
    for given in (events, dict(reversed(events.items()))):
        proof = proof_of({"waiting": {"transitions": transitions}, "driving": DRIVING, "wrong": WRONG}, events=given)
        assert refuted(proof) == {} and proof.never == ()


def test_what_a_raised_event_takes_from_a_key_is_distinguished() -> None:
    counting = {"entry": [{"set": "many", "add": 1}],
                "transitions": [{"on": "next", "to": "speaking"}, {"on": "stop", "to": "aborted"}]}  # fmt: skip
    message = {
        "entry": [{"raise": "counted", "data": {"many": {"from": "many"}}}],
        "transitions": [{"on": "counted", "when": {"key": "event.many", ">=": 3}, "to": "wrong"},
                        {"on": "counted", "to": "counting"}],
    }  # fmt: skip
    proof = proof_of(
        {"counting": counting, "speaking": message, "wrong": WRONG},
        {"many": {"type": "integer", "initial": 0}},
        events={"next": {}, "stop": {}, "counted": {"fields": {"many": "integer"}}},
        invariants=NEVER,
    )
    assert refuted(proof)["invariants"] == ["the mission starts", *["event 'next'"] * 3]


# -- answers ---------------------------------------------------------------------------------------------------------


def answering(schema: Json, when: Json | None = None, whole: Json | None = None) -> Proof:
    parameters = whole or {"type": "object", "properties": {"speed": schema}, "required": ["speed"]}
    transitions = [{"on": "go", "to": "wrong", "when": when}] if when is not None else []
    states = {
        "asking": asking({"go": {"parameters": parameters}, "stop": {}},
                         [*transitions, {"on": "go", "to": "driving"}, {"on": "stop", "to": "aborted"}],
                         fallback="stop"),
        "driving": DRIVING,
    }  # fmt: skip
    return proof_of({**states, "wrong": WRONG} if transitions else states, invariants=NEVER if transitions else {})


SCHEMAS: dict[str, Json] = {
    "a pattern": {"type": "string", "pattern": "^[a-z]{3}$"},
    "a length": {"type": "string", "maxLength": 4},
    "a list of one or more": {"type": "array", "minItems": 1, "items": {"type": "number"}},
    "an object with a field": {"type": "object", "required": ["x"], "properties": {"x": {"type": "number"}}},
    "one value": {"const": "fast"},
    "multiples": {"type": "integer", "multipleOf": 7, "minimum": 1},
    "bounds that are left out": {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1},
    "two types": {"type": ["number", "null"]},
    "either": {"anyOf": [{"type": "number"}, {"type": "boolean"}]},
}


@pytest.mark.parametrize("schema", SCHEMAS.values(), ids=SCHEMAS)
def test_an_option_can_be_taken_whatever_its_parameters_must_be(schema: Json) -> None:
    assert refuted(answering(schema)) == {}


def test_a_parameter_that_is_elsewhere_in_its_schema_is_found_there() -> None:
    whole = {"type": "object", "properties": {"speed": {"$ref": "#/$defs/speed"}}, "required": ["speed"],
             "$defs": {"speed": {"type": "number", "maximum": 9}}}  # fmt: skip
    assert "invariants" in refuted(answering({}, {"key": "answer.speed", ">": 5}, whole))
    assert "invariants" not in refuted(answering({}, {"key": "answer.speed", ">": 9}, whole))


BETWEEN = {"type": "number", "exclusiveMinimum": 0, "exclusiveMaximum": 1}
WORD = {"type": "string", "pattern": "^[a-z]{3}$"}


@pytest.mark.parametrize(("schema", "when", "can_be"), [
    (BETWEEN, {"key": "answer.speed", ">": 0.9}, True), (BETWEEN, {"key": "answer.speed", ">=": 1}, False),
    ({"type": "integer", "exclusiveMinimum": 3}, {"key": "answer.speed", "<=": 3}, False),
    ({"type": "integer", "exclusiveMinimum": 3}, {"key": "answer.speed", "==": 4}, True),
    (WORD, {"key": "answer.speed", "!=": "abc"}, True), (WORD, {"key": "answer.speed", "==": "abc"}, True),
    (WORD, {"key": "answer.speed", "==": "nine"}, False),
])  # fmt: skip
def test_an_answer_brings_what_its_schema_allows_and_no_more(schema: Json, when: Json, can_be: bool) -> None:
    assert ("invariants" in refuted(answering(schema, when))) is can_be


# -- lists and arguments ---------------------------------------------------------------------------------------------

ROUND: Json = {
    "going": {
        "each": "jobs", "as": "job", "initial": "looking",
        "states": {
            "looking": {"entry": [{"set": "many", "add": 1}],
                        "transitions": [{"when": {"key": "job", "==": "stone"}, "to": "lost"},
                                        {"on": "next", "to": "ok"}]},
            "lost": {"final": "failed"}, "ok": {"final": "succeeded"},
        },
        "transitions": [{"when": {"key": "many", ">=": 4}, "to": "wrong"},
                        {"on": ["succeeded", "failed"], "to": "aborted"}],
    },
    "wrong": WRONG,
}  # fmt: skip
JOBS: Json = {"job": {"type": "string"}, "many": {"type": "integer", "initial": 0}}
BY_RESULT = {"call": "look", "timeout_s": 5, "result": {"jobs": "jobs"},
             "transitions": [{"on": "succeeded", "to": "going"}, {"on": ENDS, "to": "aborted"}]}  # fmt: skip
BY_EVENT = {"transitions": [{"on": "got", "do": [{"set": "jobs", "from": "event.jobs"}], "to": "going"}]}
BY_ROBOT = {"transitions": [{"on": "next", "do": [{"set": "jobs", "from": "seen"}], "to": "going"}]}


@pytest.mark.parametrize(("first", "keys"), [
    (BY_RESULT, {}), ({**BY_RESULT, "result": {"jobs": "order.jobs"}}, {}), (BY_EVENT, {}),
    (BY_ROBOT, {"seen": {"type": "list", "source": "robot"}}),
], ids=["a result", "a field in a result", "an event", "a copy of what the robot reports"])  # fmt: skip
def test_a_list_that_was_given_has_any_length_and_any_items(first: Json, keys: Json) -> None:
    proof = proof_of(
        {"first": first, **ROUND},
        {"jobs": {"type": "list", "initial": []}, **JOBS, **keys},
        invariants=NEVER,
        events={"next": {}, "got": {"fields": {"jobs": "list"}}},
    )
    assert "invariants" in refuted(proof) and proof.never == ("done",)


def test_a_list_may_be_a_field_of_an_object() -> None:
    going = {**ROUND["going"], "each": "order.jobs"}
    order = {"type": "object", "source": "argument", "fields": {"jobs": "list"}}
    proof = proof_of({**ROUND, "going": going}, {"order": order, **JOBS}, invariants=NEVER, events={"next": {}})
    assert "invariants" in refuted(proof) and proof.never == ("done",)


@pytest.mark.parametrize("by", ["a transition", "its initial value"])
def test_a_robot_can_be_near_each_pose_of_a_list_that_the_mission_wrote(by: str) -> None:
    stops = [{"x": 3.0, "y": 1.0, "frame": "map"}, {"x": 7.0, "y": 2.0, "frame": "map"}]
    near = {"near": ["pose", "stop"], "within_m": 0.5}
    states = {"there": {"transitions": [{"when": near, "to": "ok"}]}, "ok": {"final": "succeeded"}}
    going = {"each": "stops", "as": "stop", "initial": "there", "states": states,
             "transitions": [{"on": "succeeded", "to": "driving"}, {"on": "failed", "to": "aborted"}]}  # fmt: skip
    first = {"transitions": [{"on": "next", "to": "going", "do": [{"set": "stops", "value": stops}]}]}
    is_written = by == "a transition"
    keys: Json = {"stops": {"type": "list", "initial": [] if is_written else stops},
                  "stop": {"type": "pose", "frame": "map"},
                  "pose": {"type": "pose", "source": "robot", "max_age_s": 5, "frame": "map"}}  # fmt: skip
    document = {"first": first, "going": going} if is_written else {"going": going}
    proof = proof_of({**document, "driving": DRIVING}, keys, events={"next": {}})
    assert "rules" not in refuted(proof) and proof.never in ((), ("aborted",)), (refuted(proof), proof.never)


def test_two_rounds_of_one_list_each_look_at_its_items_in_their_own_way() -> None:
    def going(item: str, word: str, number: int, transitions: list[Json]) -> Json:
        rest = [{"when": {"key": item, "==": word}, "to": f"lost{number}"}, {"on": "next", "to": f"ok{number}"}]
        states = {"transitions": rest}
        ends = {f"lost{number}": {"final": "failed"}, f"ok{number}": {"final": "succeeded"}}
        return {"each": "jobs", "as": item, "initial": f"at{number}", "states": {f"at{number}": states, **ends},
                "transitions": transitions}  # fmt: skip

    proof = proof_of(
        {
            "first": going("one", "log", 1, [{"on": "succeeded", "to": "second"}, {"on": "failed", "to": "aborted"}]),
            "second": going(
                "two", "stone", 2, [{"on": "succeeded", "to": "driving"}, {"on": "failed", "to": "aborted"}]
            ),
            "driving": DRIVING,
        },
        {"jobs": {"type": "list", "source": "argument"}, "one": {"type": "string"}, "two": {"type": "string"}},
        events={"next": {}},
    )
    assert refuted(proof) == {} and proof.never == ()


@pytest.mark.parametrize(("optional", "claims"), [(False, set()), (True, {"ends"})])
def test_no_run_starts_without_an_argument_that_it_needs(optional: bool, claims: set[str]) -> None:
    transitions = [
        {"when": {"key": "alleys", ">": 0}, "to": "driving"},
        {"when": {"key": "alleys", "<=": 0}, "to": "aborted"},
    ]
    keys = {"alleys": {"type": "integer", "source": "argument", "optional": optional}}
    assert set(refuted(proof_of({"choosing": {"transitions": transitions}, "driving": DRIVING}, keys))) == claims


# -- trees -----------------------------------------------------------------------------------------------------------

CLEAR: Json = {"check": {"key": "clear", "==": True}}
TREES: dict[str, Json] = {
    "a check that is waited for": {"condition": "success", "child": CLEAR},
    "a guard that is watched": {"eternal_guard": CLEAR["check"], "child": {"action": "lift", "timeout_s": 5}},
    "branches that take over from each other": {
        "selector": [{"sequence": [CLEAR, {"call": "horn", "timeout_s": 2}]}, {"action": "lift", "timeout_s": 5}],
        "memory": False,
    },
}


@pytest.mark.parametrize("tree", TREES.values(), ids=TREES)
def test_a_tree_that_continues_for_long_has_few_states(tree: Json) -> None:
    transitions = [{"on": "succeeded", "to": "driving"}, {"on": ["failed", "timed_out"], "to": "aborted"}]
    lifting = {"tree": tree, "timeout_s": 30, "transitions": transitions}
    mission = Mission.model_validate({
        "format": 1, "name": "lifting", "initial": "lifting",
        "blackboard": {"at_home": AT_HOME, "clear": {"type": "boolean", "source": "robot", "max_age_s": 2}},
        "states": {"lifting": lifting, "driving": DRIVING, "done": DONE, "aborted": ABORTED},
    })  # fmt: skip
    proof = prove(mission, most=200)
    assert proof.is_whole and proof.verdict == "proved"


# -- time ------------------------------------------------------------------------------------------------------------


def test_an_invariant_may_speak_of_the_mission_s_age() -> None:
    proof = proof_of({"driving": DRIVING}, invariants={"soon": {"not": {"elapsed_s": 30}}})
    assert refuted(proof) == {"invariants": ["the mission starts", "'the mission' has lasted 30 s"]}


def test_a_run_that_ends_for_another_reason_does_not_show_what_was_reported(tmp_path: Path) -> None:
    near = {"held": {"key": "near", "==": True}, "for_s": 3}
    mission = Mission.model_validate({
        "format": 1, "name": "near", "initial": "driving",
        "blackboard": {"at_home": AT_HOME, "near": {"type": "boolean", "source": "robot", "max_age_s": 1}},
        "states": {
            "driving": {**DRIVING, "transitions": [{"when": near, "to": "aborted"}, *DRIVING["transitions"]]},
            "done": DONE, "aborted": ABORTED,
        },
        "invariants": {"not_for_long": {"not": {"all": [{"in": "driving"}, near]}}},
    })  # fmt: skip
    reported = prove(mission).ways["invariants"]  # the two guards ripen at one instant, and the transition comes first
    assert (reported[-1].outcome, record(tmp_path / "reported.journal", Header(dump(mission)), mission, reported)) == (
        "aborted",
        False,
    )
