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


def test_it_does_not_pass_what_lives() -> None:
    """A chart moves by what it is given alone: any situation can be tried without a robot."""
    chart = Chart(MISSION)
    chart.write("battery", 0.9, at=0.0)
    chart.start(at=0.0)
    chart.write("obstacle", {"kind": "dog", "living": True, "gap_m": 2.0}, at=1.0)
    question = chart.send(Event("blocked", at=1.0)).question
    assert question is not None
    assert [option.name for option in question.options] == ["wait", "turn_back"]

    step = chart.propose(question.number, "go_around", at=1.1)  # a model that wants to pass it
    assert step.verdict is not None
    assert not step.verdict.accepted
    assert "assessing" in chart.active
