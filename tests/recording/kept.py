# SPDX-License-Identifier: Apache-2.0
"""What is in a recording, as any program that knows MCAP reads it."""

from __future__ import annotations

import json
from collections import defaultdict
from pathlib import Path
from typing import Any, NamedTuple

from mcap.reader import make_reader

from rai_missions.mission.mission import Mission
from rai_missions.profile import Robot
from rai_missions.recording import Recording

__all__ = ("LAMP", "ReadRecording", "kept", "recording", "robot")

LAMP = Mission.model_validate(
    {
        "name": "lamp",
        "blackboard": {
            "battery": {"type": "number", "source": "robot"},
            "camera": {"type": "image", "source": "robot", "optional": True},
            "speech": {"type": "object", "source": "robot", "optional": True},
            "count": {"type": "integer", "source": "mission", "initial": 0},
        },
        "initial": "on",
        "states": {
            "on": {
                "transitions": [
                    {"when": {"key": "battery", "<": 0.2}, "to": "off"},
                    {"when": {"key": "battery", "<": 0.5}, "do": [{"set": "count", "add": 1}], "to": "dim"},
                ]
            },
            "dim": {"transitions": [{"when": {"key": "battery", "<": 0.2}, "to": "off"}]},
            "off": {"final": "aborted"},
        },
    }
)
"""A mission that continues as long as its battery does."""


def robot(kind: str, **words: Any) -> Robot:
    """The profile of a robot for it, on a kind of connector; words are more of its sections."""
    facts = {
        "battery": {"topic": "/battery", "type": "sensor_msgs/msg/BatteryState", "field": "percentage"},
        "camera": {"topic": "/camera", "type": "sensor_msgs/msg/Image"},
        "speech": {"topic": "/speech", "type": "std_msgs/msg/String", "json": True},
    }
    return Robot.model_validate({"name": "a lamp", "connector": {"kind": kind}, "blackboard": facts, **words})


def recording(path: Path, **words: Any) -> Recording:
    """A recording of the lamp, whose clock shows 0; words count instead of its own."""
    return Recording.create(path, **{"mission": LAMP, "about": {}, "now": lambda: 0.0, **words})


class ReadRecording(NamedTuple):
    """A recording that has been read."""

    messages: dict[str, list[Any]]
    """Topic → its messages, those in JSON as values."""
    schemas: dict[str, list[tuple[str, str, str]]]
    """Topic → name, encoding and text of the schema of each of its messages."""
    metadata: dict[str, dict[str, str]]
    attachments: dict[str, bytes]
    times: dict[str, list[tuple[int, int]]]
    """Topic → log time and publish time of each."""


def kept(path: Path) -> ReadRecording:
    messages, schemas, times = defaultdict(list), defaultdict(list), defaultdict(list)
    with path.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        for schema, channel, message in reader.iter_messages():
            assert schema is not None
            is_json = channel.message_encoding == "json"
            messages[channel.topic].append(json.loads(message.data) if is_json else message.data)
            times[channel.topic].append((message.log_time, message.publish_time))
            schemas[channel.topic].append((schema.name, schema.encoding, schema.data.decode()))
        metadata = {each.name: each.metadata for each in reader.iter_metadata()}
        attachments = {each.name: each.data for each in reader.iter_attachments()}
    return ReadRecording(dict(messages), dict(schemas), metadata, attachments, dict(times))
