# SPDX-License-Identifier: Apache-2.0
"""Messages from plain data and back: mappings, lists, numbers, texts, bytes, pictures; goal ids from texts.

Rule: what does not fit is an error that names the field, never a message that states something else.
"""

from __future__ import annotations

import math
import string
import sys
import uuid
from array import array
from collections.abc import Callable, Hashable, Mapping
from functools import cache
from typing import Any

from rai_missions.connectors.connector import Data
from rai_missions.connectors.field_types import INTEGERS, FieldType, field_type
from rai_missions.connectors.ros2.images import PICTURES, check_picture, message_of_picture
from rai_missions.connectors.ros2.names import find_type
from rai_missions.connectors.ros2.types import BYTES, CODES, NO_FIELD
from rai_missions.errors import ConnectorError, suggestion
from rai_missions.image import Image
from rai_missions.plain_data import is_numeric, text_fault
from rai_missions.redaction import cut, shown

__all__ = (
    "goal_id_from_bytes",
    "goal_id_to_bytes",
    "is_picture",
    "name_of",
    "to_data",
    "to_message",
    "to_message_later",
)

TIMES = ("builtin_interfaces/msg/Time", "builtin_interfaces/msg/Duration")
GREATEST = {"float": 3.4028234663852886e38, "double": sys.float_info.max}
GREATEST_SET = 3.402823466e38
"""What rclpy takes for the greatest float; as a float it is the greatest one."""
HEX = frozenset("0123456789abcdef")
READABLE = frozenset(string.ascii_letters + string.digits + "-_./:")


def to_message(cls: Any, data: Data, place: str = "") -> Any:
    """A message from plain data; what is left out, or None, keeps its default.

    Args:
        cls: The message's class, or a service's `Request`, an action's `Goal`, …
        data: Fields by name. A Time or Duration may be given in seconds, a picture as `Image`, bytes as they are.
        place: What is before the field's path in an error.

    Raises:
        ConnectorError: A field that the message does not have, or a value that its type does not take.
    """
    if isinstance(data, Image):
        data = message_of_picture(data, name_of(cls), place)
    if not isinstance(data, Mapping):
        raise ConnectorError(f"{place or name_of(cls)}: {shown(data)} is given where the fields of a message belong")
    message, known = cls(), _fields(cls)
    for name, value in data.items():
        if name not in known:
            raise ConnectorError(f"{_at(place, name)}: {name_of(cls)} has no such field{suggestion(str(name), known)}")
        if value is not None:
            where = _at(place, name)
            given = message_of_picture(value, name_of(cls), where)[name] if isinstance(value, Image) else value
            _set(message, name, _field(known[name], given, where), where)
    return message


def is_picture(data: Any) -> bool:
    """Whether plain data carries a picture, whose bytes may be costly to make."""
    return isinstance(data, Mapping) and any(isinstance(value, Image) for value in data.values())


def to_message_later(cls: Any, data: Data, place: str) -> Callable[[], Any]:
    """A message of a picture whose bytes are asked for when it is made, and not before.

    Raises:
        ConnectorError: At once, as `to_message`.
    """
    pictures = {name: value for name, value in data.items() if isinstance(value, Image)}
    message = to_message(cls, {name: value for name, value in data.items() if name not in pictures}, place)
    for name, picture in pictures.items():
        check_picture(picture, name_of(cls), _at(place, name))

    def make() -> Any:
        for name, picture in pictures.items():
            _set(message, name, getattr(to_message(cls, {name: picture}, place), name), _at(place, name))
        return message

    return make


def _set(message: Any, name: str, value: Any, place: str) -> None:
    try:
        setattr(message, name, value)
    except (AssertionError, TypeError, ValueError) as fault:  # what a message refuses beyond what its types state
        raise ConnectorError(f"{place}: {cut(fault, 160)}") from None


def _field(kind: FieldType, value: Any, place: str) -> Any:
    if not kind.is_list:
        return _single(kind, value, place)
    if isinstance(value, bytes | bytearray | memoryview) and kind.name in BYTES:
        value = bytes(value)
    elif hasattr(value, "tolist") and not isinstance(value, array):  # numpy's, without knowing numpy
        value = value.tolist()
    elif not isinstance(value, list | tuple | array):
        raise ConnectorError(f"{place}: {shown(value)} is given where a list of {kind.name} belongs")
    if kind.count is not None and len(value) != kind.count:
        raise ConnectorError(f"{place}: {len(value)} items; there are always {kind.count}")
    if kind.most is not None and len(value) > kind.most:
        raise ConnectorError(f"{place}: {len(value)} items; there are {kind.most} at the most")
    if kind.name in CODES and (isinstance(value, bytes) or getattr(value, "typecode", None) == CODES[kind.name]):
        whole = array(CODES[kind.name], value)
        return whole if kind.count is None else whole.tolist()
    items = [_single(kind, item, f"{place}/{index}") for index, item in enumerate(value)]
    return array(CODES[kind.name], items) if kind.name in CODES and kind.count is None else items


