# SPDX-License-Identifier: Apache-2.0
"""The examples by which the format is explained, completed: they pass the check, run, and are drawn.

The mission is `data/tractor_design`, in JSON and in Python; `examples/` holds a profile of the simulated tractor.
"""

from __future__ import annotations

from pathlib import Path

import pytest

import visualize
from rai_missions import Chart, Event, dump, journal, load
from rai_missions.agents import run
from rai_missions.check import check
from rai_missions.engine.trees import CompiledTrees
from rai_missions.profile import load_profile, missing

EXAMPLES = Path(__file__).parent / "examples"
DATA = Path(__file__).parents[1] / "data"
BRANCH = {"kind": "branch", "distance_m": 3.0, "height_m": 0.1, "living": False}
PERSON = {"kind": "person", "distance_m": 3.0, "height_m": 1.7, "living": True}


@pytest.fixture(params=["tractor_design.json", "tractor_design.py"])
def example(request: pytest.FixtureRequest) -> Path:
    return DATA / str(request.param)


def test_the_twins_are_one_mission(tmp_path: Path) -> None:
    mission = load(DATA / "tractor_design.json")
    assert load(DATA / "tractor_design.py") == mission
    dump(mission, tmp_path / "again.json")
    assert load(tmp_path / "again.json") == mission


def test_the_mission_passes_the_check_and_the_profile_covers_it(example: Path) -> None:
    mission = load(example)
    assert {finding.rule for finding in check(mission)} == {"unhandled-failure"}  # it lets failures end it
    assert missing(mission, load_profile(EXAMPLES / "robot.json")) == ()


def driving(example: Path) -> Chart:
    """The chart on its way through the alleys, with autonomy in control."""
    chart = Chart(load(example), ticker=CompiledTrees())
    for key, value in {"alleys_driven": 0, "at_home": True, "battery": 0.8}.items():
        chart.write(key, value, at=0.0)
    chart.start(at=0.0)
    chart.send(Event("autonomy", 0.1, {}, "control"))
    assert "driving" in chart.active
    return chart


def test_an_anomaly_asks_and_only_an_offered_option_moves_the_mission(example: Path) -> None:
    chart = driving(example)
    chart.write("obstacle", PERSON, at=3.1, stamp=3.0)
    chart.send(Event("anomaly", 3.2, {}))
    question = chart.send(Event("agent", 3.3, {}, "control")).question
    assert question is not None
    assert [option.name for option in question.options] == ["replan", "signal", "abort"]

    refused = chart.propose(question.number, "drive_over", at=3.4)
    assert refused.verdict is not None and not refused.verdict.accepted
    assert refused.verdict.why == "'drive_over' was not offered; offered: replan, signal, abort"
    assert "assessing" in chart.active and refused.question is not None

    accepted = chart.propose(refused.question.number, "replan", at=3.5)
    assert accepted.verdict is not None and accepted.verdict.accepted
    assert (accepted.mode, accepted.holder, accepted.entered) == ("running", "agent", ("replanning",))


def test_a_snapshot_continues_as_the_chart_itself(example: Path) -> None:
    chart = driving(example)
    chart.send(Event("anomaly", 3.2, {}))
    other = Chart.restore(load(example), chart.snapshot(), ticker=CompiledTrees())
    acknowledged = Event("agent", 3.3, {}, "control")
    assert chart.send(acknowledged) == other.send(acknowledged)
    assert chart.active == other.active


@pytest.mark.long
def test_it_runs_in_the_simulated_orchard_and_is_drawn(tmp_path: Path) -> None:
    mission, path = load(DATA / "tractor_design.json"), tmp_path / "run.journal"
    result = run(mission, EXAMPLES / "robot.json", arguments={"alleys": 1}, journal=path)
    assert result.outcome == "succeeded", result.why
    with journal.read(path) as record:
        steps = list(record.steps())
    for ending in ("svg", "mmd", "md", "dot"):
        visualize.draw(mission, tmp_path / f"path.{ending}", steps)
        assert (tmp_path / f"path.{ending}").stat().st_size > 0
