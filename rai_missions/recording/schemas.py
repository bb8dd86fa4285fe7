# SPDX-License-Identifier: Apache-2.0
"""What the messages of a recording look like, as JSON Schemas.

Rule: a schema has nothing but objects with `properties`, lists of one kind of item, and plain values, each with its
`type`. Foxglove reads no more, and does not open a topic whose schema states something else; what cannot be stated it
is left out of the schema, and is in the message all the same.
Source: the schemas that Foxglove publishes (foxglove-sdk, schemas/jsonschema: CompressedImage, RawImage, Log).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

__all__ = ("BLACKBOARD", "CALL", "COMPRESSED_IMAGE", "GOAL", "JOURNAL", "LOG", "RAW_IMAGE", "STATUS", "STEP", "Schema",
           "described")  # fmt: skip

Json = dict[str, Any]


class Schema(NamedTuple):
    """The name of what a message is, and how it is read."""

    name: str
    text: str
    """JSON."""


def _object(**properties: Json) -> Json:
    return {"type": "object", "properties": properties}


def _list(item: Json) -> Json:
    return {"type": "array", "items": item}


def _schema(title: str, about: str, /, **properties: Json) -> Schema:
    whole = {
        "$schema": "https://json-schema.org/draft/2020-12/schema",
        "title": title,
        "description": about,
        **_object(**properties),
        "required": list(properties),
    }
    return Schema(title, json.dumps(whole))


TEXT, NUMBER, INTEGER, TRUTH = ({"type": name} for name in ("string", "number", "integer", "boolean"))
BYTES: Json = {"type": "string", "contentEncoding": "base64"}
COUNT: Json = {"type": "integer", "minimum": 0}
TIME: Json = {
    "title": "time",
    **_object(sec=COUNT, nsec={**COUNT, "maximum": 999_999_999}),
}
LEVELS = ("UNKNOWN", "DEBUG", "INFO", "WARNING", "ERROR", "FATAL")
LEVEL: Json = {"title": "foxglove.LogLevel", "oneOf": [{"title": name, "const": n} for n, name in enumerate(LEVELS)]}

COMPRESSED_IMAGE = _schema(
    "foxglove.CompressedImage", "A compressed image", timestamp=TIME, frame_id=TEXT, data=BYTES, format=TEXT
)
RAW_IMAGE = _schema(
    "foxglove.RawImage",
    "A raw image",
    timestamp=TIME,
    frame_id=TEXT,
    width=COUNT,
    height=COUNT,
    encoding=TEXT,
    step=COUNT,
    data=BYTES,
)
LOG = _schema(
    "foxglove.Log", "A log message", timestamp=TIME, level=LEVEL, message=TEXT, name=TEXT, file=TEXT, line=COUNT
)
JOURNAL = _schema(
    "rai_missions.JournalRow",
    "A row of the journal, exactly; the rows in the order of their numbers are the journal",
    row=COUNT,
    kind=TEXT,
    content=TEXT,
    hash=TEXT,
)
STEP = _schema(
    "rai_missions.Step",
    "Everything that one event did",
    seq=COUNT,
    at=NUMBER,
    event=_object(name=TEXT, kind=TEXT, at=NUMBER, number=COUNT),
    exited=_list(TEXT),
    entered=_list(TEXT),
    taken=_list(TEXT),
    guards=_list(_object(place=TEXT, value=TEXT)),
    verdicts=_list(TEXT),
    notes=_list(TEXT),
    effects=_list(_object(name=TEXT, about=TEXT)),
    outcome=TEXT,
    why=TEXT,
)
STATUS = _schema(
    "rai_missions.Status",
    "What every other agent reads instead of remembering it",
    revision=COUNT,
    mode=TEXT,
    control=TEXT,
    state=TEXT,
    active=_list(TEXT),
    outcome=TEXT,
    why=TEXT,
)
BLACKBOARD = _schema(
    "rai_missions.BlackboardWrite",
    "A key that was written; `value` is any JSON, `number` only where it is one (1 for true), `text` is it in short",
    key=TEXT,
    at=NUMBER,
    text=TEXT,
)
CALL = _schema(
    "rai_missions.Call",
    "How a service answered; `data` is any JSON",
    service=TEXT,
    request=TEXT,
    outcome=TEXT,
    why=TEXT,
    seconds=NUMBER,
)
GOAL = _schema(
    "rai_missions.Goal", "What became of a goal; `data` is any JSON", action=TEXT, goal_id=TEXT, said=TEXT, why=TEXT
)


def described(name: str, sample: Mapping[str, Any]) -> Schema:
    """A schema of messages that come without one, by the first of them."""
    return Schema(name, json.dumps({"title": name, **(_kind(sample) or _object())}))


def _kind(value: Any) -> Json | None:
    if isinstance(value, bool):
        return TRUTH
    if isinstance(value, int | float):
        return NUMBER
    if isinstance(value, str):
        return TEXT
    if isinstance(value, Mapping):
        fields = {str(name): _kind(item) for name, item in value.items()}
        return _object(**{name: kind for name, kind in fields.items() if kind is not None})
    if isinstance(value, list | tuple) and value:
        kinds = [_kind(item) for item in value]
        first = kinds[0]
        if first is not None and first["type"] != "array" and all(each == first for each in kinds):
            return _list(first)
    return None
