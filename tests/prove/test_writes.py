# SPDX-License-Identifier: Apache-2.0
"""Keys that a transition is sure to write: what was there before distinguishes no two states."""

from __future__ import annotations

from typing import Any

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.mission.mission import Mission
from rai_missions.prove.environment.environment import Environment
from tests.prove.test_goals import moving
from tests.prove.test_laws import hold_against_forgetless

Json = dict[str, Any]
MOST = 400
EITHER_STRING: Json = {"anyOf": [{"type": "string"}, {"type": "string"}]}
STRING_OR_NUMBER: Json = {"anyOf": [{"type": "string"}, {"type": "integer"}]}
lenient = settings(suppress_health_check=list(HealthCheck), deadline=None)
WORD: Json = {"properties": {"word": {"type": "string"}}, "required": ["word"]}


def reads(document: Json, state: str) -> frozenset[str]:
    """What may be read from a state on."""
    environment = Environment(Mission.model_validate(document))
    return environment.rest.live.within([environment.chart.program.graph.nodes[state]])


def asking(parameters: Json, **more: Json) -> Json:
    """A mission that asks for a word, where one may be known already, and compares it."""
    put = [{"on": each, "to": "asking", "do": [{"set": "word", "value": each}]} for each in ("one", "two")]
    options: Json = {"say": {"parameters": {"type": "object", **parameters}}, "leave": {}}
    question = {
        "question": "which?", "options": options, "ask": ["operator"], "deadline_s": 60, "fallback": "leave",
    }  # fmt: skip
    answered = [
        {"on": "say", "to": "judging", "do": [{"set": "word", "from": "answer.word"}]},
        {"on": "leave", "to": "over"},
    ]
    compared = [{"when": {"key": "word", "==": "two"}, "to": "over"}, {"after_s": 1, "to": "over"}]
    return {
        "name": "asking", "initial": "first", "events": {"one": {}, "two": {}},
        "blackboard": {"word": {"type": "string", "initial": ""}},
        "states": {
            "first": {"transitions": put},
            "asking": {"decision": question, "transitions": answered},
            "judging": {"transitions": compared, **more},
            "over": {"final": "aborted"},
        },
    }  # fmt: skip


def with_fields(document: Json) -> Json:
    """The same, where the word is an object of a shape that an answer may not have."""
    document["blackboard"]["word"] = {"type": "object", "fields": {"n": "string"}}
    for put in document["states"]["first"]["transitions"]:
        put["do"] = [{"set": "word", "value": {"n": put["on"]}}]
    document["states"]["judging"]["transitions"][0]["when"]["key"] = "word.n"
    return document


def reading(*outcomes: str) -> Json:
    """A mission that reads a request, and plans for the goal, where one may be known already."""
    document = moving()
    document["blackboard"] |= {"wanted": {"type": "object"}, "reading": {"type": "object"}}
    document["states"]["reading_it"] = {
        "read": "request", "over": "objects", "into": "reading",
        "transitions": [
            {"on": list(outcomes), "to": "planning", "do": [{"set": "wanted", "from": "reading.goal"}]},
            {"on": ["unclear", "refused", "rejected"], "to": "refused"},
        ],
    }  # fmt: skip
    return document | {"initial": "reading_it"}


def spoiling(place: str) -> Json:
    """A mission in which a transition that leaves no state writes over a reading, ahead of its outcome."""
    again = {
        "when": {"all": [{"fresh": "reading.reason"}, {"key": "is_spoiled", "==": False}]},
        "do": [{"set": "reading", "from": "other"}, {"set": "is_spoiled", "value": True}],
    }
    document, over = reading("succeeded"), {"transitions": [{"after_s": 1, "to": "refused"}]}
    document["blackboard"] |= {
        "other": {"type": "object", "initial": {"x": 1}}, "is_spoiled": {"type": "boolean", "initial": False},
    }  # fmt: skip
    document["events"] = {"one": {}, "two": {}, "go": {}}
    put = [{"on": on, "to": "resting", "do": [{"set": "wanted", "value": {"n": on}}]} for on in ("one", "two")]
    kept = {"all": [{"key": "wanted.n", "==": "two"}, {"not": {"fresh": "reading.goal"}}]}
    asking = document["states"]["reading_it"]
    asking["transitions"][0]["to"] = "judging"
    judging = {"transitions": [{"when": kept, "to": "odd"}, *over["transitions"]]}
    around: Json = {"initial": "reading_it", "states": {"reading_it": asking, "judging": judging}}
    document["states"] = {
        "first": {"transitions": put}, "resting": {"transitions": [{"on": "go", "to": "around"}]}, "around": around,
        "odd": over, "refused": {"final": "aborted"},
    }  # fmt: skip
    at = {"mission": document, "parent": around, "state": asking}[place]
    at["transitions"] = [again, *at.get("transitions", [])]
    return {**document, "initial": "first", "invariants": {}}


def ticking(leaf: Json) -> Json:
    """A mission with a tree that writes, and a guard that reads."""
    document = asking(WORD, tree={"sequence": [leaf, {"wait_s": 1}]})
    document["blackboard"]["n"] = {"type": "integer", "initial": 0}
    document["states"]["judging"]["transitions"] = [
        {"on": ["succeeded", "failed"], "to": "judged", "do": [{"set": "word", "value": "one"}]}
    ]
    looked = {"any": [{"key": "word", "==": "two"}, {"key": "n", ">": 1}]}
    document["states"]["judged"] = {"transitions": [{"when": looked, "to": "over"}, {"after_s": 1, "to": "judging"}]}
    return document


WRITING: tuple[tuple[Json, str, str, bool], ...] = (
    (asking(WORD), "asking", "word", False),
    (asking({**WORD, "properties": {"word": EITHER_STRING}}), "asking", "word", False),
    (asking({**WORD, "required": []}), "asking", "word", True),
    (asking({**WORD, "properties": {}}), "asking", "word", True),
    (asking({**WORD, "properties": {"word": {"type": ["string", "null"]}}}), "asking", "word", True),
    (asking({**WORD, "properties": {"word": STRING_OR_NUMBER}}), "asking", "word", True),
    (with_fields(asking({**WORD, "properties": {"word": {"type": "object"}}})), "asking", "word.n", True),
    (reading("succeeded"), "reading_it", "wanted", False),
    (reading("succeeded", "unclear"), "reading_it", "wanted", True),
    (spoiling("state"), "reading_it", "wanted.n", True),
    (spoiling("parent"), "reading_it", "wanted.n", True),
    (spoiling("mission"), "reading_it", "wanted.n", True),
    (ticking({"set": "word", "value": "two"}), "judging", "word", False),
    (ticking({"set": "n", "add": 1}), "judging", "n", True),
)  # fmt: skip
"""A mission, a state of it, a key, and whether what is there on entry may be read."""


@pytest.mark.parametrize(("document", "state", "key", "is_read"), WRITING)
def test_what_is_sure_to_be_written_over_is_not_read(document: Json, state: str, key: str, is_read: bool) -> None:
    assert (key in reads(document, state)) == is_read


@settings(lenient, max_examples=20)
@given(st.sampled_from([each[0] for each in WRITING]))
def test_what_is_written_over_makes_no_difference(document: Json) -> None:
    hold_against_forgetless(document, MOST)
