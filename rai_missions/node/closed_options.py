# SPDX-License-Identifier: Apache-2.0
"""Which options of an open question would be refused if they were taken now, for clients that show them to a person.

Rule: it is for show. What counts is what `judge` decides once an answer has come. Only the engine asks what is written
in Python, so an option whose guard names a predicate stays open here.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.engine.decision import Question
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Site, Test, Truth, View
from rai_missions.keys import Blackboard
from rai_missions.mission.mission import Mission

__all__ = ("ClosedOptions",)

WORDS = {False: "this does not hold", None: "this is unknown"}


class FrozenView(NamedTuple):
    """A `View` of one moment, taken from a chart that continues meanwhile."""

    at: float
    board: Blackboard
    active: frozenset[str]
    entered: Mapping[str, float]
    true_since: Mapping[str, float]
    event: Mapping[str, Any] = {}
    answer: Mapping[str, Any] = {}

    def named(self, name: str, arguments: Mapping[str, Any]) -> Truth:
        """Not asked: see the rule of this file."""
        return None

    def note(self, text: str) -> None:
        """Not noted: the step in which the guard counts does so."""


class ClosedOptions:
    """The guards of a mission's options.

    Args:
        mission: Compiled once a decision, when its question is first looked at.
    """

    def __init__(self, mission: Mission) -> None:
        self._mission = mission
        self._tests: dict[str, dict[str, tuple[Test, Guard]]] = {}

    def now(
        self, questions: Iterable[Question], view: View, at: float, still_since: Callable[[str], float | None]
    ) -> dict[int, dict[str, str]]:
        """Question → option → why it would be refused; from any thread.

        Args:
            questions: Those that are open.
            view: The run, to be read.
            at: Now, on the run's clock.
            still_since: As `Chart.still_since`: a state in a pause or a hold has the age that it had then.
        """
        run = FrozenView(at, dict(view.board), view.active, dict(view.entered), dict(view.true_since))
        found: dict[int, dict[str, str]] = {}
        for question in questions:
            still = still_since(question.state)
            stopped_s = 0.0 if still is None else at - still
            seen = run._replace(entered={name: since + stopped_s for name, since in run.entered.items()})
            tests = self._tests_of(question.owner)
            each = {offer.name: tests[offer.name] for offer in question.options if offer.name in tests}
            values = {name: (test(seen), guard) for name, (test, guard) in each.items()}
            why = {
                name: f"{WORDS[value]}: {guard.words()}" for name, (value, guard) in values.items() if value is not True
            }
            if why:
                found[question.number] = why
        return found

    def _tests_of(self, owner: str) -> dict[str, tuple[Test, Guard]]:
        if owner not in self._tests:
            state, mark, path = owner.partition("#")
            found: dict[str, tuple[Test, Guard]] = {}
            for name, guard in self._mission.state(state).decisions()[mark + path].guards():
                site = Site(owner, self._mission.blackboard, state)
                test = guard.compiled(site)
                if not site.named:
                    found[name] = test, guard
            self._tests[owner] = found  # whole: another thread may look meanwhile
        return self._tests[owner]
