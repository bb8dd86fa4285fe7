# SPDX-License-Identifier: Apache-2.0
"""Journals share the threads that wait for disks, and no disk waits for another."""

from __future__ import annotations

import gc
import queue
import threading
import time
from collections.abc import Callable, Iterable
from hashlib import sha256
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from rai_missions.engine.step import Step
from rai_missions.journal import buffer
from rai_missions.journal.buffer import BufferedWriter, raised_by
from rai_missions.journal.disk_threads import MOST_FREE, DiskThreads

PATIENCE_S = 30.0


class Disk:
    """Notes what is written, on a disk that may hang."""

    def __init__(self, hangs: threading.Event | None = None) -> None:
        self.path, self.hangs, self.notes = Path("none"), hangs, list[str]()
        self.is_waiting = threading.Event()

    def write(self, step: Step, *, since: float, quiet: Any = (), performed: Any = ()) -> int:
        return 0

    def confirm(self, number: int, how: str) -> int:
        return 0

    def note(self, text: str, data: Any = None) -> int:
        self.is_waiting.set()
        if self.hangs is not None:
            assert self.hangs.wait(PATIENCE_S)
        self.notes.append(text)
        return 0


class BusyDisk(Disk):
    """Takes 20 ms of the processor for a row, and lets nothing else be computed meanwhile."""

    def note(self, text: str, data: Any = None) -> int:
        begun = time.thread_time()
        while time.thread_time() < begun + 0.02:
            sha256(bytes(1_000))  # of more, the library lets others compute
        return super().note(text, data)


@pytest.fixture(autouse=True)
def _alone() -> None:
    """Runs of other tests that never began have a journal, and so a thread, until they are forgotten."""
    gc.collect()


def waiting_for_disks() -> set[threading.Thread]:
    return {thread for thread in threading.enumerate() if thread.name == "journal"}


def write_at_once(writers: Iterable[BufferedWriter], write: Callable[[Any], None], given: Iterable[Any]) -> None:
    """Call a function with each of what is given, on a thread for each, and close the writers."""
    threads = [threading.Thread(target=write, args=(each,)) for each in given]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(PATIENCE_S)
    for writer in writers:
        writer.close()


def test_a_disk_that_hangs_holds_up_no_other_journal() -> None:
    before, answers = waiting_for_disks(), threading.Event()
    slow, disks = Disk(answers), [Disk() for _ in range(20)]
    writer = BufferedWriter(slow)
    thread = threading.Thread(target=writer.note, args=("slow",))
    thread.start()
    assert slow.is_waiting.wait(PATIENCE_S)
    others = [BufferedWriter(disk) for disk in disks]
    for number in range(3):
        for other in others:
            other.note(str(number))
    assert [disk.notes for disk in disks] == [["0", "1", "2"]] * 20 and slow.notes == []
    assert len(waiting_for_disks() - before) <= 2, "one waits for the disk that hangs, one does for all others"
    answers.set()
    thread.join(PATIENCE_S)
    for each in (writer, *others):
        each.close()
        each.close()
    assert slow.notes == ["slow"] and waiting_for_disks() <= before


def test_disks_that_hang_hold_up_no_other_journal_however_many_they_are() -> None:
    before, answers = waiting_for_disks(), threading.Event()
    slow = [Disk(answers) for _ in range(3 * MOST_FREE)]
    writers = [BufferedWriter(disk) for disk in slow]
    threads = [threading.Thread(target=writer.note, args=("slow",)) for writer in writers]
    for thread, disk in zip(threads, slow, strict=True):
        thread.start()
        assert disk.is_waiting.wait(PATIENCE_S)
    other = BufferedWriter(quick := Disk())
    for number in range(3):
        other.note(str(number))
    assert quick.notes == ["0", "1", "2"] and not any(disk.notes for disk in slow)
    answers.set()
    for thread in threads:
        thread.join(PATIENCE_S)
    for each in (*writers, other):
        each.close()
    assert [disk.notes for disk in slow] == [["slow"]] * len(slow)
    for left in waiting_for_disks() - before:
        left.join(PATIENCE_S)
    assert waiting_for_disks() <= before


