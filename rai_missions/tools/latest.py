# SPDX-License-Identifier: Apache-2.0
"""Where a callback of the connector leaves what it received, and a tool waits for it.

Rule: a wait has an end: what was wanted, the time, or the end of the tools.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from typing import Generic, TypeVar

__all__ = ("Latest",)

T = TypeVar("T")


class Latest(Generic[T]):
    """Holds the newest of what was put in."""

    def __init__(self) -> None:
        self._changed = threading.Condition()
        self._is_closed = False
        self.value: T | None = None

    def put(self, value: T) -> None:
        with self._changed:
            self.value = value
            self._changed.notify_all()

    def close(self) -> None:
        """End the wait."""
        with self._changed:
            self._is_closed = True
            self._changed.notify_all()

    def wait(self, until: float, enough: Callable[[T], bool] = lambda _: True) -> T | None:
        """What is held, once it is enough; None if that does not come.

        Args:
            until: An instant of `time.monotonic`.
            enough: Whether it is what is waited for.
        """
        with self._changed:
            while not self._is_closed:
                if self.value is not None and enough(self.value):
                    return self.value
                left_s = until - time.monotonic()
                if left_s <= 0:
                    return None
                self._changed.wait(left_s)
            return None
