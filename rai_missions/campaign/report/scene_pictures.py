# SPDX-License-Identifier: Apache-2.0
"""The pictures of scenes, as small as a report can carry them.

Rule: what a picture is, its first bytes state; what is neither PNG nor JPEG is left out and named.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

from rai_missions.campaign.store import ResultStore
from rai_missions.errors import ConnectorError
from rai_missions.image import ImageFile, file_kind
from rai_missions.redaction import cut
from rai_missions.tools.images import smaller

__all__ = ("LARGEST", "ScenePicture", "pictures_of")

LARGEST = 20_000
"""Bytes of the pictures of one scene."""
ALL = 9_000_000
"""Bytes of all pictures of a report."""
SIDE = 480
"""Pixels of the longer side of one that has to be made smaller."""
LEAST = 1_500
"""Bytes under which a picture shows nothing any more."""


class ScenePicture(NamedTuple):
    """A picture of a scene, or why it is not shown."""

    name: str
    file: ImageFile | None
    why: str = ""


def pictures_of(store: ResultStore, scenes: Iterable[str]) -> dict[str, tuple[ScenePicture, ...]]:
    """Scene → its pictures, each made small enough that all of them fit into the report."""
    names = sorted(set(scenes))
    most = min(LARGEST, ALL // max(1, len(names)))
    return {name: found for name in names if (found := _of_scene(store.pictures(name), most))}


def _of_scene(pictures: dict[str, bytes], most: int) -> tuple[ScenePicture, ...]:
    each = most // max(1, len(pictures))
    return tuple(_evidence(name, data, each) for name, data in sorted(pictures.items()))


def _evidence(name: str, data: bytes, most: int) -> ScenePicture:
    kind = file_kind(data)
    if not kind:
        return ScenePicture(name, None, "it is neither a PNG nor a JPEG file")
    if len(data) <= most:
        return ScenePicture(name, ImageFile(kind, data))
    if most < LEAST:
        return ScenePicture(name, None, "left out: there are too many pictures for one page; it is in the store")
    try:
        return ScenePicture(name, smaller(data, most, SIDE))
    except ConnectorError as error:
        return ScenePicture(name, None, cut(error, 200))
