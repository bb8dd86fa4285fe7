# SPDX-License-Identifier: Apache-2.0
"""The tractor's launch file, as far as it can be tried without `launch`, which no package index has."""

from __future__ import annotations

import runpy
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import pytest

from rai_missions.cli.commands import load_command
from rai_missions.cli.main import main
from rai_missions.mission.files import load
from rai_missions.node import node_name

FILE = Path(__file__).parents[2] / "missions" / "tractor" / "tractor.launch.py"
NAMES = {
    "launch": ["LaunchDescription"],
    "launch.actions": ["DeclareLaunchArgument", "Shutdown"],
    "launch.conditions": ["IfCondition", "UnlessCondition"],
    "launch.substitutions": ["FindExecutable", "LaunchConfiguration"],
    "launch_ros": [],
    "launch_ros.actions": ["LifecycleNode", "Node"],
    "launch_ros.parameter_descriptions": ["ParameterValue"],
}


class LaunchPart:
    """What was reported to a constructor."""

    def __init__(self, *given: Any, **words: Any) -> None:
        self.given, self.words = given, words


@pytest.fixture
def described(monkeypatch: pytest.MonkeyPatch) -> list[LaunchPart]:
    """The entries of the launch description."""
    for module, names in NAMES.items():
        fake_robot = ModuleType(module)
        vars(fake_robot).update({name: type(name, (LaunchPart,), {}) for name in names})
        monkeypatch.setitem(sys.modules, module, fake_robot)
    description = runpy.run_path(str(FILE))["generate_launch_description"]()
    return list(description.given[0])


def test_the_command_lines_that_it_makes_are_understood(described: list[LaunchPart]) -> None:
    defaults = {each.given[0]: each.words["default_value"] for each in described if "default_value" in each.words}
    nodes = [each for each in described if "arguments" in each.words]
    assert len(nodes) == 2

    def text(part: Any) -> str:
        if isinstance(part, LaunchPart):
            return str(defaults[part.given[0]])
        return "".join(map(text, part)) if isinstance(part, list) else str(part)

    for node in nodes:
        appended = ["--ros-args", "-r", f"__node:={text(node.words['name'])}", "--params-file", "/tmp/launch_params_x"]
        command, *words = map(text, node.words["arguments"])
        given = load_command(command).read([*words, *appended])["options"]
        assert given.managed is (type(node).__name__ == "LifecycleNode")
        assert Path(given.mission).is_file() and Path(given.robot).is_file() and given.set == ()
        ((name, value),) = node.words["parameters"][0].items()
        assert name == "alleys" and value.words == {"value_type": int}, "parameters are the mission's arguments"
        assert name in load(given.mission).blackboard
        assert given.node == "" and node_name("other", ros_arguments=given.ros_args).path == "/tractor_mission"


@pytest.mark.parametrize(
    ("words", "why"),
    [
        (["--node", "1st"], "--node '1st': a node's name has letters, digits and '_', and begins with no digit"),
        (["--managed", "--json"], "--json is of one run; a managed node has many: drop it or --managed"),
        (
            ["--managed", "--resume", "a.journal"],
            "--resume is of one run; a managed node has many: drop it or --managed",
        ),
    ],
)
def test_words_that_do_not_go_together_are_reported_at_once(
    words: list[str], why: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "lamp.json").write_text(
        '{"format": 1, "name": "lamp", "initial": "off", "states": {"off": {"final": "aborted"}}}'
    )
    assert main(["run", "lamp.json", *words]) == 2
    assert why in capsys.readouterr().err and list(tmp_path.iterdir()) == [tmp_path / "lamp.json"]
