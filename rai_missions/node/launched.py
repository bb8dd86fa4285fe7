# SPDX-License-Identifier: Apache-2.0
"""The parameters that a launch file, or `--ros-args -p`, gives the node: they are the mission's arguments.

Rule: none is dropped without a word; what is no argument of the mission is refused.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.connectors.connector import Connector, SupportsParameters
from rai_missions.errors import UsageError
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import json_value
from rai_missions.profile import plain
from rai_missions.runtime.arguments import not_taken

__all__ = ("arguments_of", "parameters_of")


def parameters_of(connector: Connector) -> Mapping[str, Any]:
    """What the connector's node was given; nothing where it takes no parameters. The connector is started."""
    inside: object = connector
    return inside.parameters() if isinstance(inside, SupportsParameters) else {}


def arguments_of(parameters: Mapping[str, Any], mission: Mission, given: Mapping[str, Any]) -> dict[str, Any]:
    """The mission's arguments among parameters; `target.x` is the field `x` of `target`.

    Args:
        parameters: By name; JSON text is what ROS has no type for.
        mission: Whose arguments they are.
        given: Arguments that were given in another way.

    Raises:
        UsageError: A parameter that the mission does not take, or that was given in another way too.
    """
    takes = mission.keys_of("argument")
    arguments: dict[str, Any] = {}
    for path, value in parameters.items():
        name, _, field = path.partition(".")
        if name not in takes:
            raise UsageError(f"parameter '{path}': {not_taken(mission, name)}")
        if name in given:
            raise UsageError(f"parameter '{path}': '{name}' is given by --set as well; keep one")
        arguments[name] = _merged(
            arguments.get(name), field, _value(plain(value), is_text=takes[name].type == "string")
        )
    return arguments


def _value(value: Any, *, is_text: bool) -> Any:
    """JSON text is the value that it holds, where no text is wanted."""
    return value if is_text or not isinstance(value, str) else json_value(value, value)


def _merged(before: Any, field: str, value: Any) -> Any:
    if not field:
        return value
    merged = dict(before) if isinstance(before, Mapping) else {}
    name, _, rest = field.partition(".")
    merged[name] = _merged(merged.get(name), rest, value)
    return merged
