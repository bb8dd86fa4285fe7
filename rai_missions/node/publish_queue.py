# SPDX-License-Identifier: Apache-2.0
"""Publishes what the node says, on a thread of its own, so that anyone who has something to say continues at once.

Rule: what is said leaves in the order in which it was said. A backlog is bounded: its oldest steps are dropped first.
"""

from __future__ import annotations

import threading
import time
from collections import deque
from collections.abc import Callable

from rai_missions.redaction import logger

__all__ = ("PublishQueue",)

log = logger(__name__)

Work = Callable[[], None]
LONGEST_QUEUE = 10_000
EVERY_S = 1.0


class PublishQueue:
    """Does what it is given, one after the other, and something else once a second.

    Args:
        each_second: Done about every second while it runs.
    """

    def __init__(self, each_second: Work) -> None:
        self._each_second = each_second
        self._queue: deque[Work] = deque()
        self._changed = threading.Condition()
        self._is_open = False
        self._is_puzzled = False
        self._thread: threading.Thread | None = None

    def run(self) -> None:
        """Begin."""
        with self._changed:
            if not self._is_open:
                self._is_open = True
                self._thread = threading.Thread(target=self._work, name="outlet", daemon=True)
                self._thread.start()

    def stop(self, within_s: float = 5.0) -> None:
        """Do what waits, and end."""
        with self._changed:
            self._is_open = False
            self._changed.notify_all()
            thread, self._thread = self._thread, None
        if thread is not None and thread is not threading.current_thread():
            thread.join(within_s)

    def put(self, work: Work) -> None:
        """Have something done soon; from any thread, at once."""
        with self._changed:
            if len(self._queue) >= LONGEST_QUEUE:
                self._queue.popleft()
                self._puzzle("more is said than can be published; the oldest is dropped")
            self._queue.append(work)
            self._changed.notify()

    def _work(self) -> None:
        due = time.monotonic()
        while True:
            with self._changed:
                self._changed.wait_for(lambda: self._queue or not self._is_open, max(0.0, due - time.monotonic()))
                work = self._queue.popleft() if self._queue else None
                if work is None and not self._is_open:
                    return
            if work is not None:
                self._do(work)
            if time.monotonic() >= due:
                due = time.monotonic() + EVERY_S
                self._do(self._each_second)

    def _do(self, work: Work) -> None:
        try:
            work()
        except Exception:  # what cannot be published is no reason to publish nothing more
            if not self._is_puzzled:
                self._is_puzzled = True
                log.exception("something could not be published; later failures are not logged")

    def _puzzle(self, why: str) -> None:
        if not self._is_puzzled:
            self._is_puzzled = True
            log.warning("%s", why)
