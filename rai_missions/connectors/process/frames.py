# SPDX-License-Identifier: Apache-2.0
"""Messages over a pipe: a length in four bytes, JSON in UTF-8, and the bytes of pictures behind it.

Rule: a length is believed up to a bound only, and what comes is JSON; nothing of it is ever executed.
"""

from __future__ import annotations

import json
import os
import struct
from collections.abc import Iterator, Mapping, Sequence
from typing import Any

__all__ = ("LONGEST_REPLY", "Broken", "Inlet", "outward", "read_frame", "write_all", "write_frame")

LENGTH = struct.Struct(">I")
LONGEST_REPLY = 512 * 1024
"""Bytes of JSON that a model's process may send at once: its parsing holds the interpreter for a few milliseconds."""
CHUNK = 1 << 16


class Broken(Exception):
    """What came is no message of this protocol; the text states why."""


def outward(message: Mapping[str, Any], blobs: Sequence[bytes] = ()) -> list[bytes]:
    """A message as the pieces to be written."""
    text = json.dumps({**message, "blobs": [len(blob) for blob in blobs]}, ensure_ascii=False, allow_nan=False)
    data = text.encode("utf-8", "replace")
    return [LENGTH.pack(len(data)) + data, *blobs]


def write_all(fd: int, pieces: Sequence[bytes]) -> None:
    """Write the pieces of a message; waits while the pipe is full."""
    for piece in pieces:
        data = memoryview(piece)
        while data:
            data = data[os.write(fd, data) :]


def write_frame(fd: int, message: Mapping[str, Any]) -> None:
    """Write a message without pictures; waits while the pipe is full."""
    write_all(fd, outward(message))


def read_frame(fd: int) -> tuple[dict[str, Any], list[bytes]] | None:
    """The next message of a trusted pipe, in a process that does nothing else; None at its end."""
    head = _exactly(fd, LENGTH.size)
    if not head:
        return None
    message: dict[str, Any] = json.loads(_exactly(fd, LENGTH.unpack(head)[0]))
    return message, [_exactly(fd, size) for size in message.pop("blobs")]


def _exactly(fd: int, size: int) -> bytes:
    """Read `size` bytes; none where the pipe has ended."""
    parts, left = list[bytes](), size
    while left:
        part = os.read(fd, min(left, 1 << 20))
        if not part:
            return b""
        parts.append(part)
        left -= len(part)
    return b"".join(parts)


class Inlet:
    """Takes apart what an untrusted process sends, without pictures, bounded."""

    def __init__(self) -> None:
        self._held = bytearray()

    def feed(self, data: bytes) -> Iterator[dict[str, Any]]:
        """The messages that are whole by now.

        Raises:
            Broken: A message is too long, or is none.
        """
        self._held += data
        while len(self._held) >= LENGTH.size:
            size = LENGTH.unpack_from(self._held)[0]
            if size > LONGEST_REPLY:
                raise Broken(f"it sent a message of {size} bytes; {LONGEST_REPLY} are the most")
            end = LENGTH.size + size
            if len(self._held) < end:
                return
            text = bytes(self._held[LENGTH.size : end])
            del self._held[:end]
            yield _message(text)


def _message(text: bytes) -> dict[str, Any]:
    try:
        message = json.loads(text)
    except (ValueError, RecursionError):
        raise Broken("it sent what is no JSON") from None
    if not isinstance(message, dict):
        raise Broken("it sent JSON that is no object")
    return message
