# SPDX-License-Identifier: Apache-2.0
"""The type of one field of a message, as ROS writes it: `double[36]`, `sequence<geometry_msgs/Point, 4>`."""

from __future__ import annotations

import re
from dataclasses import dataclass
from functools import cache

__all__ = ("INTEGERS", "FieldType", "field_type", "is_list_type")

INTEGERS = {
    **{f"int{bits}": (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1) for bits in (8, 16, 32, 64)},
    **{f"uint{bits}": (0, 2**bits - 1) for bits in (8, 16, 32, 64)},
}
"""Integer type → the least and the greatest of its values."""
LIST = re.compile(r"^(?:sequence<(?P<item>.+?)(?:, (?P<most>\d+))?>|(?P<each>.+)\[(?P<count>\d+)\])$")
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
def field_type(type_name: str) -> FieldType:
    """What a field holds, from how the message reports it."""
    listed = LIST.match(type_name)
    if listed is None:
        name, longest = _single(type_name)
        return FieldType(name, longest=longest)
    name, longest = _single(listed["item"] or listed["each"])
    count, most = listed["count"], listed["most"]
    return FieldType(name, True, int(count) if count else None, int(most) if most else None, longest)


def _single(type_name: str) -> tuple[str, int | None]:
    text = TEXT.match(type_name)
    if text is not None:
        return "string", int(text["most"]) if text["most"] else None
    package, slash, name = type_name.partition("/")
    return (f"{package}/msg/{name.rpartition('/')[2]}" if slash else type_name), None


def is_list_type(type_name: str) -> bool:
    """Whether a field of this type holds a list."""
    return LIST.match(type_name) is not None
