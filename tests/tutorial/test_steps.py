# SPDX-License-Identifier: Apache-2.0
"""The steps of the tutorial: missions without a fault, robots that bring them to their ends, and what to try."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from rai_missions.agents import run
from rai_missions.check import check
from rai_missions.cli.main import main
from rai_missions.mission.files import load

TUTORIAL = Path(__file__).parents[2] / "docs/tutorial"
STEPS = ("1_mission", "2_regions", "3_tree", "4_decision", "5_proof")
ROBOTS = {step: step for step in STEPS} | {"5_proof": "4_decision"}
"""Step → the one whose robot it runs on."""


@pytest.mark.parametrize("step", STEPS)
def test_a_step_s_mission_has_no_fault_and_its_robot_takes_the_bin_out(step: str, tmp_path: Path) -> None:
    folder = TUTORIAL / step
    assert check(load(folder / "mission.json")) == ()
    robot, journal = TUTORIAL / ROBOTS[step] / "robot.py", tmp_path / "run.journal"
    result = run(folder / "mission.json", robot=robot, speed=math.inf, journal=journal)
    assert (result.outcome, result.open_goals) == ("succeeded", ())
    assert result.decisions == (1 if step >= "4" else 0)


@pytest.mark.parametrize(
    ("step", "was", "now", "outcome"),
    [
        ("1_mission", 'now["bin_out"] = True', "pass", "aborted"),
        ("2_regions", '"battery": 0.9', '"battery": 0.1', "aborted"),
        ("3_tree", 'now["tries"] > 1', 'now["tries"] > 3', "aborted"),
    ],
)
def test_what_a_step_gives_to_try_ends_as_it_states(
    step: str, was: str, now: str, outcome: str, tmp_path: Path
) -> None:
    text = (TUTORIAL / step / "robot.py").read_text(encoding="utf-8")
    assert text.count(was) == 1
    (tmp_path / "robot.py").write_text(text.replace(was, now), encoding="utf-8")
    mission = TUTORIAL / step / "mission.json"
    result = run(mission, robot=tmp_path / "robot.py", speed=math.inf, journal=tmp_path / "run.journal")
    assert result.outcome == outcome


def test_the_tutorial_is_played_at_the_terminal_without_a_file(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    import io
    import sys

    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sys, "stdin", io.StringIO("q\n"))
    assert main(["tutorial", "--terminal"]) == 0
    output = capsys.readouterr().out
    assert "Take the bin from the house to the kerb" in output
    assert list(tmp_path.iterdir()) == []
