# SPDX-License-Identifier: Apache-2.0
"""A mission in the hands of one person: what can happen now, what was chosen so far, and the way back.

Rule: only what leads to the present is kept; going back forgets what came after.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.step import StartGoal, Step
from rai_missions.errors import UsageError, suggestion
from rai_missions.guards.view import Truth
from rai_missions.mission.mission import Mission
from rai_missions.replay.play.choice import Input, PlayChoice, perform
from rai_missions.replay.play.offers import OpenChoices

__all__ = ("Click", "Play", "PlayStep")


class PlayStep(NamedTuple):
    """A step of a play, with what its row in a journal needs."""

    step: Step
    since: float
    """The engine's clock right before, seconds."""
    is_quiet: bool
    """It did nothing but write the blackboard."""


class Click(NamedTuple):
    """One thing that was chosen, and what came of it."""

    name: str
    words: str
    values: Mapping[str, Any]
    inputs: tuple[Input, ...]
    done: tuple[PlayStep, ...]
    active: frozenset[str]
    """The active states afterwards."""
    before: Chart
    """The run right before; never changed."""

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps that it made, in order."""
        return tuple(each.step for each in self.done)


class Play:
    """A mission that is played.

    Args:
        mission: One that `check` finds no error in.
        named: The predicates that `{"named": …}` guards name.

    Raises:
        UsageError: The mission names a predicate that was not given.
    """

    def __init__(self, mission: Mission, *, named: Mapping[str, Callable[..., Truth]] | None = None) -> None:
        self.mission = mission
        self.chart = Chart(mission, named=named)
        self.path: list[Click] = []
        """What was chosen, the oldest first."""
        self._offers = OpenChoices(mission)
        self._choices: list[PlayChoice] | None = None

    def choices(self) -> list[PlayChoice]:
        """Everything that can happen now."""
        if self._choices is None:
            self._choices = self._offers.now(self.chart, self._started())
        return self._choices

    def do(self, name: str, values: Mapping[str, Any] | None = None) -> Click:
        """Let something happen.

        Args:
            name: A choice's.
            values: Those of its fields, by name; what is not given is as suggested.

        Raises:
            UsageError: It cannot happen now, or a value does not fit; nothing has changed then.
        """
        choices = {choice.name: choice for choice in self.choices()}
        if name not in choices:
            raise UsageError(f"'{name}' cannot happen now{suggestion(name, choices)}")
        choice, given = choices[name], dict(values or {})
        chart = self.chart.branch()
        inputs, done = tuple(choice.inputs(chart, given)), list[PlayStep]()
        for each in inputs:
            steps, since = perform(chart, each), chart.at
            for step in steps:
                done.append(
                    PlayStep(step, since, chart.quiet and not step.refusal and step.event.kind in ("write", "tick"))
                )
                since = chart.at
        click = Click(choice.name, choice.words, given, inputs, tuple(done), chart.active, self.chart)
        self.chart, self._choices = chart, None
        self.path.append(click)
        return click

    def undo(self, count: int = 1) -> None:
        """Go back to where the run was before the last things that were chosen.

        Args:
            count: How many; more than there are leads to the beginning.

        Raises:
            UsageError: There is nothing to go back to.
        """
        if not self.path or count < 1:
            raise UsageError("this is the beginning; there is nothing to undo")
        first = max(0, len(self.path) - count)
        self.chart, self._choices = self.path[first].before, None
        del self.path[first:]

    @property
    def steps(self) -> tuple[Step, ...]:
        """The steps of the present path, in order."""
        return tuple(step for click in self.path for step in click.steps)

    def _started(self) -> dict[int, StartGoal]:
        return {
            effect.number: effect for step in self.steps for effect in step.effects if isinstance(effect, StartGoal)
        }
