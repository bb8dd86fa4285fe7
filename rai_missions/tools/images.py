# SPDX-License-Identifier: Apache-2.0
"""A camera's message as a picture that a model can be sent: bounded in pixels and in bytes.

Rule: what a camera sends becomes a picture of at most `LARGEST` bytes, or a `ConnectorError` that states why not.
"""

from __future__ import annotations

import io
from collections.abc import Mapping
from typing import Any

from rai_missions.connectors.ros2.images import PICTURES
from rai_missions.errors import ConnectorError, raised_text
from rai_missions.image import Image, ImageFile, png
from rai_missions.redaction import cut, cut_repr

__all__ = ("LARGEST", "block", "image_of", "pixels_of", "smaller")

LARGEST = 1_000_000
"""Bytes of a picture's file."""
LONGEST_SIDE = 1_024
"""Pixels."""
MOST_PIXELS = 50_000_000
"""The most pixels of a picture file: a few bytes may unpack to very many."""


def image_of(message: Any, ref: str) -> Image:
    """The picture in a message of sensor_msgs' Image or CompressedImage.

    Raises:
        ConnectorError: There is none.
    """
    data = message.get("data") if isinstance(message, Mapping) else message
    if isinstance(data, Image):
        return data
    found: Any = None
    if isinstance(message, Mapping):
        fields = {**message, "data": _bytes(data)}
        kind = "CompressedImage" if isinstance(message.get("format"), str) else "Image"
        words = ("width", "height", "step")
        if kind == "CompressedImage" or all(isinstance(message.get(word), int) for word in words):
            found = PICTURES[f"sensor_msgs/msg/{kind}"](fields, ref)
    if not isinstance(found, Image):
        encoding = message.get("encoding") or message.get("format") if isinstance(message, Mapping) else None
        raise ConnectorError(
            f"no picture that can be shown was sent (encoding: {cut_repr(encoding, 40)}); depth has tools of its own"
        )
    return found


def _bytes(data: Any) -> bytes:
    """Bytes, or a list of their numbers, as other programs write JSON; nothing where it is something else."""
    try:
        return bytes(data) if isinstance(data, bytes | bytearray | memoryview | list | tuple) else b""
    except (TypeError, ValueError):
        return b""


def block(image: Image) -> dict[str, Any]:
    """A content block that shows a picture.

    Raises:
        ConnectorError: Its bytes cannot be had, or made small enough.
    """
    try:
        if image.encoding == "rgb8":
            return ImageFile("png", _small(image.width, image.height, image.data)).block()
        file = image.file()
        return (file if len(file.data) <= LARGEST else smaller(file.data)).block()
    except ConnectorError:
        raise
    except Exception as fault:  # the bytes are made when asked for, by whatever camera
        raise ConnectorError(f"the picture cannot be had: {cut(raised_text(fault), 120)}") from fault


def pixels_of(image: Image) -> Image:
    """A picture as raw pixels, `rgb8`: what ROS carries in messages that hold pictures.

    Raises:
        ConnectorError: It is no picture, is too large, or Pillow is not installed.
    """
    if image.encoding == "rgb8":
        return image
    picture = _opened(image.file().data, "no raw pixels; to make them")
    return Image(image.ref, picture.width, picture.height, "rgb8", picture.tobytes())


def _small(width: int, height: int, rgb: bytes) -> bytes:
    """A PNG file of every n-th pixel: the least n for which it is small enough."""
    stride = max(1, -(-max(width, height) // LONGEST_SIDE))
    while True:
        columns, rows = -(-width // stride), -(-height // stride)
        file = png(columns, rows, rgb if stride == 1 else _every(rgb, width, height, stride))
        if len(file) <= LARGEST or columns * rows == 1:
            return file
        stride += 1


def _every(rgb: bytes, width: int, height: int, stride: int) -> bytes:
    lines = []
    for row in range(0, height, stride):
        line = rgb[row * width * 3 : (row + 1) * width * 3]
        packed = bytearray(3 * -(-width // stride))
        for channel in range(3):
            packed[channel::3] = line[channel :: 3 * stride]
        lines.append(bytes(packed))
    return b"".join(lines)


def smaller(data: bytes, largest: int = LARGEST, side: int = LONGEST_SIDE) -> ImageFile:
    """A JPEG file of a picture file that is too large.

    Args:
        data: The picture file.
        largest: Bytes of the new file at most.
        side: Pixels of its longer side at most; halved until the file is small enough.

    Raises:
        ConnectorError: It is no picture, is too large, or Pillow is not installed.
    """
    picture = _opened(data, f"larger than {largest}; to make it smaller")
    while True:
        picture.thumbnail((side, side))
        file = io.BytesIO()
        picture.save(file, "JPEG", quality=85)
        if file.tell() <= largest or side <= 1:
            return ImageFile("jpeg", file.getvalue())
        side //= 2


def _opened(data: bytes, what_for: str) -> Any:
    """The pixels of a picture file, as Pillow has them."""
    try:
        import PIL.Image
    except ImportError:
        raise ConnectorError(f"a picture file of {len(data)} bytes is {what_for}, pip install pillow") from None
    try:
        # Other forms are programs: Pillow runs PostScript.
        picture = PIL.Image.open(io.BytesIO(data), formats=("JPEG", "PNG"))
        if picture.width * picture.height > MOST_PIXELS:
            raise ConnectorError(
                f"a picture of {picture.width}x{picture.height} is too large; {MOST_PIXELS} pixels are the most"
            )
        return picture.convert("RGB")
    except OSError as fault:
        raise ConnectorError(f"a picture file of {len(data)} bytes cannot be opened: {cut(fault, 120)}") from None
