# SPDX-License-Identifier: Apache-2.0
"""The launch file, as far as it can be tried without `launch`, which no package index has."""

from __future__ import annotations

import json
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

FILE = Path(__file__).parents[2] / "ros" / "launch" / "mission.launch.py"
TRACTOR = Path(__file__).parents[2] / "missions" / "tractor"
SIGNATURES: dict[str, dict[str, str]] = {
    "launch": {"LaunchContext": "", "LaunchDescription": "entities"},
    "launch.actions": {
        "DeclareLaunchArgument": "name, *, default_value, description",
        "OpaqueFunction": "*, function",
        "Shutdown": "",
    },
    "launch.substitutions": {"LaunchConfiguration": "name"},
    "launch_ros": {},
    "launch_ros.actions": {
        "LifecycleNode": "*, name, namespace, package, executable, arguments, parameters, output",
        "Node": "*, package, executable, name, namespace, arguments, parameters, output, on_exit",
    },
    "launch_ros.parameter_descriptions": {"ParameterValue": "value, *, value_type"},
}
"""What the file uses of `launch` and `launch_ros`, and what their documentation has these take."""


class LaunchPart:
    """What was reported to a constructor; `perform` is that of `LaunchConfiguration`."""

    def __init__(self, **given: Any) -> None:
        self.given = given

    def perform(self, context: dict[str, str]) -> str:
        return context[self.given["name"]]


def part(name: str, takes: str) -> type[LaunchPart]:
    """A class that takes what the documented one does, and nothing else."""
    scope: dict[str, Any] = {}
    exec(f"def __init__(self, {takes}): self.given = {{k: v for k, v in locals().items() if k != 'self'}}", scope)
    return type(name, (LaunchPart,), {"__init__": scope["__init__"]})


@pytest.fixture
def described(monkeypatch: pytest.MonkeyPatch) -> list[Any]:
    """The entries of the launch description."""
    for module, names in SIGNATURES.items():
        made = ModuleType(module)
        vars(made).update({name: part(name, takes) for name, takes in names.items()})
        monkeypatch.setitem(sys.modules, module, made)
    entities: list[Any] = runpy.run_path(str(FILE))["generate_launch_description"]().given["entities"]
    return entities


def started(described: list[Any], **given: str) -> Any:
    """The node that a launch with these arguments starts."""
    *declared, begin = described
    context = {each.given["name"]: each.given["default_value"] for each in declared}
    assert set(given) <= set(context) and context.pop("mission") is None, "only the mission must be given"
    (node,) = begin.given["function"]({**context, **given})
    return node


@pytest.mark.parametrize("managed", ["false", "True"])
def test_the_command_line_that_it_makes_is_understood(described: list[Any], managed: str) -> None:
    mission, robot = str(TRACTOR / "mission.json"), str(TRACTOR / "robot.ros2.json")
    words = {"arguments": '{"alleys": 2}', "options": "--journal 'a b.journal'", "name": "tractor_mission"}
    node = started(described, mission=mission, robot=robot, managed=managed, **words)
    assert type(node).__name__ == ("LifecycleNode" if managed == "True" else "Node")
    assert (node.given["package"], node.given["executable"]) == ("rai_missions", "rai-missions")
    appended = ["--ros-args", "-r", f"__node:={node.given['name']}", "--params-file", "/tmp/launch_params_x"]
    command, *rest = node.given["arguments"]
    given = load_command(command).read([*rest, *appended])["options"]
    assert given.managed is (managed == "True")
    assert (str(given.mission), str(given.robot), given.set) == (mission, robot, ())
    assert str(given.journal) == "a b.journal"
    assert node.given["parameters"] == [{"alleys": 2}] and "alleys" in load(mission).blackboard
    assert given.node == "" and node_name("other", ros_arguments=given.ros_args).path == "/tractor_mission"


def test_what_ros_has_no_type_for_goes_as_json_and_a_file_comes_first(described: list[Any]) -> None:
    arguments = {"target": {"x": 1.0}, "points": [{"x": 2.0}], "n": 3, "lit": True, "word": "3", "none": None}
    node = started(described, mission="m.json", arguments=json.dumps(arguments), params_file="given.yaml")
    file, values = node.given["parameters"]
    assert file == "given.yaml" and (values["n"], values["lit"]) == (3, True)
    texts = {name: value.given for name, value in values.items() if isinstance(value, LaunchPart)}
    assert texts == {
        "target": {"value": '{"x": 1.0}', "value_type": str},
        "points": {"value": '[{"x": 2.0}]', "value_type": str},
        "word": {"value": "3", "value_type": str},
        "none": {"value": "null", "value_type": str},
    }, "a bare text would be read as YAML"
    assert node.given["arguments"] == ["run", "m.json", "--node"]
    assert started(described, mission="m.json").given["parameters"] == []


@pytest.mark.parametrize("arguments", ["alleys: 2", "[2]", ""])
def test_arguments_that_are_no_object_are_refused_with_an_example(described: list[Any], arguments: str) -> None:
    with pytest.raises(ValueError, match=r"is no JSON object; one looks like '\{\"alleys\": 2\}'"):
        started(described, mission="m.json", arguments=arguments)


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
