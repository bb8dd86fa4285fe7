# SPDX-License-Identifier: Apache-2.0
"""Questions in work: each is answered once, in time, or not at all.

Rule: the first to close it wins; whatever comes later is dropped here and goes nowhere.
"""

from __future__ import annotations

import math
import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple

from rai_missions.connectors.worker import Worker
from rai_missions.engine.decision import Question

__all__ = ("PendingQuestion", "QuestionThreads")

Work = Callable[[], Mapping[str, Any]]
GRACE_S = 0.5
"""How much longer than its question the work on it may last: the run's clock decides first that time is over."""


class PendingQuestion:
    """One question that someone thinks about.

    Args:
        question: As it was asked.
        answer: Called at most once.
        longest_s: Wall time after which it is given up, where neither the question nor its budget is shorter.
        is_hurried: The question's own time is wall time. Else its run alone ends it: a pause stops that time.
    """

    def __init__(
        self,
        question: Question,
        answer: Callable[[Mapping[str, Any]], None],
        *,
        longest_s: float = math.inf,
        is_hurried: bool = True,
    ) -> None:
        self.question = question
        self.began = time.monotonic()
        seconds = question.budget.seconds
        self.budget_s = min(longest_s, math.inf if seconds is None else seconds)
        self.asked_s = question.until - question.at
        """The question's own time."""
        is_bounded = is_hurried and self.asked_s > 0
        self.ends = self.began + min(self.budget_s, self.asked_s + GRACE_S if is_bounded else math.inf)
        """On `time.monotonic`."""
        self._on_answer = answer
        self._lock = threading.Lock()
        self._open = True
        self._closers: list[Callable[[], object]] = []

    @property
    def open(self) -> bool:
        """No one has answered yet, and someone still waits for it."""
        return self._open

    @property
    def left_s(self) -> float:
        """Wall time left; infinity where nothing bounds it."""
        return self.ends - time.monotonic()

    @property
    def taken_s(self) -> float:
        """Wall time since it was asked."""
        return time.monotonic() - self.began

    def when_closed(self, do: Callable[[], object]) -> None:
        """Have something done once, as soon as it is closed; at once where it is. It must not wait."""
        with self._lock:
            if self._open:
                self._closers.append(do)
                return
        do()

    def close(self) -> bool:
        """Whether this call closed it; from now on it answers nothing."""
        with self._lock:
            was, self._open = self._open, False
            closers, self._closers = self._closers, []
        for do in closers:
            do()
        return was

    def reply(self, answer: Mapping[str, Any]) -> bool:
        """Answer, unless it is closed; whether the answer went out."""
        if not self.close():
            return False
        self._on_answer(answer)
        return True


class QuestionWork(NamedTuple):
    """A question, and what gives its answer."""

    pending: PendingQuestion
    work: Work


class QuestionThreads:
    """Questions in work, each on a thread of its own.

    Python cannot end a thread that hangs in a model: these are daemons, which do not hold up the program's end.

    Args:
        name: What one is called, for the names of threads: `question`.
        most: How many may be in work; one that hangs counts until it comes back.
    """

    def __init__(self, name: str, most: int) -> None:
        self._name, self._most = name, most
        self._lock = threading.Lock()
        self._pending: dict[int, PendingQuestion] = {}
        self._waiting: deque[QuestionWork] = deque()
        """What begins on the next thread that comes back."""
        self._threads: set[threading.Thread] = set()
        self._deadlines = Worker(f"deadlines of {name}s")

    def begin(self, pending: PendingQuestion, work: Work, give_up: Callable[[], object], *, waits: bool = False) -> int:
        """Have a question worked on, unless there are too many; so many are in work then, else 0.

        Args:
            pending: The question.
            work: Gives its answer.
            give_up: Done once its time is over and it has no answer.
            waits: Where there are too many, it waits for one of them to come back, in its own time.
        """
        number, job = pending.question.number, QuestionWork(pending, work)
        thread = threading.Thread(target=self._do, args=(job,), name=f"{self._name} {number}", daemon=True)
        with self._lock:
            busy = len(self._threads)
            if busy >= self._most and not waits:
                return busy
            self._pending[number] = pending
            if busy < self._most:
                self._threads.add(thread)
            else:
                self._waiting.append(job)
        self._deadlines.start()
        pending.when_closed(partial(self._forget, job))
        pending.when_closed(self._deadlines.after(pending.left_s, give_up))
        if busy < self._most:
            thread.start()
        return 0

    def drop(self, number: int) -> None:
        """A question is no longer asked; what comes back is dropped."""
        with self._lock:
            pending = self._pending.get(number)
        if pending is not None:
            pending.close()

    def stop(self, within_s: float, end_model: Callable[[], object]) -> None:
        """Drop every question, end what the threads wait for and wait for them, so long at most."""
        ends = time.monotonic() + within_s
        with self._lock:
            dropped, threads = list(self._pending.values()), list(self._threads)
        for pending in dropped:
            pending.close()
        self._deadlines.close(within_s)
        end_model()
        for thread in threads:
            if thread.ident is not None and thread is not threading.current_thread():  # one may be about to begin
                thread.join(max(0.0, ends - time.monotonic()))

    def _do(self, job: QuestionWork | None) -> None:
        while job is not None:
            pending = job.pending
            try:
                answer = job.work()
            except BaseException as error:  # noqa: BLE001 - a thread that dies would count as one that hangs, for ever
                answer = {"failed": f"the answer could not be read: {type(error).__name__}"}
            job = self._next()
            pending.reply(answer)

    def _next(self) -> QuestionWork | None:
        """What waits; where nothing does, this thread ends."""
        with self._lock:
            if self._waiting:
                return self._waiting.popleft()
            self._threads.discard(threading.current_thread())
        return None

    def _forget(self, job: QuestionWork) -> None:
        """A question is closed."""
        with self._lock:
            number = job.pending.question.number
            if self._pending.get(number) is job.pending:
                del self._pending[number]
            if job in self._waiting:
                self._waiting.remove(job)
