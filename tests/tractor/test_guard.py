# SPDX-License-Identifier: Apache-2.0
"""The guard of `drive_over` over what a noisy detector reports: what is not to be driven over does not pass it."""

from __future__ import annotations

import random
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from rai_missions.engine import Chart
from rai_missions.event import Event
from rai_missions.mission.files import load
from rai_missions.worlds.orchard.detector import FLOOR_M, ObstacleLooks

MISSION = load(Path(__file__).parents[2] / "missions" / "tractor" / "mission.json")
FACTS = {"alleys_driven": 0, "at_home": False, "autonomy_state": "STOPPED", "battery": 0.9, "touched_living": False}


def is_offered(**obstacle: Any) -> bool:
    chart = Chart(MISSION)
    for key, value in {**FACTS, "obstacle": {"distance_m": 3.0, "height_m": 0.1, "living": False, **obstacle}}.items():
        chart.write(key, value, 0.0)
    chart.start(0.0)
    chart.send(Event("anomaly", 0.1))
    chart.send(Event("agent", 0.1, {}, "control"))
    return "drive_over" in {offer.name for offer in chart.questions[0].options}


@pytest.mark.parametrize(
    ("obstacle", "offered"),
    [
        ({"kind": "branch", "solid_max_m": 0.18, "sure": 0.9}, True),
        ({"kind": "branch", "solid_max_m": 0.18, "sure": 0.6}, False),
        ({"kind": "branch", "solid_max_m": 0.25, "sure": 0.9}, False),
        ({"kind": "hose", "solid_max_m": 0.06, "sure": 0.9}, False),
        ({"kind": "tall_grass", "solid_max_m": 0.02, "sure": 0.0}, True),
        ({"kind": "tall_grass", "solid_max_m": 0.2, "sure": 0.9}, False),
        ({"kind": "cat", "solid_max_m": 0.0, "sure": 0.9, "living": True}, False),
        ({"kind": "branch"}, False),
    ],
)
def test_the_guard_reads_the_bound_and_how_sure_the_detector_is(obstacle: dict[str, Any], offered: bool) -> None:
    assert is_offered(**obstacle) is offered


@settings(max_examples=25, deadline=None)
@given(st.floats(0.3, 1.0), st.floats(0.0, 0.25), st.integers(1, 40), st.integers(0, 2**32))
def test_what_is_truly_too_high_does_not_pass_however_the_looks_turn_out(
    height: float, noise: float, looks: int, seed: int
) -> None:
    rng, seen = random.Random(seed), ObstacleLooks("log")
    seen.kinds["log"] = looks
    seen.solid_m = [height * (1 + rng.gauss(0, noise)) + rng.gauss(0, FLOOR_M) for _ in range(looks)]
    fact = {"kind": seen.kind, "solid_max_m": min(seen.solid_max_m(noise), 9.999), "sure": seen.sure}
    assert not is_offered(**fact)
