# SPDX-License-Identifier: Apache-2.0
"""What a robot's messages state, as values of the blackboard, and values as messages.

Rule: pure, and suspicious. What a message leaves open is None: not received. What it may not be is a `ConnectorError`.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from rai_missions.errors import ConnectorError
from rai_missions.image import CHANNELS, Image
from rai_missions.plain_data import are_finite, at_path, is_number, is_numeric
from rai_missions.redaction import cut, cut_repr

__all__ = ("image_of", "json_of", "plain", "pose_message", "pose_of")

LONGEST_TEXT = 1_000_000
"""Characters of JSON that are read from one message."""
DEEPEST = 60
TEXT = frozenset({str})
BYTES = (bytes, bytearray, memoryview)


def plain(value: Any, depth: int = 0) -> Any:
    """A message as data that a journal holds: lists for sequences, None for a number not to be reckoned with.

    That is one that is not finite, or an integer beyond all floating-point numbers. A field that is bytes, as an id or
    a map's cells, is left out.

    Raises:
        ConnectorError: Bytes outside of a field, a name that is no text, nesting deeper than 60, another type.
    """
    kind = type(value)
    if kind is float:
        return value if math.isfinite(value) else None
    if kind is str or kind is bool or value is None or isinstance(value, Image):
        return value
    if isinstance(value, str):
        return str.__str__(value)  # a word of an enumeration, or of numpy, is text of another type
    if isinstance(value, int | float):
        number = int if isinstance(value, int) else float
        return number(value) if is_number(value) else None
    if depth > DEEPEST:
        raise ConnectorError(
            f"a message is nested deeper than {DEEPEST}; its sender sends something else than its type declares"
        )
    if kind is dict or isinstance(value, Mapping):
        if not TEXT.issuperset(map(type, value)) and not all(isinstance(name, str) for name in value):
            raise ConnectorError(
                f"the fields of a message have names of text, not {cut(sorted(map(repr, value))[0], 60)}"
            )
        return {
            str.__str__(name): plain(item, depth + 1) for name, item in value.items() if not isinstance(item, BYTES)
        }
    if isinstance(value, list | tuple):
        return [*value] if are_finite(value) else [plain(item, depth + 1) for item in value]
    if hasattr(value, "tolist"):  # numpy's arrays and numbers, without knowing numpy
        return plain(value.tolist(), depth + 1)
    raise ConnectorError(
        f"{cut_repr(value, 60)} ({type(value).__name__}) is no plain data; name the 'field' that is meant"
    )


def json_of(text: Any) -> Any:
    """The JSON in a message's text, as in a std_msgs/msg/String.

    Raises:
        ConnectorError: It is no JSON, too long, or nested too deeply.
    """
    if not isinstance(text, str):
        raise ConnectorError(f"{cut_repr(text, 60)} is given where JSON text belongs")
    if len(text) > LONGEST_TEXT:
        raise ConnectorError(f"JSON text of {len(text)} characters; at most {LONGEST_TEXT} are read")
    try:
        return plain(json.loads(text))
    except (ValueError, RecursionError) as error:
        why = "it is nested too deeply" if isinstance(error, RecursionError) else str(error)
        raise ConnectorError(f"a message's text is no JSON: {cut(why, 120)}") from None


def pose_of(message: Any) -> dict[str, Any] | None:
    """A pose from geometry_msgs' PoseStamped, PoseWithCovarianceStamped or Pose, or nav_msgs' Odometry.

    Returns:
        `{"x", "y", "z", "yaw", "frame"}` in metres and radians; None while the robot does not know where it is (NaN).
        Yaw is the rotation around z of the quaternion (ZYX Euler angles).

    Raises:
        ConnectorError: It is none of these.
    """
    frame, inner = at_path(message, "header.frame_id"), message
    while isinstance(inner, Mapping) and "position" not in inner and "pose" in inner:
        inner = inner["pose"]
    place, turn = at_path(inner, "position"), at_path(inner, "orientation")
    if not isinstance(place, Mapping) or not isinstance(turn, Mapping):
        raise ConnectorError(
            f"{cut_repr(message, 60)} is given where a pose belongs: it has no 'position' and 'orientation'"
        )
    numbers = [
        place.get("x"),
        place.get("y"),
        place.get("z", 0.0),
        *(turn.get(axis, 0.0) for axis in "xyz"),
        turn.get("w", 1.0),
    ]
    if not all(map(is_numeric, numbers)):
        raise ConnectorError(f"a pose is made of numbers, not of {cut_repr(numbers, 120)}")
    if not all(map(is_number, numbers)):
        return None
    x, y, z, qx, qy, qz, qw = map(float, numbers)
    yaw = math.atan2(2 * (qw * qz + qx * qy), 1 - 2 * (qy * qy + qz * qz))
    return {"x": x, "y": y, "z": z, "yaw": yaw, "frame": str(frame) if isinstance(frame, str) else ""}


def pose_message(pose: Any, *, stamped: bool = True) -> dict[str, Any]:
    """A geometry_msgs/msg/PoseStamped, or Pose, from a pose of the blackboard.

    Raises:
        ConnectorError: It is no pose.
    """
    if not isinstance(pose, Mapping) or not all(is_number(pose.get(axis, 0.0)) for axis in ("x", "y", "z", "yaw")):
        raise ConnectorError(f"{cut_repr(pose, 60)} is given where a pose belongs: {{'x', 'y', 'z', 'yaw', 'frame'}}")
    half = float(pose.get("yaw", 0.0)) / 2
    made = {
        "position": {axis: float(pose.get(axis, 0.0)) for axis in "xyz"},
        "orientation": {"x": 0.0, "y": 0.0, "z": math.sin(half), "w": math.cos(half)},
    }
    return {"header": {"frame_id": str(pose.get("frame", ""))}, "pose": made} if stamped else made


def image_of(message: Any, ref: str) -> Image:
    """A picture from sensor_msgs' Image or CompressedImage; padding is cut off when the bytes are asked for.

    Args:
        message: As a mapping; its `data` is bytes, a list of bytes' numbers, or an `Image`, which is taken as it is.
        ref: What the picture is called, if it is not an `Image` already.

    Raises:
        ConnectorError: It is no picture.
    """
    data = at_path(message, "data")
    if isinstance(message, Image):
        return message
    if isinstance(data, Image):
        return data
    if isinstance(data, list | tuple):
        try:
            data = bytes(data)
        except (ValueError, TypeError):
            data = None
    if not isinstance(data, BYTES):
        raise ConnectorError(f"{cut_repr(message, 60)} is given where a picture belongs: its 'data' is no bytes")
    raw, format_name = bytes(data), message.get("format")
    if isinstance(format_name, str):
        return Image(ref, 0, 0, "png" if "png" in format_name.lower() else "jpeg", raw)
    width, height, encoding = (message.get(word) for word in ("width", "height", "encoding"))
    channels = CHANNELS.get(str(encoding), 0)
    step = message.get("step") or (width * channels if isinstance(width, int) else 0)
    sizes = (width, height, step)
    if not channels or not all(isinstance(size, int) and size > 0 for size in sizes):
        raise ConnectorError(
            f"a picture in '{encoding}' of {width} × {height}, {step} bytes a line; read are {', '.join(CHANNELS)}"
        )
    image = Image.of_pixels(ref, width=width, height=height, step=step, encoding=str(encoding), data=raw)
    if image is None:
        raise ConnectorError(f"a picture of {width} × {height} in '{encoding}' needs more than its {len(raw)} bytes")
    return image
