# SPDX-License-Identifier: Apache-2.0
"""What the steps of an exploration show: what the mission does, and which of its promises it breaks."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from rai_missions.prove.abstraction.state_key import Place
from rai_missions.prove.environment.environment import Environment
from rai_missions.prove.state_graph import Edge
from rai_missions.prove.stimulus import KILL

__all__ = ("Findings", "Violation")


class Violation(NamedTuple):
    """A state, or a step out of it, that breaks a promise."""

    promise: str
    state: int
    """Its number; -1 is before the start."""
    sentence: str
    way: Edge | None = None
    """What happens in that state; None where the state itself is at fault."""


class Findings:
    """What is found out step by step; what only all states together show, `claims` has.

    Args:
        environment: The mission, in the state to which the last step led.
        on_refuted: Called when a promise turns out to be broken.
    """

    def __init__(self, environment: Environment, on_refuted: Callable[[], None]) -> None:
        self._environment, self._on_refuted = environment, on_refuted
        self.taken: set[str] = set()
        """JSON pointers of the transitions that were taken."""
        self.entered: set[str] = set()
        """The states that were entered."""
        self.flaws: dict[str, Violation] = {}
        """Promise → a shortest way to break it."""
        self.in_pause: set[str] = set()
        """Invariants that a robot's reports can break while the mission is paused or held, when not every rule acts."""

    def stop(self, number: int, place: Place) -> None:
        """An e-stop here ends the mission and every goal; it asks for nothing that is known."""
        environment, chart = self._environment, self._environment.chart
        environment.load(place)
        environment.choices.begin()
        environment.make(environment.ordering("kill"))
        if chart.outcome != "aborted":
            self._flaw("stop", number, f"an e-stop leaves the mission {chart.outcome or chart.mode}", Edge(KILL))
        self._end(number, Edge(KILL))

    def learn(self, source: int, way: Edge, *, is_paused: bool) -> None:
        """Take note of what the step that was just made shows.

        Args:
            source: The state in which it was made.
            way: What happened there.
            is_paused: The mission was paused or held, so that not every rule acted.
        """
        environment, chart = self._environment, self._environment.chart
        draft, seen = chart.state.draft, environment.instruments.seen
        for move in draft.moves:
            self.taken.update(move.taken)
            self.entered.update(move.entered)
        for place, value in draft.looked:
            seen.setdefault(place, set()).add(value)
        if chart.outcome is None:
            if restless := environment.rest.restless:
                sentence = f"the tree in '{restless[0]}' goes round without end: it rests at the limit of a step"
                self._flaw("comes to rest", source, sentence, way)
            return
        self._end(source, way)
        if chart.cause == "invariant" and is_paused:
            self.in_pause.add(chart.false_invariant)
        elif chart.cause == "invariant":
            self._flaw("invariants", source, chart.why, way)
        elif chart.cause == "cycle":
            self._flaw("comes to rest", source, chart.why, way)
        if chart.outcome == "succeeded" and not environment.world.rests_on_facts:
            self._flaw("answers", source, "the mission succeeds, whatever the robot reports", way)

    def _end(self, source: int, way: Edge) -> None:
        loose = [goal.action for goal in self._environment.rest.pursued]
        if loose:
            self._flaw("stopped", source, f"the mission ends while '{loose[0]}' continues", way)

    def _flaw(self, promise: str, state: int, sentence: str, way: Edge) -> None:
        """The first of each promise is a shortest."""
        if promise not in self.flaws:
            self._on_refuted()
            self.flaws[promise] = Violation(promise, state, sentence, way)
