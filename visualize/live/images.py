# SPDX-License-Identifier: Apache-2.0
"""Pictures for viewers: encoded when someone looks, once for all of them, and no more often than the page shows.

Rule: what a picture is, its first bytes state and no one's word for it; what is neither PNG nor JPEG is not sent.
"""

from __future__ import annotations

import asyncio
import time
from collections.abc import Callable

from rai_missions.image import Image

__all__ = ("ImageStream",)

EVERY_S = 0.25
"""The shortest time between two pictures of one key."""
MOST_BYTES = 16 * 1024 * 1024
Shown = tuple[str, bytes]
"""Media type and bytes; for one that cannot be shown an empty type and why."""


class ImageStream:
    """What one key shows. All of it is called on the server's loop; encoding is done on a thread next to it."""

    def __init__(self) -> None:
        self._lock = asyncio.Lock()
        self._ref, self._shown, self._next = "", ("", b"never received"), 0.0

    async def show(self, newest: Callable[[], Image | None]) -> Shown:
        """The newest picture, or the one before where that is only just old."""
        async with self._lock:
            image = newest()
            if image is None:
                return "", b"there is no such picture"
            if image.ref != self._ref:
                await asyncio.sleep(max(0.0, self._next - time.monotonic()))
                image = newest() or image
                self._shown = await asyncio.to_thread(_encoded, image)
                self._ref, self._next = image.ref, time.monotonic() + EVERY_S
            return self._shown


def _encoded(image: Image) -> Shown:
    try:
        file = image.file()
    except Exception as error:  # noqa: BLE001 - whatever makes a picture is not trusted to; the viewer is informed
        return "", str(error)[:300].encode()
    if len(file.data) > MOST_BYTES:
        return "", f"{len(file.data)} bytes are too many".encode()
    return file.media_type, file.data
