# SPDX-License-Identifier: Apache-2.0
"""What must stay true of the mission; `python -m pytest` runs it."""

from __future__ import annotations

import math
from pathlib import Path

from rai_missions import Chart, Event, Tick, load
from rai_missions.agents import run
from rai_missions.check import check

HERE = Path(__file__).parent
MISSION = load(HERE / "mission.py")


def test_the_mission_has_no_fault() -> None:
    assert [str(finding) for finding in check(MISSION)] == []


def test_it_succeeds_on_the_simulated_robot() -> None:
    result = run(MISSION, robot=HERE / "robot.py", speed=math.inf)
    assert result.outcome == "succeeded", result.why


def test_a_wet_bed_gets_no_water() -> None:
    """A chart moves by what it is given alone: any situation can be tried without a robot."""
    chart = Chart(MISSION)
    chart.start(at=0.0)  # starts the goal with the number 1
    chart.send(Event("go_to", 0.1, {}, "accepted", 1))
    chart.write("at", "herbs", at=0.9)
    chart.write("moisture", 0.8, at=0.9)
    chart.send(Event("succeeded", 1.0, {}, "result", 1))
    assert "measuring" in chart.active
    step = chart.send(Tick(1.6))
    assert "pouring" not in step.entered
    assert "going" in chart.active  # to the next bed
