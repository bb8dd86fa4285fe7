# SPDX-License-Identifier: Apache-2.0
"""A scene of the house as data: its objects and people, from a file of JSON or as an option's value."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rai_missions.errors import UsageError, suggestion

__all__ = ("read_scene",)

WORDS = ("about", "objects", "people")
LARGEST = 1_000_000
"""Bytes of a file."""


def read_scene(scene: str | Mapping[str, Any] | None) -> Mapping[str, Any]:
    """A scene's words; a file's name is read.

    Raises:
        UsageError: The file cannot be read, or it has a word that does not exist.
    """
    given: Any = _file(scene) if isinstance(scene, str) else (scene or {})
    if not isinstance(given, Mapping):
        raise UsageError(f"scene: {scene!r} holds no object; give one with {', '.join(WORDS)}")
    for word in given:
        if word not in WORDS:
            raise UsageError(f"scene: no word {word!r}{suggestion(str(word), WORDS)}")
    return given


def _file(path: str) -> Any:
    try:
        data = Path(path).read_bytes()
    except OSError as fault:
        raise UsageError(f"scene: '{path}' cannot be read: {fault.strerror}") from fault
    if len(data) > LARGEST:
        raise UsageError(f"scene: '{path}' has {len(data)} bytes; a scene has at most {LARGEST}")
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as fault:
        raise UsageError(f"scene: '{path}' is no JSON: {fault}") from fault
