# SPDX-License-Identifier: Apache-2.0
"""A long message, divided into parts that a middleware carries well."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace

from rai_missions.connectors.hri.message import Audio, HRIMessage, size_of
from rai_missions.errors import UsageError
from rai_missions.image import Image

__all__ = ("parts_of",)

TEXT_OF_A_PART = 16_000
"""Characters; at most 64 kB on the wire."""
BYTES_OF_A_PART = 1024 * 1024
"""Bytes of pictures and sound in a part; a larger picture or piece of sound travels in one of its own."""


def parts_of(
    message: HRIMessage,
    communication_id: str = "",
    *,
    most_text: int = TEXT_OF_A_PART,
    most_bytes: int = BYTES_OF_A_PART,
) -> tuple[HRIMessage, ...]:
    """A message as parts, in order; one part where it is short.

    Args:
        message: A whole message.
        communication_id: What its parts share, where it has no id of its own.
        most_text: Characters of a part.
        most_bytes: Bytes of the pictures and the sound of a part, where it has more than one.

    Raises:
        UsageError: It is itself a part, or has several parts and no id.
    """
    if message.seq_no or not message.seq_end:
        raise UsageError(f"part {message.seq_no} of a message cannot be divided again; send it as it is")
    pieces = list(_pieces(message, most_text, most_bytes)) or [_Piece()]
    shared = message.communication_id or communication_id
    if len(pieces) > 1 and not shared:
        raise UsageError(f"a message in {len(pieces)} parts needs a communication_id, by which they are known")
    last = len(pieces) - 1
    shared = shared if last else message.communication_id
    return tuple(
        replace(
            message,
            text=each.text,
            images=tuple(each.images),
            audios=tuple(each.audios),
            communication_id=shared,
            seq_no=number,
            seq_end=number == last,
        )
        for number, each in enumerate(pieces)
    )


@dataclass(slots=True)
class _Piece:
    """What one part is to carry."""

    text: str = ""
    images: list[Image] = field(default_factory=list)
    audios: list[Audio] = field(default_factory=list)


def _pieces(message: HRIMessage, most_text: int, most_bytes: int) -> Iterator[_Piece]:
    text, piece, size = message.text, _Piece(), 0
    while len(text) > most_text:
        yield _Piece(text[:most_text])
        text = text[most_text:]
    piece.text = text
    for item in message.attachments:
        more = size_of(item)
        if size and size + more > most_bytes:
            yield piece
            piece, size = _Piece(), 0
        if isinstance(item, Image):
            piece.images.append(item)
        else:
            piece.audios.append(item)
        size += more
    if piece.text or piece.images or piece.audios:
        yield piece
