# SPDX-License-Identifier: Apache-2.0
"""The schema of an option's parameters comes with a mission, and may be anybody's: it opens nothing and ends soon."""

from __future__ import annotations

import sys
import time
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.mission.option_parameters import MOST_PARTS, parameter_faults, schema_fault

SPEED = {"type": "object", "properties": {"speed": {"type": "number", "maximum": 2}}, "required": ["speed"]}
LAUGHS: dict[str, Any] = {
    "$defs": {f"a{n}": {"allOf": [{"$ref": f"#/$defs/a{n + 1}"}] * 2} for n in range(40)} | {"a40": {}}
}
LAUGHS["$ref"] = "#/$defs/a0"
HOSTILE: dict[str, dict[str, Any]] = {
    "a file": {"properties": {"a": {"$ref": "file:///etc/passwd"}}},
    "another machine": {"properties": {"a": {"$ref": "http://127.0.0.1:9/schema"}}},
    "a name of its own": {"$id": "http://127.0.0.1:9/", "properties": {"a": {"$ref": "#/b"}}},
    "a circle": {"$defs": {"a": {"$ref": "#/$defs/a"}}, "$ref": "#/$defs/a"},
    "itself": {"properties": {"a": {"$ref": "#"}}, "$ref": "#"},
    "nowhere": {"properties": {"a": {"$ref": "#/$defs/nothing"}}},
    "a billion laughs": LAUGHS,
    "a slow lookahead": {"properties": {"a": {"pattern": "^(?=(a+)+$)a"}}},
    "a backreference": {"properties": {"a": {"pattern": "^(a+)\\1+$"}}},
    "no pattern": {"properties": {"a": {"pattern": "("}}},
    "an enormous pattern": {"properties": {"a": {"pattern": "(((a{1000}){1000}){1000})"}}},
    "slow names": {"patternProperties": {"^(a+)+$": {}}},
    "nested remainders": {"unevaluatedProperties": {"anyOf": [{}, {}]}},
}


@pytest.mark.parametrize("schema", HOSTILE.values(), ids=HOSTILE)
def test_a_schema_that_leads_elsewhere_or_on_and_on_is_a_fault_and_nothing_fits_it(schema: dict[str, Any]) -> None:
    assert schema_fault(schema)
    assert "at fault" in parameter_faults(schema, {"a": "a" * 40 + "!"})


def test_judging_by_a_schema_opens_no_file_and_no_connection() -> None:
    parameter_faults(SPEED, {"speed": 1})  # loads what is needed
    received: list[str] = []
    sys.addaudithook(
        lambda name, _: received.append(name) if name in ("open", "urllib.Request", "socket.connect") else None
    )
    for schema in HOSTILE.values():
        parameter_faults(schema, {"a": 1})
    assert received == []


def test_a_pattern_that_takes_for_ever_elsewhere_is_matched_at_once() -> None:
    schema = {"properties": {"a": {"pattern": "^(a+)+$"}}}
    began = time.process_time()
    assert "does not match" in parameter_faults(schema, {"a": "a" * 5_000 + "!"})
    assert parameter_faults(schema, {"a": "a" * 5_000}) == ""
    assert time.process_time() - began < 30  # backtracking would take longer than the universe has been there


def test_an_enormous_answer_is_not_judged() -> None:
    assert str(MOST_PARTS) in parameter_faults({}, {"a": [[] for _ in range(MOST_PARTS)]})


@pytest.mark.parametrize("number", [float("nan"), float("inf"), float("-inf"), 10**400])
def test_a_number_that_no_bound_holds_is_refused_wherever_it_is(number: float) -> None:
    for schema in (SPEED, {}, {"properties": {"speed": {"minimum": 0}}}):
        for given_value in (number, {"deep": [0.5, number]}):
            assert "is no finite number" in parameter_faults(schema, {"speed": given_value})


def test_a_reference_within_the_schema_is_followed() -> None:
    schema = {"$defs": {"s/p~d": SPEED["properties"]}, "properties": {"speed": {"$ref": "#/$defs/s~1p~0d/speed"}}}
    assert schema_fault(schema) == ""
    assert parameter_faults(schema, {"speed": 1}) == ""
    assert "speed" in parameter_faults(schema, {"speed": 3})


def test_parameters_learn_where_they_are_wrong() -> None:
    assert parameter_faults(SPEED, {"speed": 1.5}) == ""
    assert parameter_faults(SPEED, {"speed": "fast"}).startswith("$.speed: 'fast' is not of type 'number'")
    assert "'speed' is a required property" in parameter_faults(SPEED, {})


WORDS = [
    "type",
    "properties",
    "$ref",
    "$defs",
    "allOf",
    "not",
    "items",
    "enum",
    "pattern",
    "multipleOf",
    "maximum",
    "if",
]
LEAVES = st.none() | st.booleans() | st.integers() | st.floats() | st.sampled_from(["#", "#/$defs", "object", "(", "a"])
VALUES = st.recursive(LEAVES, lambda each: st.lists(each, max_size=3) | st.dictionaries(st.sampled_from(WORDS), each))


@given(st.dictionaries(st.sampled_from(WORDS), VALUES), st.dictionaries(st.sampled_from(["a", "b"]), VALUES))
def test_whatever_a_schema_is_judging_by_it_ends_in_words(schema: dict[str, Any], parameters: dict[str, Any]) -> None:
    assert isinstance(parameter_faults(schema, parameters), str)
