# SPDX-License-Identifier: Apache-2.0
"""The types of ROS, field by field: one field (`sequence<geometry_msgs/Point, 4>`) and a whole message type."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache
from typing import Any

from rai_missions.connectors.connector import TypeKind
from rai_missions.connectors.ros2.names import EXAMPLE, find_type
from rai_missions.errors import ConnectorError
from rai_missions.redaction import cut_repr

__all__ = ("BYTES", "CODES", "INTEGERS", "NO_FIELD", "FieldType", "describe_type", "field_type")

INTEGERS = {
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
}
"""Integer type → the least and the greatest of its values."""
CODES = {
    "int8": "b", "uint8": "B", "int16": "h", "uint16": "H", "int32": "i", "uint32": "I", "int64": "q", "uint64": "Q",
    "float": "f", "double": "d",
}  # fmt: skip
"""Types whose sequences are arrays of the standard library, and the arrays' type codes."""
BYTES = frozenset({"uint8", "octet"})
SHAPE = re.compile(r"^(?:sequence<(?P<item>.+?)(?:, (?P<most>\d+))?>|(?P<each>.+)\[(?P<count>\d+)\])$")
TEXT = re.compile(r"^w?string(?:<(?P<most>\d+)>)?$")
PARTS: dict[TypeKind, dict[str, str]] = {
    "msg": {},
    "srv": {"request": "Request", "response": "Response"},
    "action": {"goal": "Goal", "result": "Result", "feedback": "Feedback"},
}
DEEPEST = 4
NO_FIELD = "structure_needs_at_least_one_member"
"""What ROS gives a message that has no fields."""


@dataclass(frozen=True)
class FieldType:
    """What one field holds."""

    name: str
    """Of the one value: `boolean`, `octet`, `uint8`, `double`, `string`, or a message's, `std_msgs/msg/Header`."""
    is_list: bool = False
    count: int | None = None
    """How many there are, always."""
    most: int | None = None
    """How many there may be at the most."""
    longest: int | None = None
    """Characters of a text at the most."""


@cache
def field_type(type_name: str) -> FieldType:
    """What a field holds, from how the message reports it."""
    shape = SHAPE.match(type_name)
    if shape is None:
        name, longest = _single(type_name)
        return FieldType(name, longest=longest)
    name, longest = _single(shape["item"] or shape["each"])
    count, most = shape["count"], shape["most"]
    return FieldType(name, True, int(count) if count else None, int(most) if most else None, longest)


def _single(type_name: str) -> tuple[str, int | None]:
    text = TEXT.match(type_name)
    if text is not None:
        return "string", int(text["most"]) if text["most"] else None
    package, slash, name = type_name.partition("/")
    return (f"{package}/msg/{name.rpartition('/')[2]}" if slash else type_name), None


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
    inner = type_name.removeprefix("sequence<").partition(">")[0].partition(",")[0].partition("[")[0]
    if "/" not in inner or depth >= DEEPEST:
        return type_name
    package, _, name = inner.partition("/")
    fields = _fields(find_type(f"{package}/msg/{name.rpartition('/')[2]}", "msg"), depth + 1)
    return fields if inner == type_name else [fields]
