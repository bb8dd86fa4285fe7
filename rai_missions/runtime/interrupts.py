# SPDX-License-Identifier: Apache-2.0
"""What Ctrl-C does to a run in a program without a handler of its own: the run ends in order, then the program.

Rule: an exception in the midst of a step would leave the journal without what was done; so the interrupt is a command.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager, suppress
from typing import Any, Protocol

__all__ = ("BY", "interruptible")

BY = "operator (interrupt)"
"""Who cancels and stops a run by Ctrl-C, as its journal has it."""


class InterruptedRun(Protocol):
    """What an interrupt does to a run."""

    def cancel(self, by: str = ...) -> None: ...

    def kill(self, by: str = ...) -> None: ...


@contextmanager
def interruptible(run: InterruptedRun) -> Iterator[None]:
    """Let the first Ctrl-C cancel a run, the second stop it at once, and the third raise where it is.

    Where the program or another thread has a handler of its own, that one stays.

    Raises:
        KeyboardInterrupt: The run has ended, and it was interrupted.
    """
    is_main = threading.current_thread() is threading.main_thread()
    if not is_main or signal.getsignal(signal.SIGINT) is not signal.default_int_handler:
        yield
        return
    pressed: list[int] = []

    def interrupt(number: int, frame: Any) -> None:
        pressed.append(number)
        if len(pressed) > 2:
            raise KeyboardInterrupt
        if len(pressed) == 2:
            run.kill(BY)
            return
        run.cancel(BY)
        with suppress(OSError):  # the terminal may be gone, which is why someone interrupts
            sys.stderr.write("\ncanceling; once more for an e-stop\n")

    signal.signal(signal.SIGINT, interrupt)
    try:
        yield
    finally:
        signal.signal(signal.SIGINT, signal.default_int_handler)
    if pressed:
        raise KeyboardInterrupt
