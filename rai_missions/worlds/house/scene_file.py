# SPDX-License-Identifier: Apache-2.0
"""A scene of the house as data: its objects and people, from a file of JSON or as an option's value."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.errors import UsageError
from rai_missions.worlds.options import check_names
from rai_missions.worlds.scene_files import read_scene_file

__all__ = ("read_scene",)

WORDS = ("about", "objects", "people")


def read_scene(scene: str | Mapping[str, Any] | None) -> Mapping[str, Any]:
    """A scene's words; a file's name is read.

    Raises:
        UsageError: The file cannot be read, or it has a word that does not exist.
    """
    given: Any = read_scene_file(scene) if isinstance(scene, str) else (scene or {})
    if not isinstance(given, Mapping):
        raise UsageError(f"scene: {scene!r} holds no object; give one with {', '.join(WORDS)}")
    check_names("scene", given, WORDS, called="word")
    return given
