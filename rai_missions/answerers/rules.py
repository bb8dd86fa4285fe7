# SPDX-License-Identifier: Apache-2.0
"""A policy that answers at once: rows of guard → option, from the robot profile.

Rule: rows are tried in the order written; unknown takes no row, and a row counts only where its option is offered.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple, Self

from rai_missions.engine.decision import Question
from rai_missions.errors import raised_text
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site, Test, View
from rai_missions.keys import Key
from rai_missions.profile import Robot
from rai_missions.redaction import cut

__all__ = ("RulesAnswerer",)


class AnswerRule(NamedTuple):
    """One rule compiled."""

    test: Test | None
    option: str
    why: str


class RulesAnswerer:
    """Answers by the first row of the asking state that holds now and whose option is offered.

    Args:
        rules: The state that asks → its rows: a guard, or None for one that always holds, and an option.
        keys: The mission's keys, by which a guard knows what is stale.
        view: What is known of the run; a runner that is given this answerer sets its own.
    """

    def __init__(
        self,
        rules: Mapping[str, Sequence[tuple[Guard | None, str]]],
        *,
        keys: Mapping[str, Key] | None = None,
        view: View | None = None,
    ) -> None:
        self._view = view
        self._rows = {
            state: tuple(_compiled(state, index, row, keys or {}) for index, row in enumerate(rows))
            for state, rows in rules.items()
        }

    @classmethod
    def of(cls, robot: Robot, *, keys: Mapping[str, Key], view: View | None = None) -> Self:
        """The rules of a profile."""
        rules = {state: [(rule.when, rule.answer) for rule in rules] for state, rules in robot.rules.items()}
        return cls(rules, keys=keys, view=view)

    def read_from(self, view: View) -> None:
        """Decide by this run from now on."""
        self._view = view

    def ask(self, question: Question, answer: Callable[[Mapping[str, Any]], None]) -> None:
        """Answer before returning."""
        rows = self._rows.get(question.state)
        if not rows:
            answer({"absent": f"no rules for '{question.state}'"})
            return
        if self._view is None:
            answer({"absent": "the rules were given no run to read"})
            return
        try:
            row = _chosen(rows, question, self._view)
        except Exception as error:  # noqa: BLE001 - a predicate of the user's program may raise anything
            answer({"failed": f"a rule for '{question.state}' raised {cut(raised_text(error), 200)}"})
            return
        if row is None:
            answer({"absent": f"no rule for this in '{question.state}'"})
        else:
            answer({"option": row.option, "parameters": {}, "why": row.why})

    def withdraw(self, number: int) -> None:
        """Nothing is ever under way."""


def _compiled(state: str, index: int, row: tuple[Guard | None, str], keys: Mapping[str, Key]) -> AnswerRule:
    guard, option = row
    name = f"rule {index + 1} of '{state}'"
    if guard is None:
        return AnswerRule(None, option, f"{name}: always")
    return AnswerRule(guard.compiled(Site(f"/rules/{state}/{index}", keys, state)), option, f"{name}: {guard.words()}")


def _chosen(rows: Sequence[AnswerRule], question: Question, view: View) -> AnswerRule | None:
    offered = {offer.name for offer in question.options}
    return next((row for row in rows if row.option in offered and (row.test is None or row.test(view) is True)), None)
