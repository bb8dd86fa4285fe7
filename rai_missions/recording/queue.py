# SPDX-License-Identifier: Apache-2.0
"""How much of what is to be recorded may wait, by kind, in pieces and in bytes.

Rule: what has no room is not kept, and is counted by the name under which it came.
"""

from __future__ import annotations

import threading
from collections import Counter
from collections.abc import Callable
from typing import Any, Literal, NamedTuple

__all__ = ("Kind", "QueueBudget", "QueuedItem")

Kind = Literal["message", "picture", "row"]
MOST: dict[Kind, int] = {"message": 100_000, "picture": 20, "row": 100_000}
"""How many of a kind wait at the most. A picture may have to be rendered first, which takes its time."""
MOST_BYTES: dict[Kind, int] = {"message": 64 << 20, "picture": 64 << 20, "row": 64 << 20}


class QueuedItem(NamedTuple):
    """Something that is to be recorded."""

    kind: Kind
    name: str
    """Under which it is counted: a topic, or a part of the mission."""
    size: int
    """Bytes, as far as they are known before it is written."""
    wall: int
    run: int
    """When it was so, in nanoseconds: by the time of day at which it came, and by the run's clock."""
    write: Callable[..., None]
    """Writes what is `given`, with its times; called on the recording's own thread."""
    given: tuple[Any, ...]


class QueueBudget:
    """How much of each kind waits; from any thread."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._count: Counter[str] = Counter()
        self._bytes: Counter[str] = Counter()
        self.dropped: Counter[str] = Counter()
        """Name → how many of it found no room."""

    def enter(self, item: QueuedItem) -> bool:
        """Count an item in; False if there is no room for it."""
        kind = item.kind
        with self._lock:
            is_full = self._count[kind] >= MOST[kind] or self._bytes[kind] + item.size > MOST_BYTES[kind]
            if is_full:
                self.dropped[item.name] += 1
            else:
                self._count[kind] += 1
                self._bytes[kind] += item.size
        return not is_full

    def leave(self, item: QueuedItem) -> None:
        """Count an item out: it waits no longer."""
        with self._lock:
            self._count[item.kind] -= 1
            self._bytes[item.kind] -= item.size

    @property
    def is_filling(self) -> bool:
        """There is little room left: half of what may wait does. A picture takes its time, and counts for nothing."""
        return any(2 * self._count[kind] >= most for kind, most in MOST.items() if kind != "picture")
