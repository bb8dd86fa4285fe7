# SPDX-License-Identifier: Apache-2.0
"""The types of ROS, field by field."""

from __future__ import annotations

from typing import Any

from rai_missions.connectors.connector import TypeKind
from rai_missions.connectors.field_types import field_type
from rai_missions.connectors.ros2.names import EXAMPLE, find_type
from rai_missions.errors import ConnectorError
from rai_missions.redaction import cut_repr

__all__ = ("BYTES", "CODES", "NO_FIELD", "describe_type")

CODES = {
    "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q",
    "float": "f", "double": "d",
}  # fmt: skip
"""Types whose sequences are arrays of the standard library, and the arrays' type codes."""
BYTES = frozenset({"uint8", "octet"})
PARTS: dict[TypeKind, dict[str, str]] = {
    "msg": {},
    "srv": {"request": "Request", "response": "Response"},
    "action": {"goal": "Goal", "result": "Result", "feedback": "Feedback"},
}
DEEPEST = 4
NO_FIELD = "structure_needs_at_least_one_member"
"""What ROS gives a message that has no fields."""


def describe_type(type_name: str) -> dict[str, Any]:
    """The fields of a type, those of the messages in it too: `{"data": "string"}`; a service's by request and response.

    Raises:
        ConnectorError: No such type on this machine.
    """
    middle = type_name.split("/")[1:2]
    kind: TypeKind | None = next((each for each in PARTS if middle == [each]), None)
    if kind is None:
        raise ConnectorError(
            f"{cut_repr(type_name, 80)} is no name of a type; one looks like {', '.join(EXAMPLE.values())}"
        )
    found = find_type(type_name, kind)
    if kind == "msg":
        return _fields(found, 0)
    return {part: _fields(getattr(found, inner), 0) for part, inner in PARTS[kind].items()}


def _fields(cls: Any, depth: int) -> dict[str, Any]:
    types: dict[str, str] = cls.get_fields_and_field_types()
    return {name: _field(each, depth) for name, each in types.items() if name != NO_FIELD}


def _field(type_name: str, depth: int) -> Any:
    """A plain type's name; for a message its fields, for a list of messages what one of them holds."""
    kind = field_type(type_name)
    if "/" not in kind.name or depth >= DEEPEST:
        return type_name
    fields = _fields(find_type(kind.name, "msg"), depth + 1)
    return [fields] if kind.is_list else fields
