# SPDX-License-Identifier: Apache-2.0
"""Missions are equal where they are written alike: 1, 1.0 and true are three values."""

from __future__ import annotations

import json
from types import MappingProxyType
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions import dump
from rai_missions.mission.json_reader import parse_json
from rai_missions.mission.mission import Mission
from rai_missions.model import alike
from visualize import difference

SIMILAR = [0, 0.0, False, 1, 1.0, True, "1", [1], [True], {"x": 1}, {"x": 1.0}]


def mission(value: Any) -> Mission:
    return Mission.model_validate(
        {
            "name": "m",
            "blackboard": {"o": {"type": "object", "initial": {"x": value}}},
            "initial": "a",
            "states": {"a": {"action": "go", "goal": {"speed": value}, "timeout_s": 5}},
        }
    )


@pytest.mark.parametrize("one", SIMILAR, ids=json.dumps)
@pytest.mark.parametrize("other", SIMILAR, ids=json.dumps)
def test_missions_are_equal_where_their_values_are_written_alike(one: Any, other: Any) -> None:
    are_alike = json.dumps(one) == json.dumps(other)
    assert (mission(one) == mission(other)) is are_alike
    assert difference(mission(one), mission(other)).empty is are_alike


numbers = st.one_of(
    st.booleans(), st.integers(-2, 2), st.floats(-2, 2).filter(lambda value: value or str(value) == "0.0")
)
values = st.recursive(
    st.one_of(numbers, st.text(max_size=2)),
    lambda inner: st.one_of(st.lists(inner, max_size=3), st.dictionaries(st.sampled_from("ab"), inner)),
    max_leaves=5,
)


@given(values, values)
def test_values_are_alike_where_their_json_is_the_same(one: Any, other: Any) -> None:
    assert alike(one, other) is (json.dumps(one, sort_keys=True) == json.dumps(other, sort_keys=True))


def read_only(value: Any) -> Any:
    """The same with a read-only view in place of each object."""
    if isinstance(value, list):
        return [*map(read_only, value)]
    return MappingProxyType({k: read_only(each) for k, each in value.items()}) if isinstance(value, dict) else value


@pytest.mark.parametrize("one", SIMILAR, ids=json.dumps)
@pytest.mark.parametrize("other", SIMILAR, ids=json.dumps)
def test_a_mapping_of_any_kind_is_an_object(one: Any, other: Any) -> None:
    assert alike({"x": one}, read_only({"x": other})) is alike({"x": one}, {"x": other})


@given(values)
def test_what_is_dumped_and_loaded_is_the_same_mission_to_the_digit(value: Any) -> None:
    written = mission(value)
    assert Mission.model_validate(written.model_dump()) == written
    assert Mission.model_validate_json(written.model_dump_json()) == written
    again = Mission.model_validate(parse_json(dump(written).encode()))
    assert again == written and alike(again.state("a").written()["goal"], {"speed": value})
