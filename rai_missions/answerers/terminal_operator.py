# SPDX-License-Identifier: Apache-2.0
"""A person at the terminal as anyone who is asked.

Rule: a line counts only for the question on the screen when it was typed; a question that is withdrawn frees the
terminal at once. The run withdraws one whose time is over: a pause, or an operator who takes control, stops that time.
"""

from __future__ import annotations

import os
import sys
import threading
from collections.abc import Callable, Mapping
from functools import partial
from typing import IO, Any, TextIO

from rai_missions.answerers.model.pending import PendingQuestion
from rai_missions.answerers.question_text import Blank, blanks, chosen, question_lines
from rai_missions.answerers.terminal_input import LineReader, in_foreground
from rai_missions.connectors.worker import Worker
from rai_missions.engine.decision import Offer, Question
from rai_missions.redaction import cut

__all__ = ("OperatorAgent",)


class GaveUp(Exception):
    """No one waits for this answer any more, or its time is over."""


class OperatorAgent:
    """Asks on a terminal, one question after the other, on a thread that lives from the first question to `stop`.

    Args:
        source: Where the person types; standard input, if not given. Anything but a terminal means: absent.
        sink: Where the question is written; standard output, if not given.
    """

    def __init__(self, source: IO[Any] | None = None, sink: TextIO | None = None) -> None:
        self._source, self._sink = source, sink
        self._open: dict[int, PendingQuestion] = {}
        self._lock = threading.Lock()
        self._desk: tuple[LineReader, Worker] | None = None
        """What reads the terminal, and the thread that it does so on."""

    def run(self) -> None:
        """Nothing to begin: the first question does."""

    def stop(self, within_s: float = 1.0) -> None:
        """Withdraw every question and free the terminal; waits so long at most."""
        with self._lock:
            pending, self._open = list(self._open.values()), {}
            desk, self._desk = self._desk, None
        for each in pending:
            each.close()
        if desk is not None:
            desk[1].close(within_s)

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Put a question behind those that are open."""
        pending = PendingQuestion(question, answer, is_hurried=False)
        fd = self._terminal()
        if fd is None:
            pending.reply({"absent": "no terminal"})
            return
        with self._lock:
            self._open[question.number] = pending
            if self._desk is None:
                reader = LineReader(fd)
                self._desk = reader, Worker("operator", at_end=reader.close)
            reader, worker = self._desk
            pending.when_closed(reader.wake)
            worker.post(partial(self._serve, pending, reader))

    def withdraw(self, number: int) -> None:
        """The question is no longer asked; if it is on the screen, the reading ends."""
        with self._lock:
            pending = self._open.pop(number, None)
        if pending is not None:
            pending.close()

    def _terminal(self) -> int | None:
        source = self._source if self._source is not None else sys.stdin
        try:
            fd = source.fileno()
            return fd if os.isatty(fd) and in_foreground(fd) else None
        except (AttributeError, OSError, ValueError):  # no stream, none with a descriptor, or a closed one
            return None

    def _serve(self, pending: PendingQuestion, reader: LineReader) -> None:
        reply = self._reply(pending, reader) if pending.open else None
        if reply is not None:
            pending.reply(reply)
        self.withdraw(pending.question.number)

    def _reply(self, pending: PendingQuestion, reader: LineReader) -> dict[str, Any] | None:
        """What the person answers; None where no one waits for it any more."""
        try:
            return self._asked(pending, reader)
        except GaveUp:
            late = pending.open
            self._write_last("time is over" if late or pending.taken_s >= pending.asked_s > 0 else "no longer asked")
            return {"failed": f"no answer within {pending.taken_s:.1f} s"} if late else None
        except EOFError as end:
            return {"absent": str(end)}
        except Exception as error:  # noqa: BLE001 - the screen is gone, or a schema is stranger than we can show
            return {"absent": f"the question could not be shown: {cut(error, 250)}"}

    def _asked(self, pending: PendingQuestion, reader: LineReader) -> dict[str, Any]:
        question = pending.question
        reader.forget()
        self._write(
            "\n".join(("", *question_lines(question, min(pending.left_s, pending.asked_s - pending.taken_s)), ""))
        )
        offer = self._choice(question, pending, reader)
        parameters: dict[str, Any] = {}
        for blank in blanks(offer):
            self._fill(blank, parameters, pending, reader)
        return {"option": offer.name, "parameters": parameters, "why": "the operator chose it"}

    def _choice(self, question: Question, pending: PendingQuestion, reader: LineReader) -> Offer:
        count = len(question.options)
        while True:
            typed = self._typed("Number or name (Ctrl-D to pass): ", pending, reader)
            offer = chosen(typed, question.options)
            if offer is not None:
                return offer
            self._write(f"That is none of them; type a number from 1 to {count}, or a name.\n")

    def _fill(self, blank: Blank, parameters: dict[str, Any], pending: PendingQuestion, reader: LineReader) -> None:
        while True:
            try:
                parameters[blank.name] = blank.value(self._typed(blank.prompt(), pending, reader))
            except KeyError:
                return
            except ValueError as error:
                self._write(f"{error}.\n")
            else:
                return

    def _typed(self, prompt: str, pending: PendingQuestion, reader: LineReader) -> str:
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
        except Exception:  # noqa: BLE001 - no one looks at the screen any more
            return
