# SPDX-License-Identifier: Apache-2.0
"""What Ctrl-C, SIGTERM and SIGHUP do to a run: it ends in order, then the program does.

Rule: an exception in the midst of a step would leave the journal without what was done; so the interrupt is a command.
Rule: a terminal that is closed may send SIGHUP twice, by its shell and by the kernel; so that one only ever cancels.
"""

from __future__ import annotations

import signal
import sys
import threading
from collections.abc import Callable, Iterator
from contextlib import AbstractContextManager, contextmanager, suppress
from typing import Any, Protocol

__all__ = (
    "BY", "RaisedSignals", "end_signals", "interruptible", "on_interrupts", "on_signals", "until_signals",
    "wait_for_signal",
)  # fmt: skip

BY = "operator (interrupt)"
"""Who cancels and stops a run by Ctrl-C, as its journal has it."""
DEFAULTS: dict[signal.Signals, Any] = {
    signal.SIGINT: signal.default_int_handler,
    signal.SIGTERM: signal.SIG_DFL,
    signal.SIGHUP: signal.SIG_DFL,
}
"""What asks a program to end (Ctrl-C, another program, a terminal that is gone), with what it does by default."""


class InterruptedRun(Protocol):
    """What an interrupt does to a run."""

    def cancel(self, by: str = ...) -> None: ...

    def kill(self, by: str = ...) -> None: ...


def end_signals() -> tuple[signal.Signals, ...]:
    """The signals that ask this program to end; under `nohup`, SIGHUP is none of them."""
    return tuple(each for each in DEFAULTS if each is not signal.SIGHUP or signal.getsignal(each) is not signal.SIG_IGN)


@contextmanager
def on_signals(do: Callable[[int, Any], object]) -> Iterator[None]:
    """A signal that asks the program to end does this, where this is the thread that receives them.

    So does one that was raised before and is lost. Afterwards each does again what it did before.
    """
    is_main = threading.current_thread() is threading.main_thread()
    before = {each: signal.signal(each, do) for each in end_signals()} if is_main else {}
    try:
        for handler in before.values():
            if isinstance(handler, RaisedSignals) and (lost := handler.take()):
                do(lost, None)
        yield
    finally:
        for each, handler in before.items():
            signal.signal(each, handler)


def wait_for_signal(serves: Callable[[], bool]) -> None:
    """Wait for a signal that asks the program to end, as long as something serves."""
    ended = threading.Event()
    with on_signals(lambda *_: ended.set()):
        while not ended.wait(0.5) and serves():
            pass


class RaisedSignals:
    """Has a signal raise `KeyboardInterrupt`, and remembers it: it may be raised where nothing that is raised counts.

    Loading an extension drops it, a finaliser does, and what compiles or validates may make another error of it.
    """

    def __init__(self) -> None:
        self.number = 0
        """Of the first that was raised; 0 where none was, or another handler has taken it."""

    def __call__(self, number: int, frame: Any) -> None:
        self.number = self.number or number
        raise KeyboardInterrupt(number)

    def take(self) -> int:
        """The number; from now on none was raised."""
        number, self.number = self.number, 0
        return number


@contextmanager
def until_signals() -> Iterator[None]:
    """A signal that asks the program to end ends what is done here, wherever that is."""
    with suppress(KeyboardInterrupt), on_signals(RaisedSignals()):
        yield


def on_interrupts(
    cancel: Callable[[str], object], kill: Callable[[str], object], doing: str = "canceling"
) -> AbstractContextManager[None]:
    """The first interrupt cancels, the second is an e-stop, a third raises `KeyboardInterrupt` where it is.

    Args:
        cancel: Called with who interrupts.
        kill: Called with who interrupts.
        doing: What `cancel` does, in a word for people.
    """
    return on_signals(_interrupt_handler(cancel, kill, doing))


def _interrupt_handler(
    cancel: Callable[[str], object], kill: Callable[[str], object], doing: str
) -> Callable[[int, Any], None]:
    pressed: list[int] = []

    def interrupt(number: int, frame: Any) -> None:
        by = BY if number == signal.SIGINT else signal.Signals(number).name
        if number == signal.SIGHUP:
            cancel(by)
            return
        pressed.append(number)
        if len(pressed) > 2:
            raise KeyboardInterrupt
        if len(pressed) == 2:
            kill(by)
            return
        cancel(by)
        with suppress(OSError):  # the terminal may be gone, which is why someone interrupts
            sys.stderr.write(f"\n{doing}; once more for an e-stop\n")
            sys.stderr.flush()

    return interrupt


@contextmanager
def interruptible(run: InterruptedRun) -> Iterator[None]:
    """Let the signals that ask a program to end do to a run what `on_interrupts` has.

    Where the program or another thread has a handler of its own, that one stays.

    Raises:
        KeyboardInterrupt: The run has ended, and it was interrupted by Ctrl-C.
        SystemExit: The run has ended, and it was interrupted by another signal; the status is 128 and its number.
    """
    is_main = threading.current_thread() is threading.main_thread()
    free = [each for each, default in DEFAULTS.items() if is_main and signal.getsignal(each) is default]
    received: list[int] = []
    interrupt = _interrupt_handler(run.cancel, run.kill, "canceling")

    def receive(number: int, frame: Any) -> None:
        received.append(number)
        interrupt(number, frame)

    for each in free:
        signal.signal(each, receive)
    try:
        yield
    finally:
        for each in free:
            signal.signal(each, DEFAULTS[each])
    if signal.SIGINT in received:
        raise KeyboardInterrupt
    if received:
        raise SystemExit(128 + received[0])
