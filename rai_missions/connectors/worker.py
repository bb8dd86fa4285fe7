# SPDX-License-Identifier: Apache-2.0
"""One thread that does what is posted to it, one piece of work after the other; and a queue without a thread.

Rule: `post` returns at once, on any thread, in a signal handler and in a garbage collection. Which pieces find no room
is decided here, by one bound and one policy.
"""

from __future__ import annotations

import itertools
import math
import threading
import time
import weakref
from collections import deque
from collections.abc import Callable, Iterator
from contextlib import suppress
from functools import partial
from heapq import heappop, heappush
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, Literal, TypeVar

from rai_missions.errors import ConnectorError, UsageError
from rai_missions.redaction import logger

if TYPE_CHECKING:
    from concurrent.futures import Future

__all__ = ("SerialQueue", "Work", "Worker")

log = logger(__name__)

T = TypeVar("T")
Work = Callable[[], object]
Timer = tuple[float, int, list[Work], float]
"""When, on `time.monotonic`; a number that orders equal instants; what to do, unless canceled; its period in seconds
or 0."""


class Worker:
    """A thread that begins with the first piece of work, and ends with `close` or when the worker is forgotten.

    It does not hold up the program's end, and it refers to the worker in no way: only pieces of work may do so.

    Args:
        name: The name of the thread.
        limit: How many pieces may wait; by default any number.
        keep: Which pieces stay where there is no room: the `oldest` (a new one is refused), or the `newest` (the one
            that has waited longest is dropped, and the first time logged).
        on_error: Called on the thread with what a piece raised; by default the first failure is logged.
        at_end: Done on the thread after the last piece.
    """

    def __init__(
        self,
        name: str,
        *,
        limit: float = math.inf,
        keep: Literal["oldest", "newest"] = "oldest",
        on_error: Callable[[BaseException], object] | None = None,
        at_end: Work = lambda: None,
    ) -> None:
        self._name, self._limit, self._keep = name, limit, keep
        self._on_error, self._at_end = on_error or _first_logged(name), at_end
        self._lock = threading.RLock()  # a signal may arrive on the thread that is posting
        self._jobs: SimpleQueue[Work | None] = SimpleQueue()
        self._timers: list[Timer] = []
        self._numbers = itertools.count()
        self._thread: threading.Thread | None = None
        self._end: Callable[[], object] = lambda: None
        self._is_closed = False
        self.dropped = 0
        """How many pieces found no room."""

    @property
    def waiting(self) -> int:
        """About how many pieces wait."""
        return self._jobs.qsize()

    @property
    def is_alive(self) -> bool:
        """Whether the worker's thread runs."""
        return self._thread is not None and self._thread.is_alive()

    def start(self) -> None:
        """Begin, also after `close`; running already, nothing happens."""
        with self._lock:
            if self._thread is not None:
                return
            self._is_closed, self._jobs, self._timers = False, SimpleQueue(), []
            given = (self._jobs, self._timers, self._on_error, self._at_end)
            self._thread = threading.Thread(target=_work, args=given, name=self._name, daemon=True)
            self._thread.start()
            self._end = end = weakref.finalize(self, self._jobs.put, None)
            end.atexit = False

    def post(self, work: Work) -> bool:
        """Have something done after all that waits; False if there is no room, or the worker is closed."""
        with self._lock:
            if self._is_closed:
                return False
            if self._thread is None:
                self.start()
            if self._jobs.qsize() >= self._limit and not self._make_room():
                return False
            self._jobs.put(work)
            return True

    def submit(self, work: Callable[[], T]) -> Future[T]:
        """Have something done, and get its result, or what it raises.

        Raises:
            UsageError: There is no room, or the worker is closed.
        """
        from concurrent.futures import Future  # loaded where someone waits

        future: Future[T] = Future()
        if not self.post(partial(_fulfil, work, future)):
            raise UsageError(f"'{self._name}' takes no more work")
        return future

    def after(self, seconds: float, work: Work) -> Work:
        """Have something done once, so many seconds from now; with infinity, or once it is closed, never.

        Returns:
            What cancels it.
        """
        return self._schedule(seconds, work, 0.0)

    def every(self, seconds: float, work: Work) -> Work:
        """Have something done again and again until `close`, for the first time so many seconds from now.

        Returns:
            What cancels it.
        """
        return self._schedule(seconds, work, seconds)

    def close(self, within_s: float | None = None) -> bool:
        """Take no more, do what waits, and end; what was to be done at an instant still to come is not done.

        Args:
            within_s: How long to wait for the end; by default for as long as it takes. The thread itself never waits.

        Returns:
            Whether it has ended.
        """
        with self._lock:
            thread, self._thread, self._is_closed = self._thread, None, True
            self._end()
        if thread is None or thread is threading.current_thread():
            return True
        thread.join(None if within_s is None else min(within_s, threading.TIMEOUT_MAX))
        return not thread.is_alive()

    def _schedule(self, seconds: float, work: Work, period_s: float) -> Work:
        entry = [work]
        with self._lock:
            if self._is_closed:
                return _nothing
            self.start()
            heappush(self._timers, (time.monotonic() + seconds, next(self._numbers), entry, period_s))
            if threading.current_thread() is not self._thread:
                self._jobs.put(_nothing)  # it may wait for longer
        return entry.clear

    def _make_room(self) -> bool:
        """Whether a new piece may come in where the bound is reached."""
        self.dropped += 1
        if self._keep == "oldest":
            return False
        if self.dropped == 1:
            log.warning("'%s' gets more than it can do; the oldest is dropped", self._name)
        with suppress(Empty):
            self._jobs.get_nowait()
        return True


