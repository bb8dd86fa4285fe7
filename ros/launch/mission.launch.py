# SPDX-License-Identifier: Apache-2.0
# mypy: disable-error-code="import-not-found"
"""Starts a mission as a node of ROS 2: `ros2 launch rai_missions mission.launch.py mission:=m.json robot:=r.json`.

With `managed:=true` it waits to be configured and activated, and runs the mission whenever it is asked to. The mission
comes by `mission:=`, its arguments by `arguments:='{"alleys": 2}'` or by `params_file:=`.
"""

from __future__ import annotations

import json
import shlex
from typing import Any

from launch import LaunchContext, LaunchDescription
from launch.actions import DeclareLaunchArgument, OpaqueFunction, Shutdown
from launch.substitutions import LaunchConfiguration
from launch_ros.actions import LifecycleNode, Node
from launch_ros.parameter_descriptions import ParameterValue

TRUE = ("true", "1", "yes", "on")
DECLARED = (
    ("mission", None, "the mission's file"),
    ("robot", "", "the robot profile; without it, the mission runs alone"),
    ("name", "mission", "the node's name"),
    ("namespace", "", "the node's namespace"),
    ("managed", "false", "wait for lifecycle commands, and run the mission repeatedly"),
    ("arguments", "{}", "the mission's arguments as a JSON object"),
    ("params_file", "", "a file of parameters for the node: the mission's arguments in YAML"),
    ("options", "", "more words for `rai-missions run`, such as '--journal /var/log/mission.journal'"),
)
"""Name, default (None: it must be given) and meaning."""


def generate_launch_description() -> LaunchDescription:
    """The mission's node, and what may be said about it."""
    declared = [DeclareLaunchArgument(name, default_value=usual, description=text) for name, usual, text in DECLARED]
    return LaunchDescription([*declared, OpaqueFunction(function=nodes)])


def nodes(context: LaunchContext) -> list[Node]:
    """The node, once the arguments of the launch are known."""
    given = {name: LaunchConfiguration(name).perform(context) for name, _, _ in DECLARED}
    is_managed = given["managed"].lower() in TRUE
    words = ["run", given["mission"], *(["--robot", given["robot"]] if given["robot"] else []), "--node"]
    words += shlex.split(given["options"])
    common = {
        "package": "rai_missions",
        "executable": "rai-missions",
        "name": given["name"],
        "namespace": given["namespace"],
        "parameters": parameters(given["arguments"], given["params_file"]),
        "output": "screen",
    }
    if is_managed:
        return [LifecycleNode(arguments=[*words, "--managed"], **common)]
    return [Node(arguments=words, on_exit=Shutdown(), **common)]  # one run, and it is over


def parameters(arguments: str, params_file: str) -> list[Any]:
    """The parameters of the node: a file, and the mission's arguments, of which those that hold others go as JSON.

    Raises:
        ValueError: The arguments are no JSON object.
    """
    try:
        values = json.loads(arguments)
    except ValueError:
        values = None
    if not isinstance(values, dict):
        raise ValueError(f"arguments: {arguments!r} is no JSON object; one looks like '{{\"alleys\": 2}}'")
    flat = {name: parameter(value) for name, value in values.items()}
    return [*([params_file] if params_file else []), *([flat] if flat else [])]


def parameter(value: Any) -> Any:
    """A value as a parameter; `launch` would read a bare text as YAML, so that '3' is a number and '{}' is refused."""
    if isinstance(value, bool | int | float):
        return value
    return ParameterValue(value if isinstance(value, str) else json.dumps(value), value_type=str)
