# SPDX-License-Identifier: Apache-2.0
"""How many requests may be on their way at once: an ordinary ROS server forgets the eleventh without a word."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable

__all__ = ("AT_ONCE", "InFlightLimit")

AT_ONCE = 10
"""The depth of a ROS service's queue where nobody says otherwise."""
Leave = Callable[[], None]


class InFlightLimit:
    """Lets ten in at once; the others wait in order. On the runtime's thread only."""

    def __init__(self) -> None:
        self._inside: set[object] = set()
        self._waiting: deque[Callable[[Leave], None]] = deque()

    def enter(self, work: Callable[[Leave], None]) -> None:
        """Do something as soon as there is room; it is given what makes the room free again, once."""
        self._waiting.append(work)
        self._let_in()

    def _let_in(self) -> None:
        while self._waiting and len(self._inside) < AT_ONCE:
            key = object()
            self._inside.add(key)
            self._waiting.popleft()(lambda key=key: self._leave(key))  # type: ignore[misc]

    def _leave(self, key: object) -> None:
        if key in self._inside:
            self._inside.discard(key)
            self._let_in()
