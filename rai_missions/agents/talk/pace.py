# SPDX-License-Identifier: Apache-2.0
"""How fast sentences may come through a door: no one talks faster, and a flood slows no run."""

from __future__ import annotations

import threading
import time

__all__ = ("DoorPace",)

EVERY_S, MOST = 0.1, 20
MOST_DOORS = 64


class DoorPace:
    """Ten sentences a second for each door and role, and twenty at once."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._left: dict[str, tuple[float, float]] = {}
        """Door → sentences left, and when that was so."""

    def take(self, door: str) -> bool:
        """Whether another sentence may come now."""
        now = time.monotonic()
        with self._lock:
            left, at = self._left.get(door, (float(MOST), now))
            left = min(float(MOST), left + (now - at) / EVERY_S)
            if door in self._left or len(self._left) < MOST_DOORS:
                self._left[door] = max(0.0, left - 1.0), now
            return left >= 1.0
