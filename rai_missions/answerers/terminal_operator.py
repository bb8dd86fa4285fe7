# SPDX-License-Identifier: Apache-2.0
"""A person at the terminal as anyone who is asked.

Rule: a line counts only for the question on the screen when it was typed; a question that is withdrawn frees the
terminal at once.
"""

from __future__ import annotations

import os
import sys
import threading
from collections import deque
from collections.abc import Callable, Mapping
from typing import IO, Any, TextIO

from rai_missions.answerers.model.pending import Pending
from rai_missions.answerers.question_text import Blank, blanks, chosen, question_lines
from rai_missions.answerers.terminal_input import LineReader, in_foreground
from rai_missions.engine.decision import Offer, Question
from rai_missions.redaction import cut

__all__ = ("OperatorAgent",)


class GaveUp(Exception):
    """No one waits for this answer any more, or its time is over."""


class OperatorAgent:
    """Asks on a terminal, one question after the other, on a thread that lives while there are questions.

    Args:
        source: Where the person types; standard input, if not given. Anything but a terminal means: absent.
        sink: Where the question is written; standard output, if not given.
    """

    def __init__(self, source: IO[Any] | None = None, sink: TextIO | None = None) -> None:
        self._source, self._sink = source, sink
        self._queue: deque[Pending] = deque()
        self._lock = threading.Lock()
        self._reader: LineReader | None = None
        self._thread: threading.Thread | None = None

    def run(self) -> None:
        """Nothing to begin: the first question does."""

    def stop(self, within_s: float = 1.0) -> None:
        """Withdraw every question and free the terminal; waits so long at most."""
        with self._lock:
            for pending in self._queue:
                pending.close()
            self._wake()
            thread = self._thread
        if thread is not None and thread is not threading.current_thread():
            thread.join(within_s)

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Put a question behind those that are open."""
        pending = Pending(question, answer)
        fd = self._terminal()
        if fd is None:
            pending.tell({"absent": "no terminal"})
            return
        with self._lock:
            self._queue.append(pending)
            if self._thread is None:
                self._reader = LineReader(fd)
                # A terminal may hold up anyone who writes to it (Ctrl-S); that must not hold up the program's end.
                self._thread = threading.Thread(target=self._serve, args=(self._reader,), name="operator", daemon=True)
                self._thread.start()

    def withdraw(self, number: int) -> None:
        """The question is no longer asked; if it is on the screen, the reading ends."""
        with self._lock:
            for pending in self._queue:
                if pending.question.number == number:
                    pending.close()
            self._wake()

    def _wake(self) -> None:
        if self._reader is not None:
            self._reader.wake()

    def _terminal(self) -> int | None:
        source = self._source if self._source is not None else sys.stdin
        try:
            fd = source.fileno()
            return fd if os.isatty(fd) and in_foreground(fd) else None
        except (AttributeError, OSError, ValueError):  # no stream, none with a descriptor, or a closed one
            return None

    def _serve(self, reader: LineReader) -> None:
        while pending := self._first(reader):
            try:
                said: dict[str, Any] | None = self._asked(pending, reader)
            except GaveUp:
                late = pending.open
                said = {"failed": f"no answer within {pending.taken_s:.1f} s"} if late else None
                self._write_last("time is over" if late else "no longer asked")
            except EOFError as end:
                said = {"absent": str(end)}
            except Exception as error:  # noqa: BLE001 - the screen is gone, or a schema is stranger than we can show
                said = {"absent": f"the question could not be shown: {cut(error, 250)}"}
            if said is not None:
                pending.tell(said)
            pending.close()

    def _first(self, reader: LineReader) -> Pending | None:
        """The next question that is open; with none left, the thread's end."""
        with self._lock:
            while self._queue and not self._queue[0].open:
                self._queue.popleft()
            if self._queue:
                return self._queue[0]
            self._thread = self._reader = None
        reader.close()
        return None

    def _asked(self, pending: Pending, reader: LineReader) -> dict[str, Any]:
        question = pending.question
        reader.forget()
        self._write("\n".join(("", *question_lines(question, pending.left_s), "")))
        offer = self._choice(question, pending, reader)
        parameters: dict[str, Any] = {}
        for blank in blanks(offer):
            self._fill(blank, parameters, pending, reader)
        return {"option": offer.name, "parameters": parameters, "why": "the operator chose it"}

    def _choice(self, question: Question, pending: Pending, reader: LineReader) -> Offer:
        count = len(question.options)
        while True:
            typed = self._typed("Number or name (Ctrl-D to pass): ", pending, reader)
            offer = chosen(typed, question.options)
            if offer is not None:
                return offer
            self._write(f"That is none of them; type a number from 1 to {count}, or a name.\n")

    def _fill(self, blank: Blank, parameters: dict[str, Any], pending: Pending, reader: LineReader) -> None:
        while True:
            try:
                parameters[blank.name] = blank.value(self._typed(blank.prompt(), pending, reader))
            except KeyError:
                return
            except ValueError as error:
                self._write(f"{error}.\n")
            else:
                return

    def _typed(self, prompt: str, pending: Pending, reader: LineReader) -> str:
        """The next line; a wake that was meant for another question is slept over."""
        self._write(prompt)
        while pending.open and pending.left_s > 0:
            line = reader.line(pending.ends)
            if line is not None and pending.open:
                return line
        raise GaveUp

    def _write(self, text: str) -> None:
        sink = self._sink if self._sink is not None else sys.stdout
        sink.write(text)
        sink.flush()

    def _write_last(self, why: str) -> None:
        try:
            self._write(f"\n({why})\n")
        except Exception:  # noqa: BLE001 - no one is there to be told
            return
