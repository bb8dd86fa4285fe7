# SPDX-License-Identifier: Apache-2.0
"""The threads of a process that wait for disks, so that no run waits for one that hangs."""

from __future__ import annotations

import math
import os
import queue
import threading
import time
from collections.abc import Callable

from rai_missions.connectors.worker import Worker

__all__ = ("LONGEST_S", "THREADS", "DiskThreads")

MOST_FREE = 1
"""Threads that wait for the next row. One that is busy takes row after row without being woken."""
HURRY_S = 0.02
"""Where no thread has taken a row for so long, and one waits, all of them wait for disks. It is looked at so often."""
LONGEST_S = 10.0
"""A disk that has not taken a row so long after a thread began to write it is one that cannot be written."""
Job = tuple[Callable[[], object], Callable[[], object]]
"""What is to be done, and how that is made known."""


class DiskThreads:
    """The threads of a process that wait for disks: one, and one more where all of them wait for one that is slow.

    What is to be written waits for a thread in the order in which it came. Without journals there are none.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin again in a forked process, which has none of its parent's threads."""
        self._lock = threading.Lock()
        self._jobs: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        self._idle: set[threading.Thread] = set()
        self._journals = self._count = 0
        self._taken_at = -math.inf
        self._watch, self._is_watched = Worker("rows that wait"), False

    def enter(self) -> None:
        """A journal may be written from now on."""
        with self._lock:
            self._journals += 1

    def leave(self) -> None:
        """Count out a journal that is not written any more; after the last one the idle threads end."""
        with self._lock:
            self._journals -= 1
            if self._journals:
                return
            ended, jobs, watch = self._idle, self._jobs, self._watch
            self._idle, self._jobs, self._count = set(), queue.SimpleQueue(), 0
            self._watch, self._is_watched = Worker("rows that wait"), False
        watch.close()
        for _ in ended:
            jobs.put(None)
        for thread in ended - {threading.current_thread()}:
            thread.join(LONGEST_S)

    def do(self, work: Callable[[], object], done: Callable[[], object]) -> None:
        """Have something done on a thread, and then have that known."""
        self._jobs.put((work, done))
        if self._jobs.qsize() > len(self._idle):
            if self._count < MOST_FREE:
                self._start()
            self._watch_over()

    def _watch_over(self) -> None:
        """Something waits for a thread: look from now on whether any is free."""
        if not self._is_watched:
            with self._lock:
                is_first, self._is_watched = not self._is_watched, True
            if is_first:
                self._watch.after(HURRY_S, self._look)

    def _look(self) -> None:
        """While something waits for a thread, have another one where none has taken anything for `HURRY_S`."""
        with self._lock:
            self._is_watched = False  # from here on, what comes is seen in the queue or begins to look itself
            self._is_watched = is_watched = not self._jobs.empty()
        if is_watched:
            self._watch.after(HURRY_S, self._look)
            if time.monotonic() - self._taken_at >= HURRY_S:
                self._start()

    def _start(self) -> None:
        with self._lock:
            self._count += 1
            jobs = self._jobs
        threading.Thread(target=self._work, args=(jobs,), name="journal", daemon=True).start()

    def _work(self, jobs: queue.SimpleQueue[Job | None]) -> None:
        thread = threading.current_thread()
        is_kept = self._is_kept(thread, jobs)
        while is_kept and (job := jobs.get()) is not None:
            with self._lock:
                self._idle.discard(thread)
                self._taken_at = time.monotonic()
            if not jobs.empty():  # it came when this thread still counted as idle
                self._watch_over()
            work, done = job
            work()
            is_kept = self._is_kept(thread, jobs)  # before that is known: who learns of it finds the thread free
            done()
            del job, work, done

    def _is_kept(self, thread: threading.Thread, jobs: queue.SimpleQueue[Job | None]) -> bool:
        """Whether a thread waits for more to do."""
        with self._lock:
            is_of_now = jobs is self._jobs
            is_kept = is_of_now and (not jobs.empty() or (bool(self._journals) and len(self._idle) < MOST_FREE))
            if is_kept:
                self._idle.add(thread)
            elif is_of_now:
                self._count -= 1
        return is_kept


THREADS = DiskThreads()
os.register_at_fork(after_in_child=THREADS.forget)