def _single(kind: FieldType, value: Any, place: str) -> Any:
    name = kind.name
    if name in INTEGERS:
        return _integer(name, value, place)
    if name in ("float", "double"):
        return _number(name, value, place)
    if name == "boolean":
        if not isinstance(value, bool):
            raise ConnectorError(f"{place}: {shown(value)} is neither true nor false")
        return value
    if name == "string":
        if not isinstance(value, str):
            raise ConnectorError(f"{place}: {shown(value)} is given where text belongs")
        if kind.longest is not None and len(value) > kind.longest:
            raise ConnectorError(f"{place}: {len(value)} characters; there are {kind.longest} at the most")
        if fault := text_fault(value):
            raise ConnectorError(f"{place}: {fault}")
        return value
    if name == "octet":
        return value if isinstance(value, bytes) and len(value) == 1 else bytes([_integer("uint8", value, place)])
    if name in TIMES and not isinstance(value, Mapping):
        value = _time(_number("double", value, place), place)
    return to_message(find_type(name, "msg"), value, place)


def _integer(name: str, value: Any, place: str) -> int:
    if isinstance(value, float) and value.is_integer():
        value = int(value)
    if not isinstance(value, int) or isinstance(value, bool):
        raise ConnectorError(f"{place}: {shown(value)} is no whole number, as {name} asks")
    least, greatest = INTEGERS[name]
    if not least <= value <= greatest:
        raise ConnectorError(f"{place}: {value} is outside of {name}, which goes from {least} to {greatest}")
    return int(value)


def _number(name: str, value: Any, place: str) -> float:
    if not is_numeric(value):
        raise ConnectorError(f"{place}: {shown(value)} is no number, as {name} asks")
    if isinstance(value, float) and not math.isfinite(value):
        return float(value)
    if abs(value) > GREATEST[name]:
        raise ConnectorError(f"{place}: {shown(value)} is too great for a {name}")
    number = float(value)
    return number if name == "double" else max(-GREATEST_SET, min(GREATEST_SET, number))


def _time(seconds: float, place: str) -> dict[str, int]:
    if not math.isfinite(seconds):
        raise ConnectorError(f"{place}: {seconds} is no time in seconds")
    whole, nanoseconds = divmod(round(seconds * 1e9), 10**9)
    return {"sec": whole, "nanosec": nanoseconds}


def to_data(message: Any, ref: str = "") -> dict[str, Any]:
    """A message as plain data.

    Args:
        message: Any message.
        ref: What a picture in it is called.

    Returns:
        Its fields by name: nested messages as mappings, sequences as lists, those of uint8 and byte as bytes, and the
        pixels of sensor_msgs' Image and CompressedImage as an `Image` where they are of a kind that it knows.
    """
    cls: Any = type(message)
    data = {name: _plain(kind, getattr(message, name), ref) for name, kind in _fields(cls).items()}
    picture = PICTURES.get(name_of(cls))
    if picture is not None:
        data["data"] = picture(data, ref)
    return data


def _plain(kind: FieldType, value: Any, ref: str) -> Any:
    if not kind.is_list:
        if kind.name == "octet":
            return value[0]
        return to_data(value, ref) if "/" in kind.name else value
    if kind.name == "octet":
        return b"".join(value)
    if kind.name in BYTES:
        return bytes(value)
    if "/" in kind.name:
        return [to_data(item, ref) for item in value]
    return value.tolist() if hasattr(value, "tolist") else list(value)


@cache
def name_of(cls: Hashable) -> str:
    """A message class's name, `std_msgs/msg/String`."""
    assert isinstance(cls, type)
    package, kind = cls.__module__.split(".")[:2]
    return f"{package}/{kind}/{cls.__name__}"


@cache
def _fields(cls: Any) -> Mapping[str, FieldType]:
    types = cls.get_fields_and_field_types()
    return {name: field_type(each) for name, each in types.items() if name != NO_FIELD}


def _at(place: str, name: str) -> str:
    return f"{place}/{name}" if place else str(name)


def goal_id_to_bytes(goal_id: str) -> bytes:
    """The id of a unique_identifier_msgs/UUID: 32 hex digits as they are, up to 15 letters padded, all else hashed."""
    if len(goal_id) == 32 and HEX.issuperset(goal_id):
        return bytes.fromhex(goal_id)
    if 0 < len(goal_id) < 16 and READABLE.issuperset(goal_id):
        return goal_id.encode().ljust(16, b"\0")
    return uuid.uuid5(uuid.NAMESPACE_URL, goal_id).bytes


def goal_id_from_bytes(given: bytes) -> str:
    """The id that `goal_id_to_bytes` was given, or 32 hex digits."""
    text = given.rstrip(b"\0").decode("latin-1")
    return text if 0 < len(text) < 16 and READABLE.issuperset(text) else given.hex()
