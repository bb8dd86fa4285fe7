# SPDX-License-Identifier: Apache-2.0
"""Pictures that a question showed, as `data:` URIs of PNG and JPEG.

Rule: what a picture is, its first bytes state and no one's word for it; what is neither is not shown.
"""

from __future__ import annotations

from rai_missions.errors import MissionError
from rai_missions.image import Image
from visualize.page.as_json import Json

__all__ = ("BUDGET", "Gallery")

SMALL = 6
"""zlib's level: a page is kept and sent around."""
BUDGET = 64 * 1024 * 1024
"""Bytes of pictures that one page holds; a browser opens no page of gigabytes."""


class Gallery:
    """The pictures of a page, each once.

    Args:
        budget: Bytes of pictures that are taken.
    """

    def __init__(self, budget: int = BUDGET) -> None:
        self.shown: dict[str, Json] = {}
        """Hash → the picture's `uri`, or `why` it is not shown."""
        self._left = budget

    def add(self, image: Image) -> str:
        """The name under which a picture is in the page."""
        try:
            name = image.digest
        except MissionError as error:
            name = f"not kept: {image.ref}"
            self.shown.setdefault(name, {"why": str(error)})
            return name
        if name not in self.shown:
            self.shown[name] = self._entry(image)
        return name

    def _entry(self, image: Image) -> Json:
        try:
            file = image.file(level=SMALL)
        except ValueError as error:
            return {"why": str(error)}
        if len(file.data) > self._left:
            return {"why": f"left out: the page holds at most {BUDGET >> 20} MiB of pictures"}
        self._left -= len(file.data)
        return {"uri": f"data:{file.media_type};base64,{file.base64}"}
