# SPDX-License-Identifier: Apache-2.0
"""Answers written down beforehand, for tests, demonstrations and replays."""

from __future__ import annotations

import threading
from collections import deque
from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rai_missions.engine.decision import Question

__all__ = ("ScriptAnswerer",)

Line = str | Mapping[str, Any] | None
"""An option's name; or an answer as `Answerer` has it; or None, to stay silent for ever."""


class ScriptAnswerer:
    """Gives each state's answers in the order written, then is absent.

    Args:
        script: The state that asks → its answers.
    """

    def __init__(self, script: Mapping[str, Iterable[Line]]) -> None:
        self._lines = {state: deque(lines) for state, lines in script.items()}
        self._asked: list[Question] = []
        self._withdrawn: list[int] = []
        self._lock = threading.Lock()

    @property
    def asked(self) -> tuple[Question, ...]:
        """What was asked so far, oldest first."""
        with self._lock:
            return tuple(self._asked)

    @property
    def withdrawn(self) -> tuple[int, ...]:
        """The numbers of the questions that were withdrawn, oldest first."""
        with self._lock:
            return tuple(self._withdrawn)

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Answer before returning, unless the script is silent here."""
        with self._lock:
            self._asked.append(question)
            lines = self._lines.get(question.state)
            line: Line = lines.popleft() if lines else {"absent": f"the script has nothing more for '{question.state}'"}
        if line is not None:
            answer({"option": line, "parameters": {}, "why": "scripted"} if isinstance(line, str) else dict(line))

    def withdraw(self, number: int) -> None:
        with self._lock:
            self._withdrawn.append(number)
