# SPDX-License-Identifier: Apache-2.0
"""The map by which a run moves from one mission into another: what has become of states, keys and events.

Rule: it is data. What it does not name keeps its name.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

from pydantic import Field

from rai_missions.mission.json_reader import read_json
from rai_missions.mission.schema import schema_of
from rai_missions.model import Format, Json, MissionModel, Name, Text
from rai_missions.model.validation_errors import validated

__all__ = ("Map", "load_map", "map_schema")


class Map(MissionModel):
    """What has become of a mission's names."""

    format: Format = 1
    about: Text = ""
    states: dict[Name, Name | None] = Field(default_factory=dict)
    """State then → state now; null: it is left, and nothing takes its place. A name states
    that it means what the old one meant, though it may be written otherwise."""
    keys: dict[Name, Name | None] = Field(default_factory=dict)
    """Key then → key now; null: its value is dropped."""
    events: dict[Name, Name | None] = Field(default_factory=dict)
    """Event then → event now; null: one that is to be raised later, or waits for the end of a pause, is dropped."""
    values: dict[Name, Json] = Field(default_factory=dict)
    """Key now → the value with which the run continues, instead of the one that it had."""


def load_map(path: str | os.PathLike[str]) -> Map:
    """The map in a JSON file.

    Raises:
        DefinitionError: It is at fault; every fault with its pointer.
        UsageError: There is no such file.
    """
    file = Path(path)
    data = read_json(file)
    if isinstance(data, dict):
        data = {word: value for word, value in data.items() if word != "$schema"}
    return validated(Map, data, str(file))


def map_schema() -> dict[str, Any]:
    """The JSON Schema of a map."""
    schema = schema_of(Map, "A map by which a run of rai_missions continues in a mission that has changed")
    schema["properties"]["$schema"] = {"type": "string"}
    for word in ("states", "keys", "events"):  # models are schemas without null, and here it means that nothing is left
        patterns = schema["properties"][word]["patternProperties"]
        schema["properties"][word]["patternProperties"] = {
            pattern: {"anyOf": [name, {"type": "null"}]} for pattern, name in patterns.items()
        }
    return schema
