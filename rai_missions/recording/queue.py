# SPDX-License-Identifier: Apache-2.0
"""Where what is to be recorded waits: bounded, and never an obstacle to anyone who brings it.

Rule: `put` returns at once. What has no room is not kept, and is counted by the name under which it came.
"""

from __future__ import annotations

import threading
from collections import Counter, deque
from collections.abc import Callable
from typing import Literal, NamedTuple

__all__ = ("BoundedQueue", "Kind", "QueuedItem")

Kind = Literal["message", "picture", "row"]
MOST: dict[Kind, int] = {"message": 20_000, "picture": 20, "row": 100_000}
"""How many of a kind wait at the most. A picture may have to be rendered first, which takes its time."""
MOST_BYTES: dict[Kind, int] = {"message": 64 << 20, "picture": 64 << 20, "row": 64 << 20}
GATHER_S = 0.05
"""How long the first who waits, waits for others: one thread is woken once, not for each of them."""


class QueuedItem(NamedTuple):
    """Something that is to be recorded."""

    kind: Kind
    name: str
    """Under which it is counted: a topic, or a part of the mission."""
    size: int
    """Bytes, as far as they are known before it is written."""
    write: Callable[[], None]
    """Writes it; called on the recording's own thread."""


class BoundedQueue:
    """A queue from any thread to one."""

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._queue: deque[QueuedItem] = deque()
        self._count: Counter[str] = Counter()
        self._bytes: Counter[str] = Counter()
        self._some = threading.Event()
        self._closing = threading.Event()
        self.dropped: Counter[str] = Counter()
        """Name → how many of it found no room."""

    def put(self, waiting: QueuedItem) -> bool:
        """Let something wait; False if there was no room, or the room is closed."""
        kind = waiting.kind
        with self._lock:
            if self._closing.is_set():
                return False
            if self._count[kind] >= MOST[kind] or self._bytes[kind] + waiting.size > MOST_BYTES[kind]:
                self.dropped[waiting.name] += 1
                return False
            self._count[kind] += 1
            self._bytes[kind] += waiting.size
            self._queue.append(waiting)
            is_first = len(self._queue) == 1
        if is_first:
            self._some.set()
        return True

    def await_some(self, timeout_s: float | None) -> None:
        """Return when some have gathered, after so many seconds, or when the room is closed."""
        if self._some.wait(timeout_s):
            self._closing.wait(GATHER_S)

    def rest(self, seconds: float) -> None:
        """Let others work for a while, unless the room fills up or is closed."""
        if all(2 * self._count[kind] < most for kind, most in MOST.items() if kind != "picture"):
            self._closing.wait(seconds)

    def take(self) -> QueuedItem | None:
        """The one who has waited longest; None if no one does."""
        with self._lock:
            if not self._queue:
                if not self._closing.is_set():
                    self._some.clear()
                return None
            taken = self._queue.popleft()
            self._count[taken.kind] -= 1
            self._bytes[taken.kind] -= taken.size
            return taken

    def close(self) -> None:
        """No one else comes in; those who wait can still be taken."""
        with self._lock:
            self._closing.set()
        self._some.set()

    def clear(self) -> None:
        """No one waits any longer."""
        with self._lock:
            self._queue.clear()
            self._count.clear()
            self._bytes.clear()

    @property
    def closed(self) -> bool:
        return self._closing.is_set()
