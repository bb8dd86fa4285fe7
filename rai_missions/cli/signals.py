# SPDX-License-Identifier: Apache-2.0
"""What Ctrl-C, SIGTERM and SIGHUP do while a command is at work."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager
from typing import Any

from rai_missions.runtime.interrupts import interrupt_handler, on_signals

__all__ = ("interruptible", "on_signals", "raised_signals")


def raised_signals() -> AbstractContextManager[None]:
    """A signal that asks the program to end raises `KeyboardInterrupt` with its number, where that is this thread's."""

    def receive(number: int, frame: Any) -> None:
        raise KeyboardInterrupt(number)

    return on_signals(receive)


def interruptible(
    stop: Callable[[str], object], kill: Callable[[str], object], doing: str
) -> AbstractContextManager[None]:  # fmt: skip
    """The first interrupt stops in good order, the second is an e-stop, a third raises where it is.

    Args:
        stop: What the first does; called with who interrupts.
        kill: What the second does; called with who interrupts.
        doing: What the first does, in a word for people.
    """
    return on_signals(interrupt_handler(stop, kill, doing))
