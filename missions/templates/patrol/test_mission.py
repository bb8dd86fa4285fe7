# SPDX-License-Identifier: Apache-2.0
"""What must stay true of the mission; `python -m pytest` runs it."""

from __future__ import annotations

import math
from pathlib import Path

from rai_missions import Chart, load
from rai_missions.agents import run
from rai_missions.check import check

HERE = Path(__file__).parent
MISSION = load(HERE / "mission.json")


def test_the_mission_has_no_fault() -> None:
    assert [str(finding) for finding in check(MISSION)] == []


def test_it_succeeds_on_the_simulated_robot() -> None:
    result = run(MISSION, robot=HERE / "robot.py", speed=math.inf)
    assert result.outcome == "succeeded", result.why


def test_a_low_battery_leads_home() -> None:
    """A chart moves by what it is given alone: any situation can be tried without a robot."""
    chart = Chart(MISSION)
    chart.write("battery", 0.8, at=0.0)
    chart.start(at=0.0)
    assert "going" in chart.active
    chart.write("battery", 0.1, at=1.0)
    assert chart.active == {"docking"}
