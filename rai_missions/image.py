# SPDX-License-Identifier: Apache-2.0
"""Raw pixels as a PNG file, so that a model and a reader can be shown what a camera saw.

Source: Portable Network Graphics (PNG) Specification, W3C Recommendation, sections 5 and 11.2.
"""

from __future__ import annotations

import struct
import zlib

__all__ = ("png",)

SIGNATURE = b"\x89PNG\r\n\x1a\n"
TRUECOLOUR = 2
FAST = 1
"""zlib's level: a picture is sent once, and the robot waits for it."""


def png(width: int, height: int, rgb: bytes, *, level: int = FAST) -> bytes:
    """A PNG file of `rgb8` pixels, row by row.

    Args:
        width: Pixels.
        height: Pixels.
        rgb: Three bytes a pixel.
        level: How hard zlib tries, 0 to 9.

    Raises:
        ValueError: There are not three bytes for each pixel.
    """
    if width < 1 or height < 1 or len(rgb) != width * height * 3:
        raise ValueError(f"{width}x{height} pixels of rgb8 are {width * height * 3} bytes, not {len(rgb)}")
    row = width * 3
    unfiltered = b"".join(b"\0" + rgb[start : start + row] for start in range(0, len(rgb), row))
    header = struct.pack(">IIBBBBB", width, height, 8, TRUECOLOUR, 0, 0, 0)
    parts = (_chunk(b"IHDR", header), _chunk(b"IDAT", zlib.compress(unfiltered, level)), _chunk(b"IEND", b""))
    return SIGNATURE + b"".join(parts)


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
