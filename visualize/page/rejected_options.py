# SPDX-License-Identifier: Apache-2.0
"""Why an option was not offered: what its guard was over what was known when the question was asked.

Rule: a guard that needs more than the journal holds (how long something has been so, a predicate) is not guessed at.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.engine.decision import Question
from rai_missions.engine.step import Step
from rai_missions.guards.view import Site, Test, Truth
from rai_missions.keys import Blackboard, Stamped
from rai_missions.mission.mission import Mission
from visualize.page.decision_sites import questions

__all__ = ("Offers",)

NOTHING: Mapping[str, Any] = {}


class Offers:
    """What is known along a run, and the guards of the options that are asked there."""

    def __init__(self, mission: Mission) -> None:
        self.at = 0.0
        self.board: Blackboard = {
            name: Stamped(key.initial, 0.0) for name, key in mission.blackboard.items() if key.initial is not None
        }
        self.active: frozenset[str] = frozenset()
        self.entered = self.true_since = self.event = self.answer = NOTHING
        self._tests: dict[str, dict[str, Test]] = {}
        for each in questions(mission):
            tests = self._tests.setdefault(each.owner, {})
            for name, guard in each.asked.guards():
                site = Site(each.place, mission.blackboard, each.state)
                test = guard.compiled(site)
                if not (site.held_guards or site.clocked or site.named):
                    tests[name] = test

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        """No predicate of the user's program is here."""
        return None

    def note(self, text: str) -> None:
        """The journal has the notes of its steps already."""

    def follow(self, step: Step, writes: list[tuple[str, Any, float]]) -> None:
        """Take over what is known from a step on, and where it led."""
        self.at = step.at
        self.board |= {key: Stamped(value, stamp) for key, value, stamp in writes}
        self.board = {key: entry for key, entry in self.board.items() if entry.value is not None}
        self.active = (self.active - set(step.exited)) | set(step.entered)

    def withheld(self, question: Question) -> dict[str, str]:
        """The options that were not offered and whose guard can be evaluated → `false` or `unknown`."""
        offered = {offer.name for offer in question.options}
        verdicts = {
            name: test(self) for name, test in self._tests.get(question.owner, {}).items() if name not in offered
        }
        return {name: "false" if value is False else "unknown" for name, value in verdicts.items() if value is not True}
