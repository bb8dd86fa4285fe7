# SPDX-License-Identifier: Apache-2.0
"""What a picture is: its reference, its size, its bytes, and a file that a person or a model can be shown.

Rule: what a file is, its first bytes state and no one's word for it.

Source: Portable Network Graphics (PNG) Specification, W3C Recommendation, sections 5 and 11.2; JPEG, ITU-T T.81,
annex B.2 (frame header).
"""

from __future__ import annotations

import base64
import hashlib
import struct
import zlib
from collections.abc import Callable
from typing import Any, NamedTuple

__all__ = ("CHANNELS", "Image", "ImageFile", "file_kind", "media_type", "png")

PNG, JPEG = b"\x89PNG\r\n\x1a\n", b"\xff\xd8\xff"
CHANNELS = {"rgb8": 3, "bgr8": 3, "mono8": 1, "8UC1": 1, "8UC3": 3}
"""Encodings of raw pixels that are read, by the names of sensor_msgs → bytes a pixel."""
BLUE_FIRST = ("bgr8", "8UC3")
TRUECOLOUR = 2
FAST = 1
"""zlib's level: a picture is sent once, and the robot waits for it."""
FRAMES = frozenset(range(0xC0, 0xD0)) - {0xC4, 0xC8, 0xCC}
"""Markers of a JPEG file that begin a frame, and so report its size."""
LONE = frozenset(range(0xD0, 0xD8)) | {0x01}
"""Markers without a length."""


class ImageFile(NamedTuple):
    """A picture as a file."""

    kind: str
    """`png` or `jpeg`."""
    data: bytes

    @property
    def media_type(self) -> str:
        return f"image/{self.kind}"

    @property
    def base64(self) -> str:
        return base64.b64encode(self.data).decode()

    def block(self) -> dict[str, Any]:
        """A content block of a message to a model, as LangChain has it."""
        return {"type": "image", "base64": self.base64, "mime_type": self.media_type}


class Image:
    """A picture someone took, as a reference; its bytes are made when they are first asked for.

    Two images are equal when they have the same reference.

    Args:
        ref: What identifies the picture in a run, such as `camera@12.300`.
        width: Pixels.
        height: Pixels.
        encoding: `rgb8` (raw, row by row), `png` or `jpeg`.
        data: The bytes, or what makes them when asked.
    """

    __slots__ = ("_data", "encoding", "height", "ref", "width")

    def __init__(self, ref: str, width: int, height: int, encoding: str, data: bytes | Callable[[], bytes]) -> None:
        self.ref, self.width, self.height, self.encoding = ref, width, height, encoding
        self._data = data

    @classmethod
    def of_file(cls, ref: str, data: bytes) -> Image:
        """The picture in a PNG or JPEG file, with the size that the file reports.

        Raises:
            ValueError: It is neither, or is cut short.
        """
        kind = file_kind(data)
        if not kind:
            raise ValueError("is neither a PNG nor a JPEG file")
        size = _png_size(data) if kind == "png" else _jpeg_size(data)
        if size is None or min(size) < 1:
            raise ValueError(f"is a broken {kind.upper()} file: it does not report its size")
        return cls(ref, *size, kind, data)

    @classmethod
    def of_pixels(cls, ref: str, *, width: int, height: int, step: int, encoding: str, data: bytes) -> Image | None:
        """Raw pixels as `rgb8`, worked out when its bytes are asked for.

        Args:
            ref: As `Image` has it.
            width: Pixels.
            height: Pixels.
            step: Bytes from one line to the next.
            encoding: One of `CHANNELS`.
            data: The lines, each with its padding.

        Returns:
            None for another encoding, and where the bytes are fewer than the sizes need.
        """
        wide = width * CHANNELS.get(encoding, 0)
        if min(wide, height) < 1 or step < wide or len(data) < step * height:
            return None
        return cls(ref, width, height, "rgb8", lambda: _rgb(data, wide, height, step, encoding))

    @property
    def data(self) -> bytes:
        if callable(self._data):
            self._data = self._data()
        return self._data

    @property
    def digest(self) -> str:
        """SHA-256 of the bytes, in hex."""
        return hashlib.sha256(self.data).hexdigest()

    def file(self, *, level: int = FAST) -> ImageFile:
        """The picture as a file; raw pixels become a PNG.

        Args:
            level: How hard zlib tries, 0 to 9.

        Raises:
            ValueError: Its bytes are no picture.
            Exception: Whatever the camera raises that makes them.
        """
        data = self.data
        if self.encoding == "rgb8":
            data = png(self.width, self.height, data, level=level)
        kind = file_kind(data)
        if not kind:
            raise ValueError(f"its {len(data)} bytes are neither PNG nor JPEG")
        return ImageFile(kind, data)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, Image) and other.ref == self.ref

    def __hash__(self) -> int:
        return hash(self.ref)

    def __repr__(self) -> str:
        return f"Image({self.ref!r}, {self.width}x{self.height}, {self.encoding})"


def file_kind(data: bytes) -> str:
    """`png` or `jpeg`, by a file's first bytes; empty for anything else."""
    if data.startswith(PNG):
        return "png"
    return "jpeg" if data.startswith(JPEG) else ""


def media_type(encoding: str, width: int, height: int) -> str:
    """As what a picture's bytes are kept."""
    if encoding in ("png", "jpeg"):
        return f"image/{encoding}"
    return f"application/octet-stream; encoding={encoding}; width={width}; height={height}"


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
    return PNG + b"".join(parts)


def _chunk(name: bytes, data: bytes) -> bytes:
    return struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))


def _rgb(data: bytes, wide: int, height: int, step: int, encoding: str) -> bytes:
    if step != wide:
        data = b"".join(data[at : at + wide] for at in range(0, step * height, step))
    packed = data[: wide * height]
    if CHANNELS[encoding] == 3 and encoding not in BLUE_FIRST:
        return packed
    planes = [packed] * 3 if CHANNELS[encoding] == 1 else [packed[2::3], packed[1::3], packed[0::3]]
    rgb = bytearray(3 * len(planes[0]))
    for number, plane in enumerate(planes):
        rgb[number::3] = plane
    return bytes(rgb)


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
        elif marker in FRAMES and at + 9 <= len(data):
            height, width = struct.unpack(">HH", data[at + 5 : at + 9])
            return width, height
        elif marker in FRAMES:
            return None
        else:
            at += 2 if marker in LONE else 2 + max(2, int.from_bytes(data[at + 2 : at + 4], "big"))
    return None
