# SPDX-License-Identifier: Apache-2.0
"""Which guards are found to follow from others, an example each."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.guards import Guard
from rai_missions.guards.implication import form, implies

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
