# SPDX-License-Identifier: Apache-2.0
"""The renderers of one compiled world, and the thread that they live on.

Rule: everything of OpenGL happens on one thread, since a context belongs to the thread that made it. What was made
there is freed there, also when no one closes it: a garbage collection happens on any thread.
"""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
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
        paint: Gives the model what is only seen, before its first renderer is made.
    """

    def __init__(self, model: Any, paint: Callable[[Any], None]) -> None:
        self._model, self._paint = model, paint
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
            if not self._made:
                self._paint(self._model)
            with _explained():
                self._made[size] = mujoco.Renderer(self._model, *size)
        return self._made[size]

    def check(self) -> None:
        """Make sure that there is OpenGL here; to be asked for on the thread.

        A context of one pixel is enough to know: textures and shapes are sent to it by the first renderer.

        Raises:
            UsageError: As `of`.
        """
        with _explained():
            mujoco.GLContext(1, 1).free()

    def close(self) -> None:
        """Free the renderers; work that comes later makes new ones."""
        with self._lock:
            self._worker.close()


@contextmanager
def _explained() -> Iterator[None]:
    """What is missing, where nothing can be rendered."""
    try:
        yield
    except Exception as fault:
        raise UsageError(
            f"the camera cannot render ({fault}): install EGL (Debian: libegl1 libgl1 libgl1-mesa-dri), "
            "or open the world with camera=False"
        ) from fault


def _free(made: Made) -> None:
    while made:
        made.popitem()[1].close()
