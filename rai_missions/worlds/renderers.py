# SPDX-License-Identifier: Apache-2.0
"""The renderers of one compiled world, and the thread that they live on.

Rule: everything of OpenGL happens on one thread, since a context belongs to the thread that made it. What was made
there is freed there, also when no one reports that it is over: a garbage collection happens on any thread.
"""

from __future__ import annotations

import threading
import weakref
from collections.abc import Callable
from concurrent.futures import Future
from queue import SimpleQueue
from typing import Any, TypeVar

import mujoco

from rai_missions.errors import UsageError

__all__ = ("Renderers",)

T = TypeVar("T")
Jobs = SimpleQueue[Callable[[], None] | None]
"""What the thread does next; None is the end."""
Made = dict[tuple[int, int], Any]


class Renderers:
    """One renderer a size, made when it is first asked for.

    Args:
        model: The compiled world.
    """

    def __init__(self, model: Any) -> None:
        self._model = model
        self._made: Made = {}
        self._jobs: Jobs = SimpleQueue()
        self._thread: threading.Thread | None = None
        self._end: Callable[[], object] = lambda: None
        self._lock = threading.Lock()

    def do(self, work: Callable[[], T]) -> T:
        """Have work done on the thread; its result, or what it raised."""
        future: Future[T] = Future()
        with self._lock:
            if self._thread is None:
                self._start()
            self._jobs.put(lambda: _do(work, future))
        return future.result()

    def of(self, height: int, width: int) -> Any:
        """The renderer of a size in pixels; to be asked for on the thread.

        Raises:
            UsageError: Nothing can be rendered here; it states what is missing.
        """
        size = height, width
        if size not in self._made:
            try:
                self._made[size] = mujoco.Renderer(self._model, *size)
            except Exception as fault:
                raise UsageError(
                    f"the camera cannot render ({fault}): install EGL (Debian: libegl1 libgl1 libgl1-mesa-dri), "
                    "or open the world with camera=False"
                ) from fault
        return self._made[size]

    def close(self) -> None:
        """Free the renderers; work that comes later makes new ones."""
        with self._lock:
            thread, self._thread = self._thread, None
            if thread is not None:
                self._end()
                thread.join()

    def _start(self) -> None:
        # The thread knows nothing of us, or we would never be forgotten; nor is it waited for when the program ends.
        self._thread = threading.Thread(target=_work, args=(self._jobs, self._made), name="camera", daemon=True)
        self._thread.start()
        # Putting into this queue is allowed wherever a garbage collection may find us.
        self._end = end = weakref.finalize(self, self._jobs.put, None)
        end.atexit = False


def _work(jobs: Jobs, made: Made) -> None:
    while (job := jobs.get()) is not None:
        job()
        del job  # it knows who asked
    while made:
        made.popitem()[1].close()


def _do(work: Callable[[], T], future: Future[T]) -> None:
    try:
        future.set_result(work())
    except BaseException as fault:  # noqa: BLE001 - it is for who asked
        future.set_exception(fault)
