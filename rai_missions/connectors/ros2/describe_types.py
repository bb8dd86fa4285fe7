# SPDX-License-Identifier: Apache-2.0
"""What the types of ROS hold, told field by field; works wherever their packages are installed."""

from __future__ import annotations

from typing import Any

from rai_missions.connectors.ros2.names import EXAMPLE, Kind, find_type
from rai_missions.errors import ConnectorError
from rai_missions.redaction.cut import cut_repr

__all__ = ("describe_type",)

PARTS: dict[Kind, dict[str, str]] = {
    "msg": {},
    "srv": {"request": "Request", "response": "Response"},
    "action": {"goal": "Goal", "result": "Result", "feedback": "Feedback"},
}
DEEPEST = 4
NO_FIELD = "structure_needs_at_least_one_member"


def describe_type(type_name: str) -> dict[str, Any]:
    """The fields of a type, those of the messages in it too: `{"data": "string"}`; a service's by request and response.

    Raises:
        ConnectorError: No such type on this machine.
    """
    middle = type_name.split("/")[1:2]
    kind: Kind | None = next((each for each in PARTS if middle == [each]), None)
    if kind is None:
        raise ConnectorError(
            f"{cut_repr(type_name, 80)} is no name of a type; one looks like {', '.join(EXAMPLE.values())}"
        )
    found = find_type(type_name, kind)
    if kind == "msg":
        return _fields(found, 0)
    return {part: _fields(getattr(found, inner), 0) for part, inner in PARTS[kind].items()}


def _fields(cls: Any, depth: int) -> dict[str, Any]:
    said: dict[str, str] = cls.get_fields_and_field_types()
    return {name: _field(each, depth) for name, each in said.items() if name != NO_FIELD}


def _field(said: str, depth: int) -> Any:
    """A plain type's name; for a message its fields, for a list of messages what one of them holds."""
    inner = said.removeprefix("sequence<").partition(">")[0].partition(",")[0].partition("[")[0]
    if "/" not in inner or depth >= DEEPEST:
        return said
    package, _, name = inner.partition("/")
    fields = _fields(find_type(f"{package}/msg/{name.rpartition('/')[2]}", "msg"), depth + 1)
    return fields if inner == said else [fields]
