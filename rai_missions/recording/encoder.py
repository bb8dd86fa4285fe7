# SPDX-License-Identifier: Apache-2.0
"""Writes what happened into the file, each in its own form.

Rule: only the recording's own thread comes here, so what takes long, such as rendering, holds up no one else.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any, NamedTuple

import orjson

from rai_missions.connectors.connector import Message, RawMessage
from rai_missions.journal import Blob, Raw, decode
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import plain
from rai_missions.recording.json_messages import image_in, log_of, picture_of, step_of
from rai_missions.recording.schemas import JOURNAL, LOG, STEP, Schema, described

if TYPE_CHECKING:
    from rai_missions.recording.mcap_writer import File

__all__ = ("JOURNAL_TOPIC", "TOPIC", "MessageEncoder", "When")

TOPIC = "/rai_missions/"
"""What the topics of the mission's own begin with."""
JOURNAL_TOPIC = f"{TOPIC}journal"


class When(NamedTuple):
    """When something was so, in nanoseconds."""

    wall: int
    """The time of day at which it came."""
    run: int
    """The time of day by the run's clock: that at which the run's clock showed 0, and what it showed then."""


class MessageEncoder:
    """Writes a run.

    Args:
        file: Where to.
        mission: Whose run it is.
    """

    def __init__(self, file: File, mission: Mission) -> None:
        self._file, self._mission = file, mission
        self._schemas: dict[str, Schema] = {}
        self._rows: set[int] = set()
        self._blobs: set[str] = set()

    def json(self, topic: str, schema: Schema, content: Any, when: When) -> None:
        """A message as JSON."""
        channel = self._file.channel(topic, "json", schema.name, "jsonschema", schema.text)
        self._file.add(channel, _text_of(content), when.wall, when.run)

    def raw(self, message: RawMessage, definition: str, when: When) -> None:
        """A message of ROS, byte for byte."""
        channel = self._file.channel(message.topic, "cdr", message.type, "ros2msg", definition, message.quality)
        self._file.add(channel, message.data, when.wall, when.run)

    def received(self, message: Message, type_name: str, when: When) -> None:
        """A message as plain data."""
        image = image_in(message.data)
        if image is not None:
            schema, shown = picture_of(image, message.data, when.run)
            self.json(message.topic, schema, shown, when)
            return
        content = plain(message.data)
        if message.topic not in self._schemas:
            self._schemas[message.topic] = described(type_name or f"message of {message.topic}", content)
        self.json(message.topic, self._schemas[message.topic], content, when)

    def row(self, raw: Raw, blobs: Iterable[Blob], when: When) -> None:
        """A row of the journal with the pictures that it refers to, and what it reports, for those who only look."""
        number, kind, content, digest = raw
        self._rows.add(number)
        self.attach(blobs, when)
        self.json(JOURNAL_TOPIC, JOURNAL, {"row": number, "kind": kind, "content": content, "hash": digest}, when)
        if kind == "step":
            step = step_of(decode(json.loads(content)["step"]))
            self.json(f"{TOPIC}steps", STEP, step, when)
            self.json(f"{TOPIC}log", LOG, log_of(step, self._mission.name, when.run), when)

    def attach(self, blobs: Iterable[Blob], when: When) -> None:
        """The pictures that the journal keeps, each once."""
        for name, media_type, data in blobs:
            if name not in self._blobs:
                self._blobs.add(name)
                self._file.attach(name, media_type, data, when.wall)

    def lacks(self, number: int) -> bool:
        """A row has not been written."""
        return number not in self._rows


def _text_of(content: Any) -> bytes:
    """JSON; the library of Python writes what orjson refuses: a long integer, or half a surrogate pair.

    It reads them as well, where orjson makes a long integer a number with a point.
    """
    try:
        return orjson.dumps(content)
    except TypeError:
        return json.dumps(content, separators=(",", ":")).encode()
