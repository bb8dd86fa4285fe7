# SPDX-License-Identifier: Apache-2.0
"""Whether a field of a message takes a value that is sent, by the type of the field, in a sentence.

Rule: what a type leaves open is no fault. The connector converts a value, and refuses what is beyond its type's name.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rai_missions.connectors.field_types import INTEGERS, field_type
from rai_missions.keys import Key
from rai_missions.profile.type_fields import inside, is_list
from rai_missions.redaction import shown

__all__ = ("SentValue", "misfit", "sent_value")

KINDS: Mapping[type, str] = {
    bool: "boolean",
    int: "integer",
    float: "number",
    str: "string",
    list: "list",
    tuple: "list",
    dict: "object",
}
POSE = frozenset({"x", "y", "z", "yaw", "frame"})
"""What a pose of the blackboard has."""
NUMBERS = frozenset({"integer", "number"})
TIME = frozenset({"sec", "nanosec"})
"""What a time has, for which seconds may be given."""
AS_POSE = 'write it in the profile with "as": "geometry_msgs/msg/PoseStamped", or "…/Pose"'


class SentValue(NamedTuple):
    """A value that is given to a field: a constant, or what a key holds."""

    kind: str
    """Its type on the blackboard; empty where that is open."""
    words: str
    """What it is, for a sentence."""
    constant: Any = None
    """None for what a key holds."""
    remedy: str = ""
    """What the author may have meant, for the end of the sentence."""


def sent_value(item: Any, keys: Mapping[str, Key]) -> SentValue:
    """What a goal, request or message gives to a field.

    Args:
        item: As it is written: a constant, or `{"from": path}`.
        keys: The mission's, for what a path reads; empty for a template of a profile.
    """
    if isinstance(item, Mapping) and item:
        path = item.get("from")
        return SentValue(_kind_of(path, keys) if isinstance(path, str) and len(item) == 1 else "", f"'{path}'")
    is_key = isinstance(item, str) and item in keys
    remedy = f'; for what the key has, write {{"from": "{item}"}}' if is_key else ""
    return SentValue(KINDS.get(type(item), ""), shown(item), item, remedy)


def _kind_of(path: str, keys: Mapping[str, Key]) -> str:
    name, _, field = path.partition(".")
    key = keys.get(name)
    if key is None:
        return ""
    return (key.fields or {}).get(field, "") if field else key.type


def misfit(there: Any, path: str, value: SentValue) -> str:
    """Why a field takes no such value; empty if it may, or if its type is open.

    Args:
        there: The fields of a part of a type, as `FieldsOf` has them.
        path: The field, `pose.position.x`.
        value: What it is given.
    """
    leaf = inside(there, path)
    wanted = _wanted(leaf, value)
    if not wanted:
        return ""
    of_type = f" ({leaf})" if isinstance(leaf, str) else ""
    key = f" of type '{value.kind}'" if value.constant is None else ""
    remedy = f"; {AS_POSE}" if value.kind == "pose" and isinstance(leaf, Mapping) else value.remedy
    return f"takes {wanted} as '{path}'{of_type}, not {value.words}{key}{remedy}"


def _wanted(leaf: Any, value: SentValue) -> str:
    """What a field takes instead of a value; empty if it may take that."""
    if leaf is None or value.kind in ("", "image"):
        return ""
    if is_list(leaf):
        return _wanted_list(leaf, value)
    if isinstance(leaf, Mapping):
        return _wanted_message(leaf, value)
    if leaf == "boolean":
        return "true or false" * (value.kind != "boolean")
    if leaf in ("float", "double"):
        return "a number" * (value.kind not in NUMBERS)
    name = field_type(str(leaf)).name
    if name == "string":
        return "a text" * (value.kind != "string")
    return _wanted_whole("uint8" if name == "octet" else name, value)


def _wanted_whole(name: str, value: SentValue) -> str:
    if name not in INTEGERS:
        return ""
    constant = value.constant
    if value.kind not in NUMBERS or (constant is not None and constant != int(constant)):
        return "a whole number"
    least, greatest = INTEGERS[name]
    return "" if constant is None or least <= constant <= greatest else f"a whole number from {least} to {greatest}"


def _wanted_list(leaf: Any, value: SentValue) -> str:
    if value.kind != "list":
        return "a list"
    one = _item(leaf)
    wanted = dict.fromkeys(_wanted(one, sent_value(item, {})) for item in value.constant or ())
    return next((f"a list, each of whose items is {each}," for each in wanted if each), "")


def _item(leaf: Any) -> Any:
    """What an item of a list is; None where that is open."""
    if not isinstance(leaf, str):
        return leaf[0] if len(leaf) else None
    return field_type(leaf).name


def _wanted_message(leaf: Mapping[str, Any], value: SentValue) -> str:
    if value.kind == "object" or (value.kind == "pose" and leaf.keys() >= POSE):
        return ""
    if value.kind in NUMBERS and leaf.keys() == TIME:
        return ""
    return f"a message with {', '.join(_shortened(leaf))}"


def _shortened(leaf: Mapping[str, Any]) -> Iterator[str]:
    yield from list(leaf)[:4]
    if len(leaf) > 4:
        yield "…"
