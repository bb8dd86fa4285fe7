# SPDX-License-Identifier: Apache-2.0
"""What is to be recorded and waits, bounded by kind, in pieces and in bytes.

Rule: what has no room is not kept, and is counted by the name under which it came.
Rule: an item is a tuple of numbers and one value. In a flood the garbage collector looks at all that waits, and at no
tuple of numbers and bytes more than once.
"""

from __future__ import annotations

import pickle
import threading
from collections import Counter, deque
from collections.abc import Callable
from typing import Any, Literal, NamedTuple, cast

__all__ = ("Kind", "QueuedItem", "RecordingQueue", "Route", "packed", "unpacked")

Kind = Literal["message", "picture", "row"]
MOST: dict[Kind, int] = {"message": 100_000, "picture": 20, "row": 100_000}
"""How many of a kind wait at the most. A picture may have to be rendered first, which takes its time."""
MOST_BYTES: dict[Kind, int] = {
    "message": 64 << 20,
    "picture": 64 << 20,
    "row": 64 << 20,
}


class Route(NamedTuple):
    """What becomes of items of one sort."""

    kind: Kind
    write: Callable[..., None]
    """Writes an item's value, with its times; called on the recording's own thread."""


QueuedItem = tuple[int, int, int, float, str, Any]
"""The number of its route; its bytes, as far as they are known before it is written; the time of day at which it came,
in nanoseconds; when it was so, in seconds on the run's clock; the name under which it is counted; the value."""


class RecordingQueue:
    """What waits; from any thread.

    Args:
        routes: What becomes of items, by number.
    """

    def __init__(self, routes: tuple[Route, ...]) -> None:
        self.routes, self._kinds = routes, [route.kind for route in routes]
        self._lock = threading.RLock()  # a signal may come on the thread that is putting
        self._items: deque[QueuedItem] = deque()
        self._is_asleep = True
        self._count: dict[str, int] = dict.fromkeys(MOST, 0)
        self._bytes: dict[str, int] = dict.fromkeys(MOST, 0)
        self.dropped: Counter[str] = Counter()
        """Name → how many of it found no room."""

    @property
    def waiting(self) -> int:
        """How many items wait."""
        return len(self._items)

    def put(self, item: QueuedItem) -> bool:
        """Have an item wait, if there is room for it; whether someone must be woken to take it."""
        kind = self._kinds[item[0]]
        with self._lock:
            count, total = self._count[kind], self._bytes[kind] + item[1]
            if count >= MOST[kind] or total > MOST_BYTES[kind]:
                self.dropped[item[4]] += 1
                return False
            self._count[kind], self._bytes[kind] = count + 1, total
            self._items.append(item)
            is_first, self._is_asleep = self._is_asleep, False
            return is_first

    def take(self) -> QueuedItem | None:
        """The item that has waited longest; None where none waits: the next `put` returns True then."""
        with self._lock:
            if not self._items:
                self._is_asleep = True
                return None
            item = self._items.popleft()
            kind = self._kinds[item[0]]
            self._count[kind] -= 1
            self._bytes[kind] -= item[1]
            return item

    def clear(self) -> None:
        """Let go what waits."""
        with self._lock:
            self._items.clear()
            self._count, self._bytes = dict.fromkeys(MOST, 0), dict.fromkeys(MOST, 0)

    @property
    def is_filling(self) -> bool:
        """There is little room left: half of what may wait does. A picture takes its time, and counts for nothing."""
        return any(2 * self._count[kind] >= most for kind, most in MOST.items() if kind != "picture")


def packed(given: tuple[Any, ...]) -> Any:
    """Values as bytes, at which no search for garbage looks; as they are where they cannot be packed."""
    try:
        return pickle.dumps(given, pickle.HIGHEST_PROTOCOL)
    except Exception:  # noqa: BLE001 - whatever a value of a robot's program raises, it is recorded as it is
        return given


def unpacked(given: Any) -> tuple[Any, ...]:
    """What was `packed`."""
    return cast("tuple[Any, ...]", pickle.loads(given) if type(given) is bytes else given)
