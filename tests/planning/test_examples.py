# SPDX-License-Identifier: Apache-2.0
"""Examples that a proof takes for all plans and readings: what is known of a real one is so in one of them."""

from __future__ import annotations

import random
from collections.abc import Mapping
from typing import Any

from hypothesis import given
from hypothesis import strategies as st

from rai_missions.planning import place_for_the_hand, plan_data, planned
from rai_missions.planning.examples import PLANS, READINGS
from rai_missions.planning.reading import reading_data, reading_of
from rai_missions.planning.scene import Scene
from tests.planning.drawn import any_goal, arrangement, names_for
from tests.planning.reading.stored import SCENES
from tests.planning.reading.test_laws import REQUESTS, STORED


def known(value: Any) -> Any:
    """The fields that are known, at each depth but in a goal."""
    if not isinstance(value, Mapping):
        return True
    return {name: name == "goal" or known(each) for name, each in value.items() if each is not None}


@given(st.integers(0, 2**32), st.integers(1, 6), st.booleans())
def test_what_is_known_of_a_plan_is_so_in_an_example(seed: int, count: int, is_holding: bool) -> None:
    rng = random.Random(seed)
    names = names_for(rng, count)
    seen = Scene(arrangement(rng, names).things, gripper="holding" if is_holding else "empty")
    plan = plan_data(planned(any_goal(rng, names), seen), (), place_for_the_hand(seen))
    assert known(plan) in [known(each) for each in PLANS["failed" if plan["reason"] else "succeeded"]]


@given(st.one_of(REQUESTS, st.sampled_from(STORED).map(lambda each: each.text)), st.sampled_from(sorted(SCENES)))
def test_what_is_known_of_a_reading_is_so_in_an_example(request: str, seen: str) -> None:
    reading = reading_data(reading_of(request, SCENES[seen]))
    outcome = "succeeded" if reading["goal"] is not None else "unclear" if reading["question"] else "refused"
    assert known(reading) in [known(each) for each in READINGS[outcome]]
