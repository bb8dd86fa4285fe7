# SPDX-License-Identifier: Apache-2.0
"""How much longer an open question has, because its run was paused."""

from __future__ import annotations

from rai_missions.step import Step
from rai_missions.verdict import Question

__all__ = ("Pauses",)


class Pauses:
    """The times at which a run was paused: a question that was open then has as much longer."""

    def __init__(self) -> None:
        self.at: float | None = None
        """When it was paused; None while it is not."""
        self._spans: tuple[tuple[float, float], ...] = ()

    def follow(self, step: Step) -> None:
        """Follow a step, on the run's thread."""
        if "paused" in step.notes:
            self.at = step.at
        elif "resumed" in step.notes and self.at is not None:
            self._spans = (*self._spans, (self.at, step.at - self.at))
            self.at = None

    def shifted(self, question: Question) -> Question:
        """A question with the time that it has by now; from any thread."""
        by_s = sum(length_s for began, length_s in self._spans if question.at <= began)
        return question._replace(until=question.until + by_s)
