# SPDX-License-Identifier: Apache-2.0
"""Pictures: sensor_msgs' Image and CompressedImage, and the `Image` that the rest of the project knows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.errors import ConnectorError
from rai_missions.image import Image

__all__ = ("PICTURES", "check_picture", "message_of_picture")

CHANNELS = {"rgb8": 3, "bgr8": 3, "mono8": 1, "8UC1": 1, "8UC3": 3}
RAW, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
CARRIED = {RAW: ("rgb8",), COMPRESSED: ("png", "jpeg")}
"""Messages that carry a picture → the encodings that they carry."""


def message_of_picture(picture: Image, type_name: str, place: str) -> dict[str, Any]:
    """The fields of a message that carries a picture.

    Raises:
        ConnectorError: The message carries none, or none of this encoding.
    """
    check_picture(picture, type_name, place)
    if type_name == RAW:
        return {
            "width": picture.width, "height": picture.height, "encoding": "rgb8", "step": picture.width * 3,
            "data": picture.data,
        }  # fmt: skip
    return {"format": picture.encoding, "data": picture.data}


def check_picture(picture: Image, type_name: str, place: str) -> None:
    """Whether a message can carry a picture; its bytes are not asked for.

    Raises:
        ConnectorError: The message carries none, or none of this encoding.
    """
    if picture.encoding in CARRIED.get(type_name, ()):
        return
    carrier = RAW if picture.encoding == "rgb8" else COMPRESSED
    raise ConnectorError(f"{place or type_name}: a picture in '{picture.encoding}' travels as {carrier}")


def _raw(fields: Mapping[str, Any], ref: str) -> Any:
    """The pixels as an `Image`, worked out when they are asked for; depth and the like stay bytes."""
    width, height, step, data = (fields[word] for word in ("width", "height", "step", "data"))
    channels = CHANNELS.get(fields["encoding"], 0)
    if not channels or not width or not height or step < width * channels or len(data) < step * height:
        return data
    is_blue_first = fields["encoding"] in ("bgr8", "8UC3")

    def pixels() -> bytes:
        row = width * channels
        packed = data if step == row else b"".join(data[at : at + row] for at in range(0, step * height, step))
        packed = packed[: row * height]
        return packed if channels == 3 and not is_blue_first else _rgb(packed, channels)

    return Image(ref, width, height, "rgb8", pixels)


def _rgb(packed: bytes, channels: int) -> bytes:
    planes = [packed] * 3 if channels == 1 else [packed[2::3], packed[1::3], packed[0::3]]
    rgb = bytearray(3 * len(planes[0]))
    for number, plane in enumerate(planes):
        rgb[number::3] = plane
    return bytes(rgb)


def _compressed(fields: Mapping[str, Any], ref: str) -> Any:
    format_name = fields["format"].lower()
    encoding = "png" if "png" in format_name else "jpeg" if "jpeg" in format_name or "jpg" in format_name else ""
    return Image(ref, 0, 0, encoding, fields["data"]) if encoding else fields["data"]


PICTURES: Mapping[str, Callable[[Mapping[str, Any], str], Any]] = {RAW: _raw, COMPRESSED: _compressed}
"""Messages that carry a picture → what their `data` is."""
