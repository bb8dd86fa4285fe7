# SPDX-License-Identifier: Apache-2.0
"""Transitions that need no event follow one another for ever only where their guards can be true together."""

from __future__ import annotations

from typing import Any

import pytest

from rai_missions.check import check
from rai_missions.mission.mission import Mission

Json = dict[str, Any]


def cycles(first: Json, second: Json) -> list[str]:
    """What is found of a lamp that follows what a body does, in another region."""
    inner: Json = {
        "low": {"transitions": [{"on": "go", "to": "high"}]},
        "high": {"transitions": [{"on": "go", "to": "low"}]},
    }
    hand: Json = {"initial": "open", "states": {"open": {"transitions": [{"on": "go", "to": "shut"}]}, "shut": {}}}
    lamp: Json = {
        "white": {"transitions": [{"when": first, "to": "blue"}]},
        "blue": {"transitions": [{"when": second, "to": "white"}]},
    }
    regions: Json = {
        "arm": {"initial": "lifting", "states": {
            "lifting": {"initial": "low", "states": inner, "transitions": [{"on": "stop", "to": "resting"}]},
            "resting": {"transitions": [{"on": "go", "to": "lifting"}]},
        }},
        "hand": hand, "lamp": {"initial": "white", "states": lamp},
    }  # fmt: skip
    mission = Mission.model_validate({
        "name": "lamps", "events": ["go", "stop"], "initial": "both", "states": {"both": {"parallel": regions}},
    })  # fmt: skip
    return [each.rule for each in check(mission) if each.rule.endswith("-cycle")]


@pytest.mark.parametrize(("first", "second"), [
    ({"in": "lifting"}, {"in": "resting"}), ({"in": "low"}, {"in": "resting"}), ({"in": "low"}, {"in": "high"}),
    ({"all": [{"in": "low"}, {"in": "open"}]}, {"in": "high"}),
])  # fmt: skip
def test_guards_over_states_that_exclude_each_other_make_no_cycle(first: Json, second: Json) -> None:
    assert cycles(first, second) == []


@pytest.mark.parametrize(("first", "second"), [
    ({"in": "low"}, {"in": "open"}), ({"in": "low"}, {"in": "lifting"}), ({"in": "low"}, {"not": {"in": "high"}}),
])  # fmt: skip
def test_guards_over_states_that_can_be_active_together_make_a_cycle(first: Json, second: Json) -> None:
    assert cycles(first, second) == ["possible-cycle"]


def test_two_regions_that_each_wait_for_the_other_make_a_cycle() -> None:
    one: Json = {
        "up": {"transitions": [{"when": {"in": "left"}, "to": "down"}]},
        "down": {"transitions": [{"when": {"in": "right"}, "to": "up"}]},
    }
    other: Json = {
        "left": {"transitions": [{"when": {"in": "down"}, "to": "right"}]},
        "right": {"transitions": [{"when": {"in": "up"}, "to": "left"}]},
    }
    regions: Json = {"one": {"initial": "up", "states": one}, "other": {"initial": "left", "states": other}}
    mission = Mission.model_validate({"name": "chase", "initial": "both", "states": {"both": {"parallel": regions}}})
    assert "possible-cycle" in [each.rule for each in check(mission)]
