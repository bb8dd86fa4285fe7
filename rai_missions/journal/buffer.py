# SPDX-License-Identifier: Apache-2.0
"""Writes a run down: steps at once, blackboard writes that enabled nothing along with the next row.

Rule: of each key only the newest value travels, and none travels longer than a second.
Rule: a run continues only when its row is written, but a disk that hangs holds up no e-stop.
"""

from __future__ import annotations

import math
import os
import queue
import threading
import time
import weakref
from collections.abc import Callable
from pathlib import Path
from typing import Any, Protocol

from rai_missions.connectors.worker import Worker
from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError
from rai_missions.journal.in_flight import needs_confirmation
from rai_missions.keys import Blackboard

__all__ = ("LONGEST_S", "BufferedWriter", "JournalSink", "raised_by")

QUIET_S = 1.0
"""How long a write that enabled nothing may travel before it is written down, and a running timer be silent."""
MOST_FREE = 4
"""So many threads wait for the next row to write; each takes 16 kB."""
LONGEST_S = 10.0
"""A disk that has not taken a row by then is one that cannot be written."""


class JournalSink(Protocol):
    """What a run is written to: `rai_missions.journal.Journal`."""

    path: Path

    def write(self, step: Step, *, since: float, quiet: Any = ()) -> int: ...

    def confirm(self, number: int, how: str) -> int: ...

    def note(self, text: str, data: Any = None) -> int: ...


class DiskThreads:
    """The threads of a process that wait for disks: one for each row that is being written, and a few that are free.

    A disk that hangs holds up the thread that waits for it, and no other journal. Without journals there are none.
    """

    def __init__(self) -> None:
        self._lock = threading.Lock()
        self._free: list[Worker] = []
        self._journals = 0

    def forget(self) -> None:
        """This process is a copy of another, whose threads it does not have."""
        self._lock, self._free, self._journals = threading.Lock(), [], 0

    def enter(self) -> None:
        """A journal may be written from now on."""
        with self._lock:
            self._journals += 1

    def leave(self) -> None:
        """It is not written any more; after the last one the free threads end."""
        with self._lock:
            self._journals -= 1
            ended, self._free = (self._free, []) if not self._journals else ([], self._free)
        for worker in ended:
            worker.close()

    def do(self, work: Callable[[], object], done: Callable[[], object]) -> None:
        """Have something done on a thread that is free, and then have that known."""
        with self._lock:
            worker = self._free.pop() if self._free else Worker("journal")

        def run() -> None:
            work()
            self._give_back(worker)  # before that is known, so that who learns of it finds the thread free
            done()

        worker.post(run)

    def _give_back(self, worker: Worker) -> None:
        with self._lock:
            is_kept = bool(self._journals) and len(self._free) < MOST_FREE
            if is_kept:
                self._free.append(worker)
        if not is_kept:
            worker.close()


THREADS = DiskThreads()
os.register_at_fork(after_in_child=THREADS.forget)


class BufferedWriter:
    """Between a runner and its journal; the disk is waited for on another thread.

    What the journal raises, each method that writes raises; `ConnectorError` also where the disk took too long: whether
    the row was written is not known then, and no more will be.

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
        self._is_lost = False
        self._carried: dict[str, tuple[str, Any, float]] = {}
        self._since = self.silent_from = math.inf
        """`silent_from`: the instant from which nothing reports any more how far the run's clock had come."""
        self.path = str(journal.path) if journal is not None else None

    @property
    def due(self) -> float:
        """The instant at which what travels must be written down; infinity if nothing does."""
        return self._since + QUIET_S

    def resume(self, at: float) -> None:
        """Write that the run was cut short, and continues at this instant of its clock."""
        self.note("resumed")
        self.silent_from = at + QUIET_S if self._journal is not None else math.inf

    def carry(self, step: Step, board: Blackboard) -> None:
        """Take a step that only wrote the blackboard."""
        if self._journal is None:
            return
        for key, _ in step.writes:
            entry = board[key]
            self._carried[key] = (key, entry.value, entry.at)
            self._since = min(self._since, step.at)

    def write(self, step: Step, since: float) -> None:
        """Write a step with what travels."""
        quiet = tuple(self._carried.values())
        self._write(lambda journal: journal.write(step, since=since, quiet=quiet))
        self.silent_from = step.at + QUIET_S if self._journal is not None else math.inf
        self._clear()

    def confirm(self, step: Step) -> None:
        """Write that a step's effects were carried out, where doing so twice may harm."""
        if needs_confirmation(step):
            self.settle(step.seq, "performed")

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

    def give_up(self) -> None:
        """The journal is lost: nothing more is written."""
        self._journal, self.silent_from = None, math.inf
        self._clear()

    def _clear(self) -> None:
        self._carried.clear()
        self._since = math.inf

    def _write(self, write: Callable[[JournalSink], object]) -> None:
        """Have something written, and wait until it is."""
        if (journal := self._journal) is None:
            return
        until, why = time.monotonic() + LONGEST_S, f"its disk has not answered for {LONGEST_S:g} s"
        if self._is_lost:
            raise ConnectorError(why)
        outcome: list[BaseException | None] = []

        def do() -> None:
            try:
                write(journal)
                outcome.append(None)
            except BaseException as error:  # noqa: BLE001 - raised below, on the thread that waits
                outcome.append(error)

        THREADS.do(do, lambda: self._bell.put(False))
        while not outcome:
            try:
                is_call = self._bell.get(timeout=max(0.0, until - time.monotonic()))
            except queue.Empty:
                self._is_lost = True
                raise ConnectorError(why) from None
            if is_call:
                self._called()
        if outcome[0] is not None:
            raise outcome[0]


def raised_by(write: Callable[[], None]) -> Exception | None:
    """What writing raises: whatever the reason, what is not written down may not be done."""
    try:
        write()
    except Exception as error:  # noqa: BLE001 - see above
        return error
    return None
