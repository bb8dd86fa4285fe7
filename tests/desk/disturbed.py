# SPDX-License-Identifier: Apache-2.0
"""Hostile answers amid a handover: control is taken and given, the run pauses, old questions are answered, things move.

Rule: as in `hostile.py`, the person confirms whatever is read back.
"""

from __future__ import annotations

import random
from typing import Any

from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step
from rai_missions.event import Event, Tick
from tests.desk.hostile import Trial
from tests.desk.scenes import Case

__all__ = ("Disturbed",)

LAST_S = 60.0
ROUND_S = 0.5
MOST_ASKED = 900
SHIFT_M = 0.05
KINDS = ("control", "control", "command", "late", "late", "gone", "shift")


class Disturbed(Trial):
    """One desk, one request, who answers, and what happens meanwhile; arguments as `Trial` has them."""

    def __init__(self, seed: int, case: Case | None = None, goal: Any = None) -> None:
        super().__init__(seed, case, goal)
        self._chance, self._numbers = random.Random(f"disturbed {seed}"), list[int]()

    def _see(self) -> None:
        super()._see()
        if self.chart.unstarted:
            return
        self.at += ROUND_S
        self._disturb()
        for question in self.chart.questions:  # one that was left open, or is open again
            if not self._is_over and self.asked < MOST_ASKED:
                self.asked += 1
                self._note(self._answer(question))

    @property
    def _is_over(self) -> bool:
        return self.acted or self.chart.outcome is not None or self.at > LAST_S

    def _answer(self, question: Question) -> Step:
        self._numbers.append(question.number)
        self._disturb()
        if self._is_over or self._chance.random() < 0.4:
            return self.chart.send(Tick(self.at))
        return super()._answer(question)

    def _disturb(self) -> None:
        for _ in range(self._chance.randint(0, 2)):
            if not self._is_over and (event := self._event(self._chance.choice(KINDS))) is not None:
                self._note(self.chart.send(event))

    def _event(self, kind: str) -> Event | None:
        chance, at = self._chance, self.at
        if kind == "control":
            by = chance.choice([{"by": "operator", "role": "operator"}, {"by": "mission"}, {"by": "robot"}])
            return Event(chance.choice(["operator", "nobody", "agent", "autonomy"]), at, by, kind)
        if kind == "command":
            return Event(chance.choice(["pause", "resume", "resume", "stop"]), at, {"by": "operator"}, kind)
        if kind == "late" and self._numbers:
            again = {"option": "say", "parameters": {"request": self.case.request}}
            who, answer = chance.choice(
                [("agent", self.of_model()), ("operator", {"option": "yes"}), ("operator", again)]
            )
            return Event(who, at, answer, "proposal", chance.choice(self._numbers))
        if kind == "gone":
            seen = {"things": [], "gripper": "empty", "unsure": 0, "looks": 30, "stamp_s": at}
            return Event("objects", at, {"value": seen}, "write")
        if kind == "shift":
            chance.choice(self.case.world["scene"]["objects"])["pose"]["x"] += chance.uniform(-SHIFT_M, SHIFT_M)
        return None
