# SPDX-License-Identifier: Apache-2.0
"""Writes a run down: steps at once, blackboard writes that enabled nothing along with the next row.

Rule: of each key only the newest value travels, and none travels longer than a second.
Rule: a confirmation travels only while the event is taken that waits already, and has its own row before the next. It
is lost with that event's row only where the disk takes neither.
Rule: a run continues only when its row is written, but a disk that hangs holds up no e-stop. A wait behind the rows of
others ends no run.
"""

from __future__ import annotations

import math
import os
import queue
import threading
import time
import weakref
from collections.abc import Callable, Iterable, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, Protocol, runtime_checkable

from rai_missions.connectors.worker import Worker
from rai_missions.engine.step import Step
from rai_missions.errors import ConnectorError
from rai_missions.journal.in_flight import needs_confirmation
from rai_missions.keys import Blackboard

__all__ = ("LONGEST_S", "BufferedWriter", "JournalSink", "raised_by")

QUIET_S = 1.0
"""How long a write that enabled nothing may travel before it is written down, and a running timer be silent."""
MOST_FREE = 1
"""Threads that wait for the next row. One that is busy takes row after row without being woken."""
HURRY_S = 0.02
"""Where no thread has taken a row for so long, and one waits, all of them wait for disks. It is looked at so often."""
LONGEST_S = 10.0
"""A disk that has not taken a row so long after a thread began to write it is one that cannot be written."""
Job = tuple[Callable[[], object], Callable[[], object]]
"""What is to be done, and how that is made known."""


@runtime_checkable
class JournalSink(Protocol):
    """What a run is written to: `rai_missions.journal.Journal`."""

    path: Path

    def write(self, step: Step, *, since: float, quiet: Any = (), performed: Iterable[int] = ()) -> int: ...

    def confirm(self, number: int, how: str) -> int: ...

    def note(self, text: str, data: Any = None) -> int: ...


class DiskThreads:
    """The threads of a process that wait for disks: one, and one more where all of them wait for one that is slow.

    What is to be written waits for a thread in the order in which it came. Without journals there are none.
    """

    def __init__(self) -> None:
        self.forget()

    def forget(self) -> None:
        """Begin again in a forked process, which has none of its parent's threads."""
        self._lock = threading.Lock()
        self._jobs: queue.SimpleQueue[Job | None] = queue.SimpleQueue()
        self._idle: set[threading.Thread] = set()
        self._journals = self._count = 0
        self._taken_at = -math.inf
        self._watch, self._is_watched = Worker("rows that wait"), False

    def enter(self) -> None:
        """A journal may be written from now on."""
        with self._lock:
            self._journals += 1

    def leave(self) -> None:
        """Count out a journal that is not written any more; after the last one the idle threads end."""
        with self._lock:
            self._journals -= 1
            if self._journals:
                return
            ended, jobs, watch = self._idle, self._jobs, self._watch
            self._idle, self._jobs, self._count = set(), queue.SimpleQueue(), 0
            self._watch, self._is_watched = Worker("rows that wait"), False
        watch.close()
        for _ in ended:
            jobs.put(None)
        for thread in ended - {threading.current_thread()}:
            thread.join(LONGEST_S)

    def do(self, work: Callable[[], object], done: Callable[[], object]) -> None:
        """Have something done on a thread, and then have that known."""
        self._jobs.put((work, done))
        if self._jobs.qsize() > len(self._idle):
            if self._count < MOST_FREE:
                self._start()
            self._watch_over()

    def _watch_over(self) -> None:
        """Something waits for a thread: look from now on whether any is free."""
        if not self._is_watched:
            with self._lock:
                is_first, self._is_watched = not self._is_watched, True
            if is_first:
                self._watch.after(HURRY_S, self._look)

    def _look(self) -> None:
        """While something waits for a thread, have another one where none has taken anything for `HURRY_S`."""
        with self._lock:
            self._is_watched = False  # from here on, what comes is seen in the queue or begins to look itself
            self._is_watched = is_watched = not self._jobs.empty()
        if is_watched:
            self._watch.after(HURRY_S, self._look)
            if time.monotonic() - self._taken_at >= HURRY_S:
                self._start()

    def _start(self) -> None:
        with self._lock:
            self._count += 1
            jobs = self._jobs
        threading.Thread(target=self._work, args=(jobs,), name="journal", daemon=True).start()

    def _work(self, jobs: queue.SimpleQueue[Job | None]) -> None:
        thread = threading.current_thread()
        is_kept = self._is_kept(thread, jobs)
        while is_kept and (job := jobs.get()) is not None:
            with self._lock:
                self._idle.discard(thread)
                self._taken_at = time.monotonic()
            if not jobs.empty():  # it came when this thread still counted as idle
                self._watch_over()
            work, done = job
            work()
            is_kept = self._is_kept(thread, jobs)  # before that is known: who learns of it finds the thread free
            done()
            del job, work, done

    def _is_kept(self, thread: threading.Thread, jobs: queue.SimpleQueue[Job | None]) -> bool:
        """Whether a thread waits for more to do."""
        with self._lock:
            is_of_now = jobs is self._jobs
            is_kept = is_of_now and (not jobs.empty() or (bool(self._journals) and len(self._idle) < MOST_FREE))
            if is_kept:
                self._idle.add(thread)
            elif is_of_now:
                self._count -= 1
        return is_kept


THREADS = DiskThreads()
os.register_at_fork(after_in_child=THREADS.forget)


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
        self._carried: dict[str, tuple[str, Any, float]] = {}
        self._performed: list[int] = []
        """The steps whose confirmation travels."""
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
        """Write a step with what travels; if its row cannot be written, the confirmation may still be."""
        quiet, performed = tuple(self._carried.values()), self._no_longer_travels()

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

    def confirm(self, step: Step, *, may_travel: bool) -> None:
        """Write that a step's effects were carried out, where doing so twice may harm; of an earlier step at once.

        Args:
            step: Whose effects.
            may_travel: The next event is taken now, so it may be written along with that one's row.
        """
        is_late = bool(self._performed)
        if self._journal is not None and needs_confirmation(step):
            self._performed.append(step.seq)
        if is_late or not may_travel:
            self.flush()

    def flush(self) -> None:
        """Write the confirmation that travels."""
        if self._performed:
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
        self._performed.clear()
        self._clear()

    def _clear(self) -> None:
        self._carried.clear()
        self._since = math.inf

    def _no_longer_travels(self) -> Sequence[int]:
        """The steps whose confirmation is written now."""
        performed, self._performed = self._performed, []
        return performed

    def _write(self, write: Callable[[JournalSink], object]) -> None:
        """Have something written, behind the confirmation that travels, and wait until it is."""
        if (journal := self._journal) is None:
            return
        begun_at, outcome = list[float](), list[BaseException | None]()
        performed = self._no_longer_travels()

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
