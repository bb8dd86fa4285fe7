# SPDX-License-Identifier: Apache-2.0
"""A picture file as an image: its kind and its size, read from the first bytes and not from its name.

Source: PNG, W3C Recommendation, section 11.2.2 (IHDR); JPEG, ITU-T T.81, annex B.2 (frame header).
"""

from __future__ import annotations

import struct

from rai_missions.event import Image

__all__ = ("read_picture",)

PNG_SIGNATURE = b"\x89PNG\r\n\x1a\n"
JPEG_SIGNATURE = b"\xff\xd8"
FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers that begin a frame, and so report its size."""
LONE = frozenset(range(0xD0, 0xD8)) | {0x01}
"""Markers without a length."""


def read_picture(name: str, data: bytes) -> Image:
    """The image in a PNG or JPEG file.

    Raises:
        ValueError: It is neither, or is cut short.
    """
    if data.startswith(PNG_SIGNATURE):
        kind, size = "png", _png_size(data)
    elif data.startswith(JPEG_SIGNATURE):
        kind, size = "jpeg", _jpeg_size(data)
    else:
        raise ValueError("is neither a PNG nor a JPEG file")
    if size is None or min(size) < 1:
        raise ValueError(f"is a broken {kind.upper()} file: it does not report its size")
    return Image(f"identity/{name}", *size, kind, data)


def _png_size(data: bytes) -> tuple[int, int] | None:
    if len(data) < 24 or data[12:16] != b"IHDR":
        return None
    width, height = struct.unpack(">II", data[16:24])
    return width, height


def _jpeg_size(data: bytes) -> tuple[int, int] | None:
    at = 2
    while at + 4 <= len(data) and data[at] == 0xFF:
        marker = data[at + 1]
        if marker == 0xFF:
            at += 1
        elif marker in LONE:
            at += 2
        elif marker in FRAMES:
            return _frame_size(data[at + 5 : at + 9])
        else:
            at += 2 + max(2, int.from_bytes(data[at + 2 : at + 4], "big"))
    return None


def _frame_size(field: bytes) -> tuple[int, int] | None:
    if len(field) < 4:
        return None
    height, width = struct.unpack(">HH", field)
    return width, height
