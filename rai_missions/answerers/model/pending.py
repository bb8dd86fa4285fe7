# SPDX-License-Identifier: Apache-2.0
"""A question in work: it is answered once, in time, or not at all.

Rule: the first to close it wins; whatever comes later is dropped here and goes nowhere.
"""

from __future__ import annotations

import math
import threading
import time
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.engine.decision import Question

__all__ = ("GRACE_S", "PendingQuestion")

GRACE_S = 0.5
"""How much longer than its question the work on it may last: the run's clock decides first that time is over."""


class PendingQuestion:
    """One question that someone thinks about.

    Args:
        question: As it was asked.
        answer: Called at most once.
        longest_s: Wall time after which it is given up, where neither the question nor its budget is shorter.
    """

    def __init__(
        self, question: Question, answer: Callable[[Mapping[str, Any]], None], *, longest_s: float = math.inf
    ) -> None:
        self.question = question
        self.began = time.monotonic()
        seconds = question.budget.seconds
        self.budget_s = min(longest_s, math.inf if seconds is None else seconds)
        asked_s = question.until - question.at
        self.ends = self.began + min(self.budget_s, asked_s + GRACE_S if asked_s > 0 else math.inf)
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
