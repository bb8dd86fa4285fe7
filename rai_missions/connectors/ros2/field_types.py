# SPDX-License-Identifier: Apache-2.0
"""The types of a message's fields, as it tells them itself: `sequence<geometry_msgs/Point, 4>`, `double[36]`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

__all__ = ("BYTES", "CODES", "INTEGERS", "FieldType", "field_type")

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
def field_type(said: str) -> FieldType:
    """What a field holds, from how the message tells it."""
    shape = SHAPE.match(said)
    if shape is None:
        name, longest = _single(said)
        return FieldType(name, longest=longest)
    name, longest = _single(shape["item"] or shape["each"])
    count, most = shape["count"], shape["most"]
    return FieldType(name, True, int(count) if count else None, int(most) if most else None, longest)


def _single(said: str) -> tuple[str, int | None]:
    text = TEXT.match(said)
    if text is not None:
        return "string", int(text["most"]) if text["most"] else None
    package, slash, name = said.partition("/")
    return (f"{package}/msg/{name.rpartition('/')[2]}" if slash else said), None
