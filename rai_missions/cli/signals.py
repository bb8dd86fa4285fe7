# SPDX-License-Identifier: Apache-2.0
"""What Ctrl-C, SIGTERM and SIGHUP do while a command is at work."""

from __future__ import annotations

import signal
import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from typing import Any

from rai_missions.runtime.interrupts import end_signals, interrupt_handler

__all__ = ("interruptible", "on_signals", "raised_signals")


@contextmanager
def on_signals(do: Callable[[int, Any], object]) -> Iterator[None]:
    """A signal that asks the program to end does this; afterwards each does again what it did before."""
    before = {each: signal.signal(each, do) for each in end_signals()}
    try:
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


@contextmanager
def raised_signals() -> Iterator[None]:
    """A signal that asks the program to end raises `KeyboardInterrupt` with its number, where that is this thread's."""

    def receive(number: int, frame: Any) -> None:
        raise KeyboardInterrupt(number)

    with on_signals(receive) if threading.current_thread() is threading.main_thread() else nullcontext():
        yield


@contextmanager
def interruptible(stop: Callable[[str], object], kill: Callable[[str], object], doing: str) -> Iterator[None]:
    """The first interrupt stops in good order, the second is an e-stop, a third raises where it is.

    Args:
        stop: What the first does; called with who interrupts.
        kill: What the second does; called with who interrupts.
        doing: What the first does, in a word for people.
    """
    with on_signals(interrupt_handler(stop, kill, doing)):
        yield
