# SPDX-License-Identifier: Apache-2.0
"""Answerers that break their promises, for anyone who must survive them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rai_missions.engine.decision import Question

__all__ = ("ChatteringAnswerer", "LateAnswerer", "RaisingAnswerer", "SilentAnswerer")

Tell = Callable[[Mapping[str, Any]], None]


class SilentAnswerer:
    """Takes every question and never answers."""

    def ask(self, question: Question, answer: Tell) -> None:
        pass

    def withdraw(self, number: int) -> None:
        pass


class RaisingAnswerer:
    """Raises when it is asked, and when a question is withdrawn."""

    def ask(self, question: Question, answer: Tell) -> None:
        raise RuntimeError("no answerer here")

    def withdraw(self, number: int) -> None:
        raise RuntimeError("no answerer here")


class ChatteringAnswerer:
    """Answers one question several times, whatever is said.

    Args:
        sayings: What it tells, one after the other, for each question; also what is no answer at all.
    """

    def __init__(self, sayings: Iterable[Any]) -> None:
        self._sayings = tuple(sayings)

    def ask(self, question: Question, answer: Tell) -> None:
        for saying in self._sayings:
            answer(saying)

    def withdraw(self, number: int) -> None:
        pass


class LateAnswerer:
    """Answers when the test says so, withdrawn or not."""

    def __init__(self) -> None:
        self._open: dict[int, Tell] = {}
        self._asked = threading.Condition()
        self.withdrawn: list[int] = []

    def ask(self, question: Question, answer: Tell) -> None:
        with self._asked:
            self._open[question.number] = answer
            self._asked.notify_all()

    def withdraw(self, number: int) -> None:
        self.withdrawn.append(number)

    def answer(self, number: int, said: Mapping[str, Any], *, within_s: float = 5.0) -> None:
        """Answer a question once it was asked; several times, if called several times.

        Raises:
            AssertionError: It was not asked in time.
        """
        with self._asked:
            assert self._asked.wait_for(lambda: number in self._open, within_s), f"question {number} was not asked"
            tell = self._open[number]
        tell(said)
