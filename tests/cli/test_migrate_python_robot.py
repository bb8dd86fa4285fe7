# SPDX-License-Identifier: Apache-2.0
"""A run on a robot in Python that was killed resumes in a mission that has changed since."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

from rai_missions.cli.main import main
from rai_missions.journal import read
from rai_missions.replay.replay import replay

ROBOT = """
from rai_missions import PythonRobot

def robot():
    made, here = PythonRobot("turtle"), {"x": 0.0}
    made.fact("x", every_s=0.2)(lambda: here["x"])

    @made.action("drive", repeat=True)
    async def drive(goal, run):
        await run.sleep(1000 if goal["long"] else 1)
        here["x"] = 1.0

    return made
"""


def trip(version: str, state: str, *, long: bool, action: str = "drive") -> dict[str, Any]:
    ways = [{"on": "succeeded", "to": "done"}, {"on": ["failed", "rejected", "timed_out", "unverified"], "to": "lost"}]
    return {
        "format": 1, "name": "trip", "version": version, "initial": state,
        "blackboard": {"x": {"type": "number", "source": "robot", "max_age_s": 5}},
        "states": {
            state: {"action": action, "goal": {"long": long}, "timeout_s": 2000, "achieved": {"key": "x", ">=": 1},
                    "transitions": ways},
            "done": {"final": "succeeded", "requires": {"key": "x", ">=": 1}},
            "lost": {"final": "failed"},
        },
    }  # fmt: skip


@pytest.fixture(scope="module")
def killed(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a run that was killed while its action was under way."""
    here = tmp_path_factory.mktemp("trip")
    (here / "robot.py").write_text(ROBOT)
    (here / "one.json").write_text(json.dumps(trip("1.0.0", "driving", long=True)))
    (here / "map.json").write_text(json.dumps({"format": 1, "states": {"driving": "going"}}))
    command = [sys.executable, "-m", "rai_missions.cli.main", "run", "one.json", "--robot", "robot.py"]
    with subprocess.Popen(
        [*command, "--journal", "j.journal"], cwd=here, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, text=True
    ) as running:
        assert running.stdout is not None
        assert any("start drive" in line for line in running.stdout)
        running.kill()
    return here


def resume(here: Path, mission: dict[str, Any], *, to: str) -> int:
    (here / "two.json").write_text(json.dumps(mission))
    names = ["--robot", "robot.py", "--resume", "j.journal", "--migrate", "map.json", "--journal", to]
    return main(["run", "two.json", *names, "--speed", "max", "--no-operator"])


def test_a_robot_that_has_changed_is_refused_before_a_journal_is_written(
    killed: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(killed)
    (killed / "robot.py").write_text(f"{ROBOT}\n# changed\n")
    assert resume(killed, trip("2.0.0", "going", long=False), to="other.journal") == 2
    assert "the run's robot was another file, or has changed since" in capsys.readouterr().err
    assert not (killed / "other.journal").exists()
    (killed / "robot.py").write_text(ROBOT)


def test_an_action_that_the_robot_lacks_is_named_before_a_journal_is_written(
    killed: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(killed)
    assert resume(killed, trip("2.0.0", "going", long=False, action="fly"), to="third.journal") == 2
    assert "/actions/fly: missing" in capsys.readouterr().err
    assert not (killed / "third.journal").exists()


def test_it_resumes_in_the_new_mission_and_its_action_starts_again(
    killed: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(killed)
    assert resume(killed, trip("2.0.0", "going", long=False), to="new.journal") == 0
    with read("new.journal") as record:
        assert json.loads(record.header.mission)["version"] == "2.0.0"
    assert replay("new.journal").holds
