# SPDX-License-Identifier: Apache-2.0
"""The file that is written: the one place that knows mcap's writer.

Rule: everything happens on the recording's own thread. What raises here ends the recording, not the run.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import IO, Any

from mcap.writer import CompressionType, Writer

__all__ = ("File",)

LATEST_NS = 2**63 - 1


class File:
    """Topics, messages, attachments and metadata, in compressed chunks.

    Args:
        stream: Where to write; closed by `finish`.
        profile: MCAP's own: `ros2` where the robot's messages are those of ROS 2, else empty.
    """

    def __init__(self, stream: IO[bytes], profile: str = "") -> None:
        self._stream = stream
        self._writer: Any = Writer(stream, compression=CompressionType.ZSTD)
        self._writer.start(profile=profile, library="rai_missions")
        self._schemas: dict[tuple[str, str], int] = {}
        self._channels: dict[tuple[str, int], int] = {}
        self._sequence: dict[int, int] = {}
        self.messages = 0

    def channel(
        self, topic: str, encoding: str, schema: str, schema_encoding: str, text: str, quality: str | None = None
    ) -> int:
        """The number of a topic's channel; made when it is first asked for.

        Args:
            topic: Its name.
            encoding: The encoding of its messages: `cdr` or `json`.
            schema: The name of what they are.
            schema_encoding: Of `text`: `ros2msg` or `jsonschema`.
            text: The definition by which they are read.
            quality: Of a topic of ROS 2: what its publishers offer, as bags write it.
        """
        known = self._schemas.get((schema, text))
        if known is None:
            known = self._writer.register_schema(schema, schema_encoding, text.encode())
            self._schemas[schema, text] = known
        if (topic, known) not in self._channels:
            words = {} if quality is None else {"offered_qos_profiles": quality}
            self._channels[topic, known] = self._writer.register_channel(topic, encoding, known, words)
        return self._channels[topic, known]

    def add(self, channel: int, data: bytes, log_ns: int, publish_ns: int) -> None:
        """Write a message."""
        self._sequence[channel] = number = self._sequence.get(channel, 0) + 1
        self._writer.add_message(channel, log_ns, data, min(max(0, publish_ns), LATEST_NS), number)
        self.messages += 1

    def attach(self, name: str, media_type: str, data: bytes, log_ns: int) -> None:
        """Write bytes under a name."""
        self._writer.add_attachment(log_ns, log_ns, name, media_type, data)

    def describe(self, name: str, words: Mapping[str, Any]) -> None:
        """Write words about the recording, which outlive the process; those of its end come after a `flush`."""
        self._writer.add_metadata(
            name, {word: value if isinstance(value, str) else json.dumps(value) for word, value in words.items()}
        )
        self._stream.flush()

    def flush(self) -> None:
        """Whatever was written outlives the process from here on."""
        self._writer.flush()

    def finish(self) -> int:
        """Write the index and close; gives the file's bytes."""
        self._writer.finish()
        self._stream.flush()
        size = self._stream.tell()
        self._stream.close()
        return size

    def abandon(self) -> None:
        """Close it as it is; raises what closing raises, and is closed all the same."""
        self._stream.close()
