# SPDX-License-Identifier: Apache-2.0
"""The profile's format as JSON Schema (2020-12), for editors.

Rule: it refuses nothing that the models take; they have the last word on what they refuse.
"""

from __future__ import annotations

from typing import Any

from rai_missions.mission.schema import schema_of
from rai_missions.profile.entries import ActionEntry
from rai_missions.profile.profile import Robot
from rai_missions.profile.sources import EventSource, Source

__all__ = ("robot_schema",)

SOURCES = {
    "oneOf": [{"required": ["topic"]}, {"required": ["service"]}],
    "dependentRequired": {"service": ["every_s"], "every_s": ["service"]},
}
POSTED = {"properties": {"posted": {"const": True}}, "required": ["posted"]}
RULES: dict[str, dict[str, Any]] = {
    Source.__name__: SOURCES,
    EventSource.__name__: {"if": POSTED, "then": {"not": {"anyOf": SOURCES["oneOf"]}}, "else": SOURCES},
    ActionEntry.__name__: {
        "oneOf": [{"required": ["action"]}, {"required": ["start", "succeeded"]}],
        "not": {"required": ["action", "start"]},
    },
}
"""Model → what its validators ask beyond the types of its fields."""


def robot_schema() -> dict[str, Any]:
    """The JSON Schema of a robot profile's file."""
    schema = schema_of(Robot, "A robot profile of rai_missions")
    definitions = {name: inner | RULES.get(name, {}) for name, inner in schema["$defs"].items()}
    connector = schema["properties"]["connector"] | {"required": ["kind"], "properties": {"kind": {"type": "string"}}}
    properties = {"$schema": {"type": "string"}, **schema["properties"], "connector": connector}
    return {**schema, "properties": properties, "$defs": definitions}
