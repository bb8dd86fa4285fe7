# SPDX-License-Identifier: Apache-2.0
"""The bounded worker: order, bound, policy, deadlines, failures, and an end that waits for no one who hangs."""

from __future__ import annotations

import gc
import logging
import math
import signal
import threading
from collections.abc import Iterator
from functools import partial
from typing import Any

import pytest

from rai_missions.connectors.worker import SerialQueue, Worker
from rai_missions.errors import ConnectorError, UsageError

PATIENCE_S = 30.0


class Held:
    """A worker whose thread is held by a piece of work until it is released."""

    def __init__(self, **options: Any) -> None:
        self.worker, self.done = Worker("held", **options), list[object]()
        self._begun, self._released = threading.Event(), threading.Event()
        self.worker.post(self._hold)
        assert self._begun.wait(PATIENCE_S)

    def _hold(self) -> None:
        self._begun.set()
        assert self._released.wait(PATIENCE_S)

    def post(self, *names: object) -> list[bool]:
        return [self.worker.post(lambda name=name: self.done.append(name)) for name in names]  # type: ignore[misc]

    def release(self) -> list[object]:
        """What is done once nothing holds it up, until its end."""
        self._released.set()
        assert self.worker.close(PATIENCE_S)
        return self.done


@pytest.fixture
def held() -> Iterator[Held]:
    made = Held()
    yield made
    made.release()


def test_work_is_done_in_its_order_and_all_that_waits_is_done_before_the_end(held: Held) -> None:
    assert held.post(*range(100)) == [True] * 100 and held.worker.waiting == 100
    assert held.release() == list(range(100))
    assert held.post("late") == [False], "it takes no more"
    assert held.done == list(range(100)) and not held.worker.is_alive


def test_beyond_the_bound_a_new_piece_is_refused_and_counted() -> None:
    held = Held(limit=2)
    assert held.post(1, 2, 3, 4) == [True, True, False, False] and held.worker.dropped == 2
    assert held.release() == [1, 2]


def test_or_the_oldest_is_dropped_which_is_logged_once(caplog: pytest.LogCaptureFixture) -> None:
    held = Held(limit=2, keep="newest")
    assert held.post(1, 2, 3, 4) == [True] * 4 and held.worker.dropped == 2
    assert held.release() == [3, 4]
    assert caplog.messages == ["'held' gets more than it can do; the oldest is dropped"]


def test_what_a_piece_raises_is_reported_and_the_next_is_done(caplog: pytest.LogCaptureFixture) -> None:
    def fail() -> None:
        raise SystemExit("no more")

    raised: list[BaseException] = []
    for worker in (Worker("mine", on_error=raised.append), Worker("plain")):
        worker.post(fail)
        worker.post(fail)
        assert worker.submit(lambda: 7).result(PATIENCE_S) == 7
        worker.close()
    assert [str(error) for error in raised] == ["no more", "no more"]
    assert caplog.messages == ["'plain' failed at a piece of work; later failures are not logged"]


def test_the_worlds_faults_are_logged_as_their_sentence(caplog: pytest.LogCaptureFixture) -> None:
    def fail() -> None:
        raise ConnectorError("the broker is gone")

    worker = Worker("status")
    worker.post(fail)
    assert worker.close(PATIENCE_S)
    (record,) = caplog.records
    assert record.getMessage().endswith(": the broker is gone") and record.levelno == logging.WARNING
    assert record.exc_info is None


def test_what_waits_behind_an_interrupted_piece_is_done_by_the_next_run() -> None:
    queue, done = SerialQueue(), list[str]()

    def interrupted() -> None:
        queue.post(partial(done.append, "behind"))
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        queue.post(interrupted)
    assert done == []
    queue.post(partial(done.append, "next"))
    assert done == ["behind", "next"]


def test_a_result_is_waited_for_and_what_was_raised_is_raised_there() -> None:
    worker = Worker("asked")
    assert worker.submit(threading.current_thread).result(PATIENCE_S).name == "asked"
    with pytest.raises(ZeroDivisionError):
        worker.submit(lambda: 1 / 0).result(PATIENCE_S)
    assert worker.close(PATIENCE_S)
    with pytest.raises(UsageError, match="'asked' takes no more work"):
        worker.submit(lambda: 7)


def test_a_piece_that_hangs_holds_up_the_end_for_no_longer_than_asked(held: Held) -> None:
    assert not held.worker.close(0.0)


def test_a_worker_may_begin_again(held: Held) -> None:
    held.release()
    held.worker.start()
    held.worker.start()
    assert held.post("again") == [True] and held.release() == ["again"]


def test_work_that_ends_its_own_worker_does_not_wait_for_itself() -> None:
    worker, ended = Worker("own end"), threading.Event()
    worker.post(lambda: worker.close() and ended.set())
    assert ended.wait(PATIENCE_S)


def test_what_is_due_is_done_before_what_waits_and_what_was_canceled_is_not(held: Held) -> None:
    held.post("posted")
    held.worker.after(math.inf, lambda: held.done.append("never"))
    held.worker.after(0.0, lambda: held.done.append("canceled"))()
    held.worker.after(0.0, lambda: held.done.append("due"))
    assert held.release() == ["due", "posted"], "and what is not due by the end is not done"


def test_a_repeated_piece_is_done_again_although_it_fails() -> None:
    worker, times = Worker("repeated", on_error=lambda _: None), list[int]()
    often = threading.Event()

    def look() -> None:
        times.append(1)
        if len(times) == 3:
            often.set()
        raise RuntimeError("each time")

    worker.every(0.001, look)
    assert often.wait(PATIENCE_S)
    worker.every(1e-9, look)
    assert worker.submit(len(times).bit_length).result(PATIENCE_S) and worker.close(PATIENCE_S), (
        "and what waits is done"
    )


def test_the_end_is_done_on_the_thread_also_when_the_worker_is_forgotten() -> None:
    ended = threading.Event()
    ends: list[str] = []

    def end() -> None:
        ends.append(threading.current_thread().name)
        ended.set()

    worker = Worker("forgotten", at_end=end)
    worker.post(lambda: None)
    del worker
    gc.collect()
    assert ended.wait(PATIENCE_S) and ends == ["forgotten"]


def test_a_signal_handler_may_post_while_its_thread_does() -> None:
    worker, done = Worker("signaled"), list[int]()
    before = signal.signal(signal.SIGUSR1, lambda *_: worker.post(lambda: done.append(0)))
    try:
        for _ in range(500):
            signal.raise_signal(signal.SIGUSR1)
            worker.post(lambda: done.append(1))
    finally:
        signal.signal(signal.SIGUSR1, before)
    assert worker.close(PATIENCE_S) and len(done) == 1000


def test_its_thread_holds_up_no_program_s_end(caplog: pytest.LogCaptureFixture) -> None:
    with caplog.at_level(logging.ERROR):
        held = Held()
        assert all(thread.daemon for thread in threading.enumerate() if thread.name == "held")
        held.release()
