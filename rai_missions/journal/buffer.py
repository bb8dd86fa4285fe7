# SPDX-License-Identifier: Apache-2.0
"""Writes a run down: steps at once, blackboard writes that enabled nothing with the next row.

Rule: of each key only the newest value is buffered, and none longer than a second.
Rule: a confirmation is buffered only while the event is taken that waits already, and has its own row before the next.
It is lost with that event's row only where the disk takes neither.
Rule: a run continues only when its row is written, but a disk that hangs holds up no e-stop. A wait behind the rows of
others ends no run.
"""

from __future__ import annotations

import math
import queue
import time
import weakref
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError
from rai_missions.journal.disk_threads import LONGEST_S, THREADS
from rai_missions.journal.in_flight import needs_confirmation
from rai_missions.keys import Blackboard

__all__ = ("BufferedWriter", "JournalSink", "raised_by")

QUIET_S = 1.0
"""How long a write that enabled nothing is buffered at most, and a running timer silent."""


@runtime_checkable
class JournalSink(Protocol):
    """What a run is written to: `rai_missions.journal.Journal`."""

    path: Path

    def write(self, step: Step, *, since: float, quiet: Any = (), performed: Iterable[int] = ()) -> int: ...

    def confirm(self, number: int, how: str) -> int: ...

    def note(self, text: str, data: Any = None) -> int: ...


class BufferedWriter:
    """Between a runner and its journal; the disk is waited for on another thread.

    What the journal raises, each method that writes raises, once: nothing more is written after it. `ConnectorError`
    also where the disk took too long: whether the row was written is not known then.

    Args:
        journal: The journal; None: nothing is written down.
        called: What a runner that waits for the disk does when `call` is: an e-stop.
    """

    def __init__(self, journal: JournalSink | None, called: Callable[[], None] = lambda: None) -> None:
        self._journal, self._called = journal, called
        self._leave: Callable[[], object] = lambda: None
        if journal is not None:
            THREADS.enter()
            self._leave = leave = weakref.finalize(self, THREADS.leave)
            leave.atexit = False
        self._bell: queue.SimpleQueue[bool] = queue.SimpleQueue()
        """Rings when something is written, and with True when `call` is called."""
        self._buffered: dict[str, tuple[str, Any, float]] = {}
        self._unconfirmed: list[int] = []
        """The steps whose confirmation is buffered."""
        self._since = self.silent_from = math.inf
        """`silent_from`: the instant from which nothing reports any more how far the run's clock had come."""
        self.path = str(journal.path) if journal is not None else None

    @property
    def due(self) -> float:
        """The instant at which the buffer must be written down; infinity if it is empty."""
        return self._since + QUIET_S

    def resume(self, at: float) -> None:
        """Write that the run was cut short, and continues at this instant of its clock."""
        self.note("resumed")
        self.silent_from = at + QUIET_S if self._journal is not None else math.inf

    def buffer(self, step: Step, board: Blackboard) -> None:
        """Keep what a step wrote that only wrote the blackboard, for the next row."""
        if self._journal is None:
            return
        for key, _ in step.writes:
            entry = board[key]
            self._buffered[key] = (key, entry.value, entry.at)
            self._since = min(self._since, step.at)

    def write(self, step: Step, since: float) -> None:
        """Write a step with the buffer; if its row cannot be written, the confirmation may still be."""
        quiet, performed = tuple(self._buffered.values()), self._taken_confirmations()

        def write(journal: JournalSink) -> None:
            try:
                journal.write(step, since=since, quiet=quiet, performed=performed)
            except Exception:
                with suppress(Exception):  # a disk that takes no row at all: the step's own failure is raised
                    _confirm(journal, performed)
                raise

        self._write(write)
        self.silent_from = step.at + QUIET_S if self._journal is not None else math.inf
        self._clear()

    def confirm(self, step: Step, *, may_wait: bool) -> None:
        """Write that a step's effects were carried out, where doing so twice may harm; of an earlier step at once.

        Args:
            step: Whose effects.
            may_wait: The next event is taken now, so it may be written along with that one's row.
        """
        is_late = bool(self._unconfirmed)
        if self._journal is not None and needs_confirmation(step):
            self._unconfirmed.append(step.seq)
        if is_late or not may_wait:
            self.flush()

    def flush(self) -> None:
        """Write the buffered confirmation."""
        if self._unconfirmed:
            self._write(lambda _: None)

    def settle(self, seq: int, how: str) -> None:
        """Write what has become of effects that no row confirmed."""
        self._write(lambda journal: journal.confirm(seq, how))

    def note(self, text: str, data: Any = None) -> None:
        """Write why there is no run, why it broke off, what may still move."""
        self._write(lambda journal: journal.note(text, data))

    def call(self) -> None:
        """There is an emergency: a runner that waits for the disk is notified at once; from any thread."""
        self._bell.put(True)

    def close(self) -> None:
        """The run is over; a disk that hangs is not waited for. Doing so twice changes nothing."""
        self._leave()

    def _give_up(self) -> None:
        """The journal is lost: nothing more is written."""
        self._journal, self.silent_from = None, math.inf
        self._unconfirmed.clear()
        self._clear()

    def _clear(self) -> None:
        self._buffered.clear()
        self._since = math.inf

    def _taken_confirmations(self) -> Sequence[int]:
        """The steps whose confirmation is written now; the buffer holds none any more."""
        performed, self._unconfirmed = self._unconfirmed, []
        return performed

    def _write(self, write: Callable[[JournalSink], object]) -> None:
        """Have something written, behind the buffered confirmation, and wait until it is."""
        if (journal := self._journal) is None:
            return
        begun_at, outcome = list[float](), list[BaseException | None]()
        performed = self._taken_confirmations()

        def do() -> None:
            begun_at.append(time.monotonic())
            try:
                _confirm(journal, performed)
                write(journal)
                outcome.append(None)
            except BaseException as error:  # noqa: BLE001 - raised below, on the thread that waits
                outcome.append(error)

        THREADS.do(do, lambda: self._bell.put(False))
        try:
            self._wait(begun_at, outcome)
            if outcome[0] is not None:
                raise outcome[0]
        except Exception:
            self._give_up()
            raise

    def _wait(self, begun_at: Sequence[float], outcome: Sequence[object]) -> None:
        """Wait for the outcome of what a thread begins to do at some time.

        Raises:
            ConnectorError: It was begun long ago.
        """
        while not outcome:
            until = begun_at[0] + LONGEST_S if begun_at else math.inf
            try:
                is_call = self._bell.get(timeout=max(0.0, min(until - time.monotonic(), LONGEST_S)))
            except queue.Empty:
                if until <= time.monotonic() and not outcome:
                    raise ConnectorError(f"its disk has not answered for {LONGEST_S:g} s") from None
                continue
            if is_call:
                self._called()


def _confirm(journal: JournalSink, performed: Iterable[int]) -> None:
    for seq in performed:
        journal.confirm(seq, "performed")


def raised_by(write: Callable[[], None]) -> Exception | None:
    """What writing raises: whatever the reason, what is not written down may not be done."""
    try:
        write()
    except Exception as error:  # noqa: BLE001 - see above
        return error
    return None
