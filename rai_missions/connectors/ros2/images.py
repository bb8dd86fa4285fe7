# SPDX-License-Identifier: Apache-2.0
"""Pictures: sensor_msgs' Image and CompressedImage, and the `Image` that the rest of the project knows."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.errors import ConnectorError
from rai_missions.image import Image

__all__ = ("PICTURES", "check_picture", "message_of_picture")

RAW, COMPRESSED = "sensor_msgs/msg/Image", "sensor_msgs/msg/CompressedImage"
PIXEL_BYTES = {"rgb8": 3, "16UC1": 2, "mono8": 1}
"""Encodings of raw pixels that are sent → bytes a pixel; `16UC1` is depth in mm (REP 118)."""
CARRIED = {RAW: tuple(PIXEL_BYTES), COMPRESSED: ("png", "jpeg")}
"""Messages that carry a picture → the encodings that they carry."""


def message_of_picture(picture: Image, type_name: str, place: str) -> dict[str, Any]:
    """The fields of a message that carries a picture.

    Raises:
        ConnectorError: The message carries none, or none of this encoding.
    """
    check_picture(picture, type_name, place)
    if type_name == RAW:
        return {
            "width": picture.width,
            "height": picture.height,
            "encoding": picture.encoding,
            "step": picture.width * PIXEL_BYTES[picture.encoding],
            "data": picture.data,
        }
    return {"format": picture.encoding, "data": picture.data}


def check_picture(picture: Image, type_name: str, place: str) -> None:
    """Whether a message can carry a picture; its bytes are not asked for.

    Raises:
        ConnectorError: The message carries none, or none of this encoding.
    """
    if picture.encoding in CARRIED.get(type_name, ()):
        return
    carrier = RAW if picture.encoding in PIXEL_BYTES else COMPRESSED
    raise ConnectorError(f"{place or type_name}: a picture in '{picture.encoding}' travels as {carrier}")


def _raw(fields: Mapping[str, Any], ref: str) -> Any:
    """The pixels as an `Image`; depth and the like stay bytes."""
    words = {word: fields[word] for word in ("width", "height", "step", "encoding", "data")}
    return Image.of_pixels(ref, **words) or fields["data"]


def _compressed(fields: Mapping[str, Any], ref: str) -> Any:
    format_name = fields["format"].lower()
    encoding = "png" if "png" in format_name else "jpeg" if "jpeg" in format_name or "jpg" in format_name else ""
    return Image(ref, 0, 0, encoding, fields["data"]) if encoding else fields["data"]


PICTURES: Mapping[str, Callable[[Mapping[str, Any], str], Any]] = {RAW: _raw, COMPRESSED: _compressed}
"""Messages that carry a picture → what their `data` is."""
