# SPDX-License-Identifier: Apache-2.0
"""A play as a pytest: green as it is written, for any play, and red once the mission does something else."""

from __future__ import annotations

import ast
import json
import os
import random
import runpy
import subprocess
import sys
from pathlib import Path

import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st

from rai_missions.cli.play.session import PlaySession
from rai_missions.errors import UsageError
from rai_missions.mission.files import dump, load
from rai_missions.mission.mission import Mission
from rai_missions.replay.play import Play, PlaySource, written_test
from rai_missions.states import Final
from tests.strategies import missions

ROOT = Path(__file__).parents[3]


def run(path: Path) -> None:
    """Call the one test of a file."""
    found = [each for name, each in runpy.run_path(str(path)).items() if name.startswith("test_")]
    assert len(found) == 1
    found[0]()


def tractor(*names: str) -> Play:
    play = Play(load(ROOT / "missions/tractor/mission.json"))
    for name in names:
        play.do(name)
    return play


@settings(suppress_health_check=list(HealthCheck), max_examples=2)
@given(mission=missions(), seed=st.integers(0, 10_000))
def test_what_is_written_of_a_play_holds(mission: Mission, seed: int, tmp_path_factory: pytest.TempPathFactory) -> None:
    folder, chance, play = tmp_path_factory.mktemp("play"), random.Random(seed), Play(mission)
    for _ in range(8):
        choices = play.choices()
        begins = [choice for choice in choices if choice.kind == "start"]
        if choices:
            play.do((begins or [chance.choice(choices)])[0].name)
    dump(mission, folder / "m.json")
    test = folder / "tests" / "test_play.py"
    test.parent.mkdir()
    test.write_text(written_test(play, PlaySource(folder / "m.json"), test), encoding="utf-8")
    run(test)


def test_a_slash_in_a_missions_name_is_no_part_of_a_function_or_a_file(tmp_path: Path) -> None:
    mission = Mission("farm/lamp", initial="off", states={"off": Final("aborted")})
    dump(mission, tmp_path / "lamp.json")
    play = Play(mission)
    play.do("start")
    test = tmp_path / "test_lamp.py"
    test.write_text(written_test(play, PlaySource(tmp_path / "lamp.json"), test), encoding="utf-8")
    run(test)
    assert PlaySession(mission).journal == Path("farm_lamp.played.journal")


def test_a_written_test_is_run_by_pytest_and_fails_once_the_mission_has_changed(tmp_path: Path) -> None:
    document = json.loads((ROOT / "missions/tractor/mission.json").read_text(encoding="utf-8"))
    mission, test = tmp_path / "mission.json", tmp_path / "test_play.py"
    mission.write_text(json.dumps(document), encoding="utf-8")
    play = Play(load(mission))
    for name in ("readings", "start", "event anomaly", "control agent", "time"):
        play.do(name)
    play.do("key obstacle", {"obstacle.kind": "branch", "obstacle.height_m": 0.1})
    play.do(next(choice.name for choice in play.choices() if choice.name.endswith(" abort")))
    assert play.chart.outcome == "aborted"
    text = written_test(play, PlaySource(mission), test)
    test.write_text(text, encoding="utf-8")
    assert "def test_tractor_orchard_aborted() -> None:" in text
    assert 'chart.propose(2, "abort", at=1.0)' in text
    assert 'assert chart.outcome == "aborted"' in text
    assert max(map(len, text.splitlines())) <= 120
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", str(test)],
        cwd=tmp_path,
        capture_output=True,
        text=True,
        check=False,
        env={**os.environ, "PYTEST_DISABLE_PLUGIN_AUTOLOAD": "1"},
    )
    assert (done.returncode, "1 passed" in done.stdout) == (0, True), done.stdout
    document["states"]["assessing"]["transitions"] = [
        {**each, "to": "stopped"} if each["on"] == "abort" else each
        for each in document["states"]["assessing"]["transitions"]
    ]
    mission.write_text(json.dumps(document), encoding="utf-8")
    with pytest.raises(AssertionError):
        run(test)


def test_nothing_of_a_value_or_a_name_is_code(tmp_path: Path) -> None:
    document = {
        "format": 1, "name": "m", "initial": "a", "events": {"e": {"fields": {"x": "string"}}},
        "states": {"a": {"transitions": [{"on": "e", "to": "b"}]}, "b": {"final": "succeeded"}},
        "blackboard": {"k": {"type": "string", "source": "robot", "optional": True}},
    }  # fmt: skip
    hostile = '"""\n\'); import os; os.abort() # \u2028\u202e\\'
    play = Play(Mission.model_validate(document))
    play.do("start")
    play.do("key k", {"k": hostile})
    play.do("event e", {"x": hostile})
    text = written_test(play, PlaySource(tmp_path / 'm"\n.json'), tmp_path / "test_m.py")
    names = {node.id for node in ast.walk(ast.parse(text)) if isinstance(node, ast.Name)}
    assert names == {"MISSION", "Path", "__file__", "chart", "Chart", "load", "Event"}
    assert "\u202e" not in text
    assert sum(isinstance(node, ast.Import) for node in ast.walk(ast.parse(text))) == 0


def test_there_is_no_test_of_nothing(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="nothing has been played yet"):
        written_test(tractor(), PlaySource(tmp_path / "m.json"), tmp_path / "test_m.py")
