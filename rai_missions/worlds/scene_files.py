# SPDX-License-Identifier: Apache-2.0
"""A file that a scene of a world is read from."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rai_missions.errors import UsageError
from rai_missions.redaction import shown

__all__ = ("read_scene_file", "with_scene_read")

LARGEST = 1_000_000
"""Bytes of a file."""
LONGEST_PATH = 200
"""Characters of a path in a message."""


def read_scene_file(path: str) -> Any:
    """What a file of JSON holds.

    Raises:
        UsageError: It cannot be read, is too large, or is no JSON.
    """
    name = shown(path, LONGEST_PATH)
    try:
        with Path(path).open("rb") as file:
            data = file.read(LARGEST + 1)
    except (OSError, ValueError) as fault:
        raise UsageError(f"scene: {name} cannot be read: {getattr(fault, 'strerror', None) or fault}") from fault
    if len(data) > LARGEST:
        raise UsageError(f"scene: {name} has more than {LARGEST} bytes; a scene has at most as many")
    try:
        return json.loads(data)
    except (ValueError, RecursionError) as fault:
        raise UsageError(f"scene: {name} is no JSON: {fault}") from fault


def with_scene_read(options: Mapping[str, Any], folder: Path) -> Mapping[str, Any]:
    """The options of a world as a file has them, with what is in the file that their scene names.

    Args:
        options: As they are written.
        folder: The folder of the file that has them; the scene's file is found from there.

    Raises:
        UsageError: As `read_scene_file`.
    """
    name = options.get("scene")
    return {**options, "scene": read_scene_file(str(folder / name))} if isinstance(name, str) else options
