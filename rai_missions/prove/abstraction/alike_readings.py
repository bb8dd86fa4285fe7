# SPDX-License-Identifier: Apache-2.0
"""Readings of a run at rest, of which only that is kept which the rules that wait can find out of them.

Rule: two values of a reading are one where every part of every guard that waits makes the same of both, as the
mission's own keys and its arguments are, and as far as it counts at its place; unknown is a value as any other.

Why that loses nothing, and adds nothing. A robot reports at any time, and where a key can be unknown it can fall
silent at any time. Where what waits finds out the same of two values, the report of the other one fires nothing, and
leaves a run that differs in the reading alone. So each run that has the one can have the other one step later, and
whatever a run could do from either, it can do from the state that represents both: a look finds any value of these,
and no other. Where unknown is among them the robot may have been silent (`TimeEnvironment.is_silent`), as where no
one looks at a reading. The parts of a guard that read one reading are judged each by itself, so the readings of a
state are found independently of each other; a part that reads two of them, time or states keeps the value of each.
What a tree or a goal reads in its own way keeps its value, too.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.compiled.states import CompiledGuard
from rai_missions.engine.state import RunState
from rai_missions.guards.view import Site, Test, Truth, as_counted
from rai_missions.keys import Stamped
from rai_missions.prove.abstraction.open_world import NOW, OpenWorld
from rai_missions.prove.analysis.questions import parts_about
from rai_missions.prove.analysis.representatives import SCALARS

__all__ = ("AlikeReadings",)

Answers = Callable[[Any], tuple[Truth, ...]]
"""What all that waits finds out of a value."""


class WaitingQuestion(NamedTuple):
    """What a guard asks of a reading."""

    tests: tuple[tuple[Test, Truth], ...]
    """What it asks, and which of the values of that counts."""
    others: frozenset[str]
    """The mission's own keys and the arguments that it compares the reading with."""
    found: dict[Any, tuple[Truth, ...]]
    """Value → what it finds out, where there are no others."""


class AlikeReadings:
    """Finds the values of a reading that are alike to what waits.

    Args:
        chart: The mission.
        world: What the surroundings can be.
    """

    def __init__(self, chart: Chart, world: OpenWorld) -> None:
        self._keys, self._world = chart.mission.blackboard, world
        can_be = not (world.is_open or world.doubts)
        self._readings = frozenset(key for key in world.fleeting if can_be and self._keys[key].type in SCALARS)
        self._steady = frozenset(self._keys) - world.fleeting
        self._asked: dict[tuple[str, str], WaitingQuestion | None] = {}

    def narrow(
        self, state: RunState, waiting: Sequence[CompiledGuard], read: frozenset[str]
    ) -> dict[str, Sequence[Any]]:
        """Have each reading be the first of those that are alike.

        Args:
            state: The run, at rest.
            waiting: The guards that may do something without an event.
            read: What trees and goals read in their own way.

        Returns:
            Reading → all of these.
        """
        board, found = self._world.board, dict[str, Sequence[Any]]()
        for key, entry in list(board.entries()):
            if key not in self._readings:
                continue
            values: Sequence[Any] = board.among.get(key) or (None if entry is None else entry.value,)
            answers = self._answers(state, key, waiting) if read.isdisjoint((key, "*")) else None
            if answers is not None:
                given = {answers(each): each for each in reversed(values)}
                answer = self._world.choices.pick([*reversed(given)])
                values = [each for each in self._world.distinct(key) if answers(each) == answer]
                found[key] = values = values or [given[answer]]
            else:
                values = [self._world.choices.pick(values)]
            board.put(key, _entry(values[0]))
        board.looked.difference_update(self._world.fleeting)
        return found

    def _answers(self, state: RunState, key: str, waiting: Iterable[CompiledGuard]) -> Answers | None:
        """What these guards find out of a value of a key; None where that is not a matter of its value alone."""
        board, questions = self._world.board, []
        for each in waiting:
            if key not in each.reads:
                continue
            question = self._question(each, key)
            if question is None or not all(
                name in self._world.own_keys or board.is_known(name) for name in question.others
            ):
                return None
            questions.append(question)

        def find(question: WaitingQuestion, value: Any) -> tuple[Truth, ...]:
            if value not in question.found or question.others:
                board.put(key, _entry(value))
                question.found[value] = tuple([as_counted(test(state), counts) for test, counts in question.tests])
            return question.found[value]

        return lambda value: tuple([truth for question in questions for truth in find(question, value)])

    def _question(self, guard: CompiledGuard, key: str) -> WaitingQuestion | None:
        place = guard.place, key
        if place not in self._asked:
            parts = parts_about(guard.guard, key, guard.counts, self._steady)
            walked = (each for part, _ in parts or () for each in part.walk())
            others = {path.partition(".")[0] for each in walked for path in each.paths()}
            tests = tuple((part.compile(Site("", self._keys)), counts) for part, counts in parts or ())
            found = WaitingQuestion(tests, frozenset(others - {key}), {})
            self._asked[place] = found if parts is not None else None
        return self._asked[place]


def _entry(value: Any) -> Stamped | None:
    return None if value is None else Stamped(value, NOW)