def test_a_row_that_waits_behind_those_of_others_is_not_given_up(monkeypatch: pytest.MonkeyPatch) -> None:
    """However many there are and however long it takes: a disk that was not asked yet cannot be one that hangs."""
    monkeypatch.setattr(buffer, "LONGEST_S", 1.6)  # of three seconds for them all
    monkeypatch.setattr(buffer, "time", SimpleNamespace(monotonic=time.process_time))  # what others compute is no wait
    before, disks, faults = waiting_for_disks(), [BusyDisk() for _ in range(150)], list[Exception]()
    writers = [BufferedWriter(disk) for disk in disks]

    def write(writer: BufferedWriter) -> None:
        if (fault := raised_by(lambda: writer.note("row"))) is not None:
            faults.append(fault)

    write_at_once(writers, write, writers)
    assert faults == [] and all(disk.notes == ["row"] for disk in disks)
    for left in waiting_for_disks() - before:
        left.join(PATIENCE_S)


@given(st.lists(st.integers(0, 11), max_size=40))
def test_each_journal_has_its_rows_in_their_order_whichever_thread_writes_them(order: list[int]) -> None:
    before, disks = waiting_for_disks(), [Disk() for _ in range(12)]
    writers = [BufferedWriter(disk) for disk in disks]

    def write(number: int) -> None:
        for place, each in enumerate(order):
            if each == number:
                writers[number].note(str(place))

    write_at_once(writers, write, range(12))
    assert [disk.notes for disk in disks] == [
        [str(place) for place, each in enumerate(order) if each == number] for number in range(12)
    ]
    for thread in waiting_for_disks() - before:  # more than are kept end by themselves
        thread.join(PATIENCE_S)
    assert waiting_for_disks() <= before


def test_a_disk_is_asked_within_moments_behind_many_that_hang() -> None:
    before, answers, count = waiting_for_disks(), threading.Event(), 20
    slow = [Disk(answers) for _ in range(count)]
    writers = [BufferedWriter(disk) for disk in slow]
    threads = [threading.Thread(target=writer.note, args=("slow",)) for writer in writers]
    begun = time.monotonic()
    for thread in threads:
        thread.start()
    other = BufferedWriter(quick := Disk())
    other.note("quick")
    assert time.monotonic() - begun < buffer.LONGEST_S / 2 and quick.notes == ["quick"]
    answers.set()
    for thread in threads:
        thread.join(PATIENCE_S)
    for each in (*writers, other):
        each.close()
    assert all(disk.notes == ["slow"] for disk in slow)
    for left in waiting_for_disks() - before:
        left.join(PATIENCE_S)


class CountingBell(queue.SimpleQueue[bool]):
    """Counts how often it is waited for."""

    waits = 0

    def get(self, block: bool = True, timeout: float | None = None) -> bool:
        self.waits += 1
        return super().get(block, timeout)


def test_a_row_that_waits_behind_those_of_others_is_not_woken_before_it_is_written(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    before, disks = waiting_for_disks(), [BusyDisk() for _ in range(25)]
    writers, bells = [BufferedWriter(disk) for disk in disks], [CountingBell() for _ in disks]
    for writer, bell in zip(writers, bells, strict=True):
        monkeypatch.setattr(writer, "_bell", bell)
    write_at_once(writers, lambda writer: writer.note("row"), writers)
    assert [bell.waits for bell in bells] == [1] * len(disks)
    for left in waiting_for_disks() - before:
        left.join(PATIENCE_S)


class QueueWithLatecomer(queue.SimpleQueue[Any]):
    """Something comes in the moment in which a thread has taken what came before."""

    latecomer: Callable[[], None] = staticmethod(lambda: None)

    def get(self, block: bool = True, timeout: float | None = None) -> Any:
        job = super().get(block, timeout)
        late, self.latecomer = self.latecomer, lambda: None
        late()
        return job


def test_what_comes_while_a_thread_takes_a_row_of_a_disk_that_hangs_is_written(monkeypatch: pytest.MonkeyPatch) -> None:
    threads, jobs, answers, is_written = DiskThreads(), QueueWithLatecomer(), threading.Event(), threading.Event()
    monkeypatch.setattr(threads, "_jobs", jobs)
    threads.enter()
    first = threading.Event()
    threads.do(first.set, lambda: None)  # a thread waits from now on
    assert first.wait(PATIENCE_S)
    monkeypatch.setattr(jobs, "latecomer", lambda: threads.do(is_written.set, lambda: None))
    threads.do(lambda: answers.wait(PATIENCE_S), lambda: None)
    assert is_written.wait(PATIENCE_S / 3), "no thread was started, though the only one waits for a disk"
    answers.set()
    threads.leave()
