# SPDX-License-Identifier: Apache-2.0
"""What Ctrl-C and SIGTERM do while a command is at work."""

from __future__ import annotations

import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import Any

__all__ = ("interruptible", "on_signals")


@contextmanager
def on_signals(do: Callable[[int, Any], object]) -> Iterator[None]:
    """An interrupt or SIGTERM does this; afterwards both do again what they did before."""
    before = {each: signal.signal(each, do) for each in (signal.SIGINT, signal.SIGTERM)}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


@contextmanager
def interruptible(stop: Callable[[], object], kill: Callable[[], object], doing: str) -> Iterator[None]:
    """The first interrupt stops in good order, the second is an e-stop.

    Args:
        stop: What the first does.
        kill: What each later one does.
        doing: What the first does, in a word for people.
    """
    pressed: list[int] = []

    def interrupt(number: int, frame: Any) -> None:
        pressed.append(number)
        if len(pressed) > 1:
            kill()
            return
        stop()
        with suppress(OSError):  # the terminal may be gone, which may be why there is an interrupt
            print(f"\n{doing}; once more for an e-stop", file=sys.stderr)

    with on_signals(interrupt):
        yield