class SerialQueue:
    """Does what is posted, one piece after the other, on the thread that finds it idle: it has none of its own.

    What is posted from inside a piece, or from another thread, is done by the thread that is at it already.
    """

    def __init__(self) -> None:
        self._waiting: deque[Work] = deque()
        self._lock = threading.Lock()
        self._is_busy = False

    def post(self, work: Work) -> None:
        """Have something done, now or by the thread that is at it."""
        self.put(work)
        self.run()

    def put(self, work: Work) -> None:
        """Have something done by the next `run`; a lock may be held meanwhile."""
        self._waiting.append(work)

    def run(self) -> None:
        """Do what waits, unless a thread is at it."""
        with self._lock:
            is_ours, self._is_busy = not self._is_busy, True
        while is_ours and (work := self._next()) is not None:
            try:
                work()
            except (Exception, SystemExit):
                log.exception("a callback failed")
            except BaseException:  # Ctrl-C: what waits is left for the next run
                with self._lock:
                    self._is_busy = False
                raise

    def _next(self) -> Work | None:
        with self._lock:
            self._is_busy = bool(self._waiting)
            return self._waiting.popleft() if self._is_busy else None


def _work(
    jobs: SimpleQueue[Work | None], timers: list[Timer], on_error: Callable[[BaseException], object], at_end: Work
) -> None:
    for work in _pieces(jobs, timers):
        try:
            work()
        except BaseException as error:  # noqa: BLE001 - the thread outlives whatever a piece raises
            on_error(error)
        del work  # it may refer to an owner who is forgotten while nothing is to be done
    at_end()


def _pieces(jobs: SimpleQueue[Work | None], timers: list[Timer]) -> Iterator[Work]:
    """What is to be done, until the end: by turns what is due and what waits."""
    while True:
        while timers and not timers[0][2]:
            heappop(timers)  # canceled
        if timers and timers[0][0] <= time.monotonic():
            _, number, entry, period_s = heappop(timers)
            if period_s:
                heappush(timers, (time.monotonic() + period_s, number, entry, period_s))
            yield from entry
            del entry
        left_s = min(max(0.0, timers[0][0] - time.monotonic()), threading.TIMEOUT_MAX) if timers else None
        try:
            work = jobs.get(timeout=left_s)
        except Empty:
            continue
        if work is None:
            return
        yield work
        del work


def _nothing() -> None:
    """Wakes the thread, which then looks what is due."""


def _fulfil(work: Callable[[], Any], future: Future[Any]) -> None:
    try:
        future.set_result(work())
    except BaseException as error:  # noqa: BLE001 - raised where the result is asked for
        future.set_exception(error)


def _first_logged(name: str) -> Callable[[BaseException], None]:
    failures = itertools.count()

    def report(error: BaseException) -> None:
        if next(failures):
            return
        if isinstance(error, ConnectorError):  # the world's: its sentence is the whole of it
            log.warning("'%s' failed at a piece of work; later failures are not logged: %s", name, error)
        else:
            log.error("'%s' failed at a piece of work; later failures are not logged", name, exc_info=error)

    return report
