# SPDX-License-Identifier: Apache-2.0
"""The renderers of one compiled world, and the thread that they live on.

Rule: everything of OpenGL happens on one thread, since a context belongs to the thread that made it. What was made
there is freed there, also when no one closes it: a garbage collection happens on any thread.
"""

from __future__ import annotations

import threading
from collections.abc import Callable
from functools import partial
from typing import Any, TypeVar

import mujoco

from rai_missions.connectors.worker import Worker
from rai_missions.errors import UsageError

__all__ = ("Renderers",)

T = TypeVar("T")
Made = dict[tuple[int, int], Any]


class Renderers:
    """One renderer a size, made when it is first asked for.

    Args:
        model: The compiled world.
    """

    def __init__(self, model: Any) -> None:
        self._model = model
        self._made: Made = {}
        self._worker = Worker("camera", at_end=partial(_free, self._made))
        self._lock = threading.Lock()

    @property
    def are_made(self) -> bool:
        return bool(self._made)

    def do(self, work: Callable[[], T]) -> T:
        """Have work done on the thread; its result, or what it raised."""
        with self._lock:
            self._worker.start()
            future = self._worker.submit(work)
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
            self._worker.close()


def _free(made: Made) -> None:
    while made:
        made.popitem()[1].close()
