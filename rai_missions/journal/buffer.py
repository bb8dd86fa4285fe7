# SPDX-License-Identifier: Apache-2.0
"""Writes a run down as it goes: steps at once, blackboard writes that enabled nothing along with the next row.

Rule: of each key only the newest value travels, and none travels longer than a second.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from rai_missions.engine.step import Step
from rai_missions.journal.in_flight import needs_confirmation
from rai_missions.journal.writer_thread import WriterThread
from rai_missions.keys import Blackboard

__all__ = ("BufferedWriter", "JournalSink", "raised_by")

QUIET_S = 1.0
"""How long a write that enabled nothing may travel before it is written down, and a running timer be silent."""


class JournalSink(Protocol):
    """What a run is written to: `rai_missions.journal.Journal`."""

    path: Path

    def write(self, step: Step, *, since: float, quiet: Any = ()) -> int: ...

    def confirm(self, number: int, how: str) -> int: ...

    def note(self, text: str, data: Any = None) -> int: ...


class BufferedWriter:
    """Between a runner and its journal.

    Args:
        book: The journal; None: nothing is written down.
        called: What a runner that waits for the disk does when `call` is: an emergency stop.
    """

    def __init__(self, book: JournalSink | None, called: Callable[[], None] = lambda: None) -> None:
        self._book, self._clerk = book, WriterThread(called)
        self._carried: dict[str, tuple[str, Any, float]] = {}
        self._since = self.silent_from = math.inf
        """`silent_from`: the instant from which nothing reports any more how far the run's clock had come."""
        self.path = str(book.path) if book is not None else None

    @property
    def due(self) -> float:
        """The instant at which what travels must be written down; infinity if nothing does."""
        return self._since + QUIET_S

    def resume(self, at: float) -> None:
        """The run was cut short, and continues at this instant of its clock; raises as `write` does."""
        self.note("resumed")
        self.silent_from = at + QUIET_S if self._book is not None else math.inf

    def carry(self, step: Step, board: Blackboard) -> None:
        """A step that only wrote the blackboard."""
        if self._book is None:
            return
        for key, _ in step.writes:
            entry = board[key]
            self._carried[key] = (key, entry.value, entry.at)
            self._since = min(self._since, step.at)

    def write(self, step: Step, since: float) -> None:
        """Write a step with what travels; raises what the journal raises."""
        if (book := self._book) is not None:
            quiet = tuple(self._carried.values())
            self._clerk.do(lambda: book.write(step, since=since, quiet=quiet))
            self.silent_from = step.at + QUIET_S
        self._clear()

    def confirm(self, step: Step) -> None:
        """Write down that a step's effects were carried out, where doing so twice may harm; raises as `write` does."""
        if needs_confirmation(step):
            self.settle(step.seq, "performed")

    def settle(self, seq: int, how: str) -> None:
        """Write down what has become of effects of which nothing stated it; raises as `write` does."""
        if (book := self._book) is not None:
            self._clerk.do(lambda: book.confirm(seq, how))

    def note(self, text: str, data: Any = None) -> None:
        """Write down why there is no run, why it broke off, what may still move; raises what the journal raises."""
        if (book := self._book) is not None:
            self._clerk.do(lambda: book.note(text, data))

    def call(self) -> None:
        """There is an emergency: a runner that waits for the disk is notified at once; from any thread."""
        self._clerk.call()

    def close(self) -> None:
        """The run is over."""
        self._clerk.close()

    def give_up(self) -> None:
        """The journal is lost: nothing more is written."""
        self._book, self.silent_from = None, math.inf
        self._clear()

    def _clear(self) -> None:
        self._carried.clear()
        self._since = math.inf


def raised_by(write: Callable[[], None]) -> Exception | None:
    """What writing raises: whatever the reason, what is not written down may not be done."""
    try:
        write()
    except Exception as error:  # noqa: BLE001 - see above
        return error
    return None
