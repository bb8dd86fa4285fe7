# SPDX-License-Identifier: Apache-2.0
"""What is to be recorded and waits, bounded by kind, in pieces and in bytes.

Rule: what has no room is not kept, and is counted by the name under which it came.
Rule: what waits of an item is its numbers and its value, one after the other in a `deque`. In a flood a tuple for each
would be what the garbage collector looks at.
Rule: one thread takes. Any thread puts, and waits for no other: `deque` is safe for that, `extend` from a tuple
included, and no count is kept of what a deque counts.
"""

from __future__ import annotations

import pickle
import threading
from collections import Counter, deque
from collections.abc import Callable
from typing import Any, Literal, NamedTuple, cast

import orjson

from rai_missions.recording.json_messages import image_in

__all__ = ("Kind", "QueuedItem", "RecordingQueue", "Route", "packed", "unpacked")

Kind = Literal["message", "raw", "picture", "row"]
MOST: dict[Kind, int] = {"message": 100_000, "raw": 100_000, "picture": 20, "row": 100_000}
"""How many of a kind wait at the most. A picture may have to be rendered first, which takes its time."""
MOST_BYTES: dict[Kind, int] = {"message": 64 << 20, "raw": 64 << 20, "picture": 64 << 20, "row": 64 << 20}
AS_IT_IS = orjson.OPT_PASSTHROUGH_DATACLASS | orjson.OPT_PASSTHROUGH_DATETIME | orjson.OPT_PASSTHROUGH_SUBCLASS
"""What is no plain data is refused."""


class Route(NamedTuple):
    """What becomes of items of one sort."""

    kind: Kind
    write: Callable[..., None]
    """Writes an item's value, with its times; called on the recording's own thread."""


QueuedItem = tuple[int, int, int, float, str, Any]
"""The number of its route; its bytes, or 0 where the bound in pieces is enough; the time of day at which it came, in
nanoseconds; when it was so, in seconds on the run's clock; the name under which it is counted; the value."""


FIELDS = 6
"""The number of fields of an item."""


class _Lane:
    """What waits of one kind, in its order."""

    def __init__(self, kind: Kind) -> None:
        self.fields: deque[Any] = deque()
        """The fields of the first item, then those of the next one."""
        self.most, self._most_bytes = FIELDS * MOST[kind], MOST_BYTES[kind]
        self._lock = threading.RLock()  # a signal may come on the thread that is putting
        self._bytes = 0

    def reserve(self, size: int) -> bool:
        """Have so many bytes more wait, if there is room for them."""
        with self._lock:
            has_room = self._bytes + size <= self._most_bytes
            self._bytes += size if has_room else 0
            return has_room

    def take(self) -> QueuedItem:
        pop = self.fields.popleft
        item: QueuedItem = (pop(), pop(), pop(), pop(), pop(), pop())
        if item[1]:
            self.reserve(-item[1])
        return item

    def clear(self) -> None:
        with self._lock:
            self.fields = deque()  # the thread that takes may be in the middle of an item
            self._bytes = 0

    @property
    def came_at(self) -> int:
        """When the first of its items came."""
        return cast("int", self.fields[2])


class RecordingQueue:
    """What waits; from any thread.

    Args:
        routes: What becomes of items, by number.
    """

    def __init__(self, routes: tuple[Route, ...]) -> None:
        self.routes = routes
        lanes = {kind: _Lane(kind) for kind in MOST}
        self._lanes, self._of_route = tuple(lanes.values()), [lanes[route.kind] for route in routes]
        self._filling = tuple(lane for kind, lane in lanes.items() if kind != "picture")
        self._lock = threading.RLock()  # as in a lane
        self._is_asleep = True
        self.dropped: Counter[str] = Counter()
        """Name → how many of it found no room."""

    @property
    def waiting(self) -> int:
        """How many items wait."""
        return sum(len(lane.fields) for lane in self._lanes) // FIELDS

    def put(self, item: QueuedItem) -> bool:
        """Have an item wait, if there is room for it; whether someone must be woken to take it."""
        lane = self._of_route[item[0]]
        if len(lane.fields) >= lane.most or (item[1] and not lane.reserve(item[1])):
            with self._lock:
                self.dropped[item[4]] += 1
            return False
        lane.fields.extend(item)
        if self._is_asleep:  # looked at only now: the thread that falls asleep looks again at what waits
            self._is_asleep = False
            return True
        return False

    def take(self) -> QueuedItem | None:
        """The item that came first of those that wait; None where none waits: the next `put` returns True then."""
        lane = self._next()
        if lane is None:
            self._is_asleep = True
            lane = self._next()
            if lane is None:
                return None
            self._is_asleep = False  # it came meanwhile, and may have woken no one
        return lane.take()

    def _next(self) -> _Lane | None:
        filled = [lane for lane in self._lanes if lane.fields]
        return min(filled, key=lambda lane: lane.came_at) if len(filled) > 1 else filled[0] if filled else None

    def clear(self) -> None:
        """Let go what waits."""
        for lane in self._lanes:
            lane.clear()

    @property
    def is_filling(self) -> bool:
        """There is little room left: half of what may wait does. A picture takes its time, and counts for nothing."""
        return any(2 * len(lane.fields) >= lane.most for lane in self._filling)


def packed(given: tuple[Any, ...]) -> Any:
    """Values at which no search for garbage looks: JSON, or a pickle of what JSON has not, such as NaN.

    What cannot be packed, and what has a picture, is as it is. JSON takes half the time of a pickle. It is
    kept as text: the bytes that orjson gives take a page of memory each as long as they are held.
    """
    try:
        text = orjson.dumps(given, None, AS_IT_IS).decode()
    except Exception:  # noqa: BLE001 - whatever a value of a robot's program raises, it is recorded as it is
        return _pickled(given)
    return _pickled(given) if "null" in text else text


def _pickled(given: tuple[Any, ...]) -> Any:
    try:
        has_picture = any(type(each) is not str and image_in(each) is not None for each in given)
        return given if has_picture else pickle.dumps(given, pickle.HIGHEST_PROTOCOL)
    except Exception:  # noqa: BLE001 - as above
        return given


def unpacked(given: Any) -> tuple[Any, ...]:
    """What was `packed`."""
    if type(given) is str:
        return tuple(orjson.loads(given))
    return cast("tuple[Any, ...]", pickle.loads(given) if type(given) is bytes else given)
