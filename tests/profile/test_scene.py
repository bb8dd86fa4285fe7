# SPDX-License-Identifier: Apache-2.0
"""A scene in a file of its own: found from the profile's folder, whatever the working directory, and kept whole."""

from __future__ import annotations

import json
import os
from pathlib import Path

import pytest

from rai_missions.cli.main import main
from rai_missions.profile import dump_profile, load_profile, parse_profile
from rai_missions.worlds import open_world

THINGS = {"objects": [{"type": "red_cube", "pose": {"x": 0.4, "y": 0.1}}]}
NAMES = ("scene.json", "scenes/ä b.json", "../scene.json")
MISSION = {"format": 1, "name": "bare", "initial": "over", "states": {"over": {"final": "aborted"}}}


@pytest.mark.parametrize("name", NAMES)
@pytest.mark.parametrize("here", ["robots", ".", "else where"])
@pytest.mark.parametrize("is_relative", [True, False])
def test_it_is_the_same_from_each_working_directory_and_stays_once_its_file_is_gone(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, name: str, here: str, is_relative: bool
) -> None:
    file, scene = tmp_path / "robots" / "robot.json", tmp_path / "robots" / name
    scene.parent.mkdir(parents=True, exist_ok=True)
    for folder in (file.parent, tmp_path / here):
        folder.mkdir(exist_ok=True)
    scene.write_text(json.dumps(THINGS))
    options = {"kind": "local", "world": "desk", "seed": 1, "camera": False, "scene": name}
    file.write_text(json.dumps({"format": 1, "name": "arm", "connector": options}))
    monkeypatch.chdir(tmp_path / here)
    robot = load_profile(os.path.relpath(file) if is_relative else file)
    scene.unlink()
    assert robot.connector["scene"] == THINGS
    assert parse_profile(dump_profile(robot)) == robot, "as a journal holds it"
    open_world(
        "desk", **{word: given for word, given in robot.connector.items() if word not in ("kind", "world")}
    ).close()


def test_one_that_cannot_be_read_is_named_once_with_its_whole_path(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    options = {"kind": "local", "world": "desk", "scene": "nowhere.json"}
    (tmp_path / "robot.json").write_text(json.dumps({"format": 1, "name": "arm", "connector": options}))
    (tmp_path / "mission.json").write_text(json.dumps(MISSION))
    monkeypatch.chdir(tmp_path)
    assert main(["check", "mission.json", "--robot", "robot.json"]) == 2
    assert capsys.readouterr().err.count(f"'{tmp_path / 'nowhere.json'}' cannot be read") == 1
