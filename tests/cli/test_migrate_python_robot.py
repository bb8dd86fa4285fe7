# SPDX-License-Identifier: Apache-2.0
"""A run on a robot in Python that was killed resumes in a mission that has changed since."""

from __future__ import annotations

import json
import shutil
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
def first(tmp_path_factory: pytest.TempPathFactory) -> Path:
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


@pytest.fixture
def killed(first: Path, tmp_path: Path) -> Path:
    """A copy of it."""
    return shutil.copytree(first, tmp_path / "trip")


def resume(here: Path, mission: dict[str, Any], *, to: str, robot: str = "robot.py", map_: str = "map.json") -> int:
    (here / "two.json").write_text(json.dumps(mission))
    names = [*(["--robot", robot] if robot else []), "--resume", "j.journal", "--migrate", map_, "--journal", to]
    return main(["run", "two.json", *names, "--speed", "max", "--no-operator"])


def test_a_robot_that_is_not_named_is_demanded_before_a_journal_is_written(
    killed: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(killed)
    assert resume(killed, trip("2.0.0", "going", long=False), to="other.journal", robot="") == 2
    assert "give its file as it is now: --robot 'robot.py'" in capsys.readouterr().err
    assert not (killed / "other.journal").exists()


@pytest.mark.parametrize(
    ("changed", "fault"),
    [
        (ROBOT.replace("repeat=True", "repeat=False"), "/actions/drive: a goal of it is under way"),
        (ROBOT.replace('made.fact("x", every_s=0.2)', ""), 'write `@robot.fact("x")`'),
    ],
)
def test_a_robot_that_has_changed_in_what_the_run_needs_is_refused_before_a_journal_is_written(
    changed: str, fault: str, killed: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(killed)
    (killed / "changed.py").write_text(changed)
    assert resume(killed, trip("2.0.0", "going", long=False), to="other.journal", robot="changed.py") == 2
    assert fault in capsys.readouterr().err
    assert not (killed / "other.journal").exists()


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


def test_a_key_is_renamed_in_the_mission_and_in_the_robot_at_once(
    killed: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(killed)
    marks = "\nprint('loaded')\n"
    (killed / "moved.py").write_text(ROBOT.replace('fact("x"', 'fact("metres"') + marks)
    (killed / "moved.json").write_text(
        json.dumps({"format": 1, "states": {"driving": "going"}, "keys": {"x": "metres"}})
    )
    mission = json.loads(json.dumps(trip("2.0.0", "going", long=False)).replace('"x"', '"metres"'))
    assert resume(killed, mission, to="new.journal", robot="moved.py", map_="moved.json") == 0
    assert capsys.readouterr().out.count("loaded") == 1
    assert replay("new.journal").holds
