# SPDX-License-Identifier: Apache-2.0
"""Faults that do not depend on each other are reported together: as many words are wrong, so many places are named."""

from __future__ import annotations

from collections.abc import Mapping
from itertools import combinations
from typing import Any

import pytest

from rai_missions import DefinitionError
from rai_missions.keys import Key
from rai_missions.model.validation_errors import validated
from rai_missions.profile import Robot
from rai_missions.states.decision import DecisionSpec

Words = Mapping[str, Any]
KEY = (
    {"type": "string"},
    [{"initial": 5}, {"frame": "map"}, {"fields": {"a": "number"}}, {"minimum": 1}, {"maximum": 9}, {"enum": ["a"]}],
)
ASKED = {"question": "?", "options": {"go": {}, "wait": {}}, "fallback": "go"}
DECISION = ASKED, [{"fallback": "walk"}, {"options": {"go": {}, "failed": {}, "canceled": {}}}]
TOUCHED = {"connector": {"kind": "local"}, "format": 1, "name": "rob"}


def places(model: type[Any], data: Words) -> list[str]:
    """Where a document of a model is at fault."""
    with pytest.raises(DefinitionError) as raised:
        validated(model, data)
    return sorted(fault.place for fault in raised.value.faults)


@pytest.mark.parametrize(("model", "given"), [(Key, KEY), (DecisionSpec, DECISION)], ids=["key", "decision"])
def test_words_that_are_wrong_alone_are_all_reported_together(
    model: type[Any], given: tuple[Words, list[Words]]
) -> None:
    base, wrong = given
    alone = [places(model, {**base, **each}) for each in wrong]
    for count in range(2, len(wrong) + 1):
        for chosen in combinations(range(len(wrong)), count):
            both = {word: value for number in chosen for word, value in wrong[number].items()}
            assert places(model, {**base, **both}) == sorted(place for number in chosen for place in alone[number])


def test_each_pattern_that_fits_no_name_is_reported() -> None:
    looks = {"read": ["odom", "/scan", ""], "never": ["cmd_vel"]}
    assert places(Robot, {**TOUCHED, "tools": looks}) == ["/tools/never/0", "/tools/read/0", "/tools/read/2"]


def test_a_constructor_in_python_reports_all_as_well() -> None:
    with pytest.raises(DefinitionError) as raised:
        Key("string", initial=5, frame="map")
    assert [fault.place for fault in raised.value.faults] == ["/frame", "/initial"]
