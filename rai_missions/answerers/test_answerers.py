# SPDX-License-Identifier: Apache-2.0
"""Answerers that break their promises, for anyone who must survive them."""

from __future__ import annotations

import threading
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rai_missions.engine.decision import Question

__all__ = ("ChatteringAnswerer", "LateAnswerer", "RaisingAnswerer", "SilentAnswerer")

OnAnswer = Callable[[Mapping[str, Any]], None]


class SilentAnswerer:
    """Takes every question and never answers."""

    def ask(self, question: Question, answer: OnAnswer) -> None:
        pass

    def withdraw(self, number: int) -> None:
        pass


class RaisingAnswerer:
    """Raises when it is asked, and when a question is withdrawn."""

    def ask(self, question: Question, answer: OnAnswer) -> None:
        raise RuntimeError("no answerer here")

    def withdraw(self, number: int) -> None:
        raise RuntimeError("no answerer here")


class ChatteringAnswerer:
    """Answers one question several times, whatever is asked.

    Args:
        answers: What it answers, one after the other, for each question; also what is no answer at all.
    """

    def __init__(self, answers: Iterable[Any]) -> None:
        self._answers = tuple(answers)

    def ask(self, question: Question, answer: OnAnswer) -> None:
        for each in self._answers:
            answer(each)

    def withdraw(self, number: int) -> None:
        pass


class LateAnswerer:
    """Answers when the test asks it to, withdrawn or not."""

    def __init__(self) -> None:
        self._open: dict[int, OnAnswer] = {}
        self._asked = threading.Condition()
        self.withdrawn: list[int] = []

    def ask(self, question: Question, answer: OnAnswer) -> None:
        with self._asked:
            self._open[question.number] = answer
            self._asked.notify_all()

    def withdraw(self, number: int) -> None:
        self.withdrawn.append(number)

    def answer(self, number: int, reply: Mapping[str, Any], *, within_s: float = 5.0) -> None:
        """Answer a question once it was asked; several times, if called several times.

        Raises:
            AssertionError: It was not asked in time.
        """
        with self._asked:
            assert self._asked.wait_for(lambda: number in self._open, within_s), f"question {number} was not asked"
            on_answer = self._open[number]
        on_answer(reply)
