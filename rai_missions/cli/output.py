# SPDX-License-Identifier: Apache-2.0
"""What a command prints: without secrets, without control of the terminal that shows it, and without waiting for it.

Rule: a text from a mission, a journal, a robot or an exception is printed as text and has no other effect.
Rule: what is printed comes in its order and in whole lines, or is left out and counted.
Rule: a run ends as it ended, also where no one takes what it prints.
"""

from __future__ import annotations

import sys
import traceback
from collections.abc import Iterator
from contextlib import contextmanager, redirect_stderr, redirect_stdout
from functools import partial
from threading import get_ident
from typing import Any, TextIO, cast

from rai_missions.cli.streams import discard
from rai_missions.connectors.worker import Worker
from rai_missions.redaction import Redaction

__all__ = (
    "MAX_PENDING", "BufferedStream", "nonblocking_output", "redacted_output", "terminal_of", "wait_for_output",
)  # fmt: skip

REPLACEMENT = "\N{REPLACEMENT CHARACTER}"
CONTROLS = {code: REPLACEMENT for code in (*range(32), *range(127, 160)) if chr(code) not in "\t\n"}
"""The control characters (ECMA-48): with them a terminal is made to write, hide, or answer."""
DIRECTIONS = dict.fromkeys((0x200E, 0x200F, 0x061C, *range(0x202A, 0x202F), *range(0x2066, 0x206A)), REPLACEMENT)
"""What changes the direction of writing, so that words are read in another order than they were written (UAX 9)."""
MAX_PENDING = 2_000
"""Pieces of text that may wait to be taken; what is printed beyond is left out."""


class RedactedStream:
    """A stream to which texts are written without secrets.

    Args:
        stream: Where they go.
        controls: Whether control characters are let through.
    """

    def __init__(self, stream: TextIO, *, controls: bool) -> None:
        self._stream, self._replaced = stream, {} if controls else CONTROLS | DIRECTIONS
        self._redaction = Redaction()

    def write(self, text: str) -> int:
        """Write a text."""
        if text == "\n":
            return self._stream.write(text)
        self._stream.write(self._redaction.text(text).translate(self._replaced))
        return len(text)

    def writelines(self, lines: Any) -> None:
        """Write texts."""
        for line in lines:
            self.write(line)

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    @property
    def stream(self) -> TextIO:
        """Where the texts go, for what this program draws of itself: numbers and words of its own."""
        return self._stream


def terminal_of(stream: TextIO) -> TextIO:
    """The stream on which a line may be drawn and removed; only numbers and words of this program may be."""
    return stream.stream if isinstance(stream, RedactedStream) else stream


@contextmanager
def redacted_output(*, controls: bool) -> Iterator[None]:
    """Print everything without secrets; a traceback of this program as well.

    Args:
        controls: Whether the command draws on the terminal, so that control characters are let through.
    """
    out = sys.stdout if controls else cast(TextIO, RedactedStream(sys.stdout, controls=False))
    with redirect_stdout(out), redirect_stderr(cast(TextIO, RedactedStream(sys.stderr, controls=controls))):
        try:
            yield
        except Exception:
            text = traceback.format_exc()
            if Redaction().text(text) == text:
                raise
            sys.stderr.write(text)
            raise SystemExit(1) from None


class BufferedStream:
    """Text on its way to a terminal, a file or a pipe, on a thread of its own.

    A line goes out once its thread has ended or flushed it, so no other thread or stream writes into it.

    Args:
        out: Where it goes.
    """

    def __init__(self, out: TextIO) -> None:
        self._out = out
        self._worker = Worker("printing", limit=MAX_PENDING, on_error=self._fail)
        self._worker.start()
        self._lost = 0
        self._begun: dict[int, str] = {}
        """Thread → the line that it has yet to end."""
        self.fault: BaseException | None = None
        """What printing has raised; nothing more is printed then."""

    @property
    def waiting(self) -> int:
        """About how many pieces of text wait to be taken."""
        return self._worker.waiting

    def write(self, text: str) -> int:
        """Have it printed; nothing more is, once printing has raised."""
        thread = get_ident()
        line = self._begun.pop(thread, "") + text
        if line.endswith("\n"):
            self._pass_on(line)
        elif line:
            self._begun[thread] = line
        return len(text)

    def flush(self) -> None:
        """Pass on what this thread has begun to write; nothing waits here."""
        self._pass_on(self._begun.pop(get_ident(), ""))

    def settle(self) -> None:
        """Wait until all of it is out; what is printed later is waited for."""
        for thread in tuple(self._begun):
            self._pass_on(self._begun.pop(thread, ""))
        self._worker.close()
        if self.fault is None:
            self._write(self._left_out)
            self._lost = 0

    def _pass_on(self, text: str) -> None:
        if self.fault is not None:
            return
        if not self._worker.is_alive:
            self._write(text)
        elif text and self._worker.post(partial(self._print, f"{self._left_out}{text}")):
            self._lost = 0
        elif text:
            self._lost += 1

    def __getattr__(self, name: str) -> Any:
        return getattr(self._out, name)

    def _print(self, text: str) -> None:
        if self.fault is not None:
            return
        self._out.write(text)
        if not self._worker.waiting:
            self._out.flush()

    def _write(self, text: str) -> None:
        """Print it at once."""
        try:
            self._out.write(text)
            self._out.flush()
        except OSError as error:
            self._fail(error)

    def _fail(self, error: BaseException) -> None:
        self.fault = self.fault or error

    @property
    def _left_out(self) -> str:
        return (
            f"\n… {self._lost} pieces of text are left out, since they were not taken in time\n" if self._lost else ""
        )


def wait_for_output() -> None:
    """Wait for all that was printed; from now on everything is printed at once, since no run can be delayed by it."""
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, BufferedStream):
            stream.settle()


@contextmanager
def nonblocking_output() -> Iterator[None]:
    """Print without waiting: a terminal that takes nothing delays only the end, no run and no e-stop.

    What could not be printed is reported on stderr, unless its reader has gone, who asks for no more.
    """
    out, error = BufferedStream(sys.stdout), BufferedStream(sys.stderr)
    with redirect_stdout(cast(TextIO, out)), redirect_stderr(cast(TextIO, error)):
        try:
            yield
        finally:
            out.settle()
            if out.fault is not None and not isinstance(out.fault, BrokenPipeError):
                error.write(f"rai-missions: the rest is not printed: {out.fault}\n")
            error.settle()
    for stream, fault in ((sys.stdout, out.fault), (sys.stderr, error.fault)):
        if fault is not None:
            discard(stream)
