# SPDX-License-Identifier: Apache-2.0
"""Which guards are found to follow from others, an example each."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.guards import Guard
from rai_missions.guards.implication import form, implies, never

LOW, ARMED = {"key": "battery", "<": 0.2}, {"key": "armed", "==": True}


@pytest.mark.parametrize(
    ("one", "other", "follows"),
    [
        ({"all": [LOW, ARMED]}, {"all": [ARMED, {"key": "battery", "<": 0.5}]}, True),
        ({"all": [LOW, ARMED]}, {"all": [ARMED, {"key": "battery", "<": 0.1}]}, False),
        ({"any": [LOW, {"key": "battery", "<": 0.1}]}, {"key": "battery", "<": 0.5}, True),
        (LOW, {"any": [ARMED, {"key": "battery", "<": 0.5}]}, True),
        ({"key": "battery", "==": "low"}, {"key": "battery", "<": 0.5}, False),
        ({"key": "n", "in": [1, 2]}, {"key": "n", "in": [True, 2]}, False),
        ({"key": "n", "<": {"key": "m"}}, {"key": "n", "<": {"key": "m"}}, True),
        ({"key": "n", "==": ["a", "b"]}, {"key": "n", "==": "ab"}, False),
    ],
)
def test_a_guard_is_found_to_follow(one: Any, other: Any, follows: bool) -> None:
    assert implies(form(Guard.read(one)), form(Guard.read(other))) is follows


HIGH, SILENT = {"key": "battery", ">": 0.2}, {"not": {"fresh": "battery"}}


@pytest.mark.parametrize(
    ("guard", "excluded"),
    [
        ({"all": [HIGH, {"any": [{"key": "battery", "<=": 0.2}, SILENT]}]}, True),
        ({"all": [HIGH, {"any": [LOW, {"all": [ARMED, SILENT]}]}]}, True),
        ({"all": [{"any": [LOW, SILENT]}, {"any": [HIGH, {"key": "battery", "==": 0.2}]}]}, False),
        ({"all": [HIGH, {"any": [{"key": "battery", "<=": 0.3}, SILENT]}]}, False),
        ({"all": [{"possible": HIGH}, {"any": [LOW, SILENT]}]}, False),
        ({"all": [ARMED, {"any": [LOW, SILENT]}]}, False),
        ({"all": [HIGH, ARMED, {"any": [{"all": [LOW, ARMED]}, {"key": "armed", "==": False}]}]}, True),
    ],
)
def test_conditions_that_leave_no_alternative_are_never_true(guard: Any, excluded: bool) -> None:
    assert never(form(Guard.read(guard))) is excluded
