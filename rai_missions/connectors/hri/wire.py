# SPDX-License-Identifier: Apache-2.0
"""A message as the plain data of `rai_interfaces/msg/HRIMessage`, and back; the same over every connector.

The message type has no author: the topic gives it. Our name of the author travels in `header.frame_id`, which other
programs leave empty.
"""

from __future__ import annotations

import sys
from array import array
from collections.abc import Mapping
from typing import Any

from rai_missions.connectors.connector import Data
from rai_missions.connectors.hri.message import Audio, Author, HRIMessage, size_of
from rai_missions.errors import ConnectorError, UsageError, in_words
from rai_missions.image import CHANNELS, Image, file_kind
from rai_missions.redaction import shown

__all__ = ("TYPE", "message_from_data", "message_to_data")

TYPE = "rai_interfaces/msg/HRIMessage"
FIELDS = frozenset(("text", "images", "audios", "communication_id", "seq_no", "seq_end"))
"""What has none of these is of another form; taken with its defaults it would be an empty message."""
OLDEST_S = 1e10
"""A stamp is a number that anyone wrote; an age goes back to 1970, and no further than to be spoken."""


def message_to_data(message: HRIMessage, at: float = 0.0) -> dict[str, Any]:
    """The fields of the message type; over ROS 2 its pictures are `rgb8`.

    Args:
        message: What is sent.
        at: When, as a time of day; 0 leaves its stamp empty.
    """
    return {
        "header": {"frame_id": message.name, "stamp": _stamp(at)},
        "text": message.text,
        "images": list(message.images),
        "audios": [
            {"audio": _numbers(each.samples), "sample_rate": each.rate_hz, "channels": each.channels}
            for each in message.audios
        ],
        "communication_id": message.communication_id,
        "seq_no": message.seq_no,
        "seq_end": message.seq_end,
    }


def message_from_data(data: Data, author: Author, place: str = "", age_s: float | None = None) -> HRIMessage:
    """The message in plain data that came from outside.

    Args:
        data: Fields by name; one that is left out has the message type's default.
        author: Who writes on the topic.
        place: The topic, for the error.
        age_s: Seconds from its stamp to its receipt, as the connector reports it.

    Raises:
        ConnectorError: A field is at fault; the sentence names it and the topic.
    """
    try:
        if data.keys().isdisjoint(FIELDS):
            raise UsageError(f'{shown(dict(data))} has no field of a message; write {{"text": …}}')
        header = _mapping("header", data.get("header") or {})
        return HRIMessage(
            data.get("text", ""),
            tuple(_image(f"images/{index}", each) for index, each in enumerate(_list("images", data.get("images")))),
            tuple(_audio(f"audios/{index}", each) for index, each in enumerate(_list("audios", data.get("audios")))),
            author,
            header.get("frame_id", ""),
            data.get("communication_id", ""),
            data.get("seq_no", 0),
            data.get("seq_end", False),
            min(max(0.0, age_s or 0.0), OLDEST_S),
        )
    except UsageError as fault:
        raise ConnectorError(f"{place or TYPE}: {fault}") from None


def _stamp(at: float) -> dict[str, int]:
    """A `builtin_interfaces/msg/Time`."""
    return {"sec": int(at), "nanosec": int(at % 1 * 1e9)}


def _mapping(field: str, value: Any) -> Mapping[str, Any]:
    if not isinstance(value, Mapping):
        raise UsageError(f"{field}: {shown(value)} is given where the fields of a message belong")
    return value


def _list(field: str, value: Any) -> list[Any]:
    if value is not None and not isinstance(value, list | tuple):
        raise UsageError(f"{field}: {shown(value)} is no list")
    return list(value or ())


def _image(field: str, value: Any) -> Image:
    found = value if isinstance(value, Image) else _mapping(field, value).get("data")
    if not isinstance(found, Image):
        fields = value if isinstance(value, Mapping) else {}
        encoding, data = fields.get("encoding"), fields.get("data")
        if encoding in CHANNELS and isinstance(data, bytes):
            size = f"{fields.get('width')}x{fields.get('height')} pixels of {encoding}"
            step = fields.get("step")
            raise UsageError(f"{field}: {len(data)} bytes are no {size}, with {step} bytes a line")
        raise UsageError(
            f"{field}: encoding {shown(encoding)} is no picture that can be shown; those are {', '.join(CHANNELS)}"
        )
    try:
        data = found.data
    except Exception as fault:  # made when it is asked for, by whatever camera
        raise UsageError(f"{field}: the picture cannot be had: {shown(in_words(fault))}") from fault
    if found.encoding == "rgb8" and (min(found.width, found.height) < 1 or size_of(found) != len(data)):
        raise UsageError(f"{field}: {len(data)} bytes are no {found.width}x{found.height} pixels of rgb8")
    if found.encoding != "rgb8" and file_kind(data) != found.encoding:
        raise UsageError(f"{field}: {len(data)} bytes are no picture in {shown(found.encoding)}")
    return found


def _audio(field: str, value: Any) -> Audio:
    fields = _mapping(field, value)
    samples = fields.get("audio", ())
    if not isinstance(samples, bytes):
        samples = _bytes(f"{field}/audio", samples)
    try:
        return Audio(samples, fields.get("sample_rate", 0), fields.get("channels", 0))
    except UsageError as fault:
        raise UsageError(f"{field}: {fault}") from None


def _bytes(field: str, samples: Any) -> bytes:
    try:
        numbers = array("h", samples if isinstance(samples, list | tuple | array) else None)  # type: ignore[arg-type]
    except (TypeError, OverflowError, ValueError):
        raise UsageError(f"{field}: {shown(samples)} is no list of samples, whole numbers of 16 bits") from None
    if sys.byteorder == "big":
        numbers.byteswap()
    return numbers.tobytes()


def _numbers(samples: bytes) -> array[int]:
    numbers = array("h", samples)
    if sys.byteorder == "big":
        numbers.byteswap()
    return numbers
