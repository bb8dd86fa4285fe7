# SPDX-License-Identifier: Apache-2.0
"""What must stay true of the mission; `python -m pytest` runs it."""

from __future__ import annotations

import math
from pathlib import Path

from rai_missions import Chart, Event, load
from rai_missions.agents import run
from rai_missions.check import check

HERE = Path(__file__).parent
MISSION = load(HERE / "mission.json")


def test_the_mission_has_no_fault() -> None:
    assert [str(finding) for finding in check(MISSION)] == []


def test_it_succeeds_on_the_simulated_robot() -> None:
    result = run(MISSION, robot=HERE / "robot.py", speed=math.inf)
    assert result.outcome == "succeeded", result.why


def test_a_hand_in_the_cell_stops_the_arm() -> None:
    """A chart moves by what it is given alone: any situation can be tried without a robot."""
    chart = Chart(MISSION)
    chart.start(at=0.0)  # starts the goal with the number 1
    chart.send(Event("pick", 0.1, {}, "accepted", 1))
    step = chart.send(Event("hand_in_cell", at=0.2))
    assert chart.active == {"standing_still"}
    assert [type(effect).__name__ for effect in step.effects] == ["CancelGoal"]
