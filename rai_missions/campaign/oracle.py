# SPDX-License-Identifier: Apache-2.0
"""The oracle: answers a decision by trying each option on a branch of the simulated world, and taking the best.

Rule: it knows what no robot can know, so it is a measure for other answerers. It looks into a simulated world alone,
and a profile of a real robot is refused.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.campaign.rollout import LONGEST_S, ROLLOUT_NEEDS, Branchable, OpenDecision, Rollout, rollouts
from rai_missions.engine import Chart
from rai_missions.engine.decision import Question
from rai_missions.errors import UsageError
from rai_missions.guards.view import View
from rai_missions.profile import Robot
from rai_missions.runtime.view import RunView

__all__ = ("OracleAnswerer",)

ORACLE = "oracle"
"""What it is called wherever answers are shown."""


class OracleAnswerer:
    """Looks ahead in a simulated world; an `Answerer`.

    It answers before `ask` returns: simulated time does not pass meanwhile, so no robot waits for it.

    Args:
        robot: The profile of the run.
        longest_s: Simulated seconds that an option is followed, at most until the next question.

    Raises:
        UsageError: The profile is of a real robot.
    """

    def __init__(self, robot: Robot, *, longest_s: float = LONGEST_S) -> None:
        if not robot.world:
            raise UsageError(
                f"the oracle tries options in a copy of a simulated world, and the profile '{robot.name}' has none: "
                "it cannot answer for a real robot"
            )
        self._robot, self._longest_s = robot, longest_s
        self._world: Branchable | None = None
        self._view: RunView | None = None
        self.found: dict[str, Rollout] = {}
        """What came of each option of the last question."""

    def look_in(self, world: object) -> None:
        """The world of the run.

        Raises:
            UsageError: It cannot be branched, or nothing measures harm in it.
        """
        if not isinstance(world, Branchable):
            raise UsageError(f"the oracle needs a world with {ROLLOUT_NEEDS}, not {world!r}")
        self._world = world

    def read_from(self, view: View) -> None:
        """Look ahead from this run from now on."""
        self._view = view if isinstance(view, RunView) else None

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Try each option that is offered, and answer before returning."""
        if self._world is None or self._view is None:
            answer({"absent": f"the {ORACLE} was given no simulated world to look into"})
            return
        try:
            self.found = self._rollouts(self._world, self._view.branch(), self._view.run, question)
        except UsageError as fault:
            answer({"failed": f"the {ORACLE} cannot look ahead: {fault}"})
            return
        best = min(self.found.values(), key=lambda each: each.rank, default=None)
        if best is None:
            answer({"absent": f"the {ORACLE} tries options without parameters, and there is none"})
            return
        each = ", ".join(f"{name}: {found.verdict}" for name, found in self.found.items())
        answer({"option": best.option, "parameters": {}, "why": f"{ORACLE}, tried in a copy of the world: {each}"})

    def _rollouts(self, world: Branchable, chart: Chart, run: str, question: Question) -> dict[str, Rollout]:
        free = tuple(offer.name for offer in question.options if offer.parameters is None)
        if not free:
            return {}
        decision = OpenDecision(world, chart, self._robot, run, question.state)
        return rollouts(decision, free, longest_s=self._longest_s)

    def withdraw(self, number: int) -> None:
        """Nothing is ever under way."""
