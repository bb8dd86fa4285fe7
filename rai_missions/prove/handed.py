# SPDX-License-Identifier: Apache-2.0
"""Who has control: known while something runs that needs it, and anybody else's affair while nothing does.

Rule: the operator may take and give control at any time, so whoever looks may find anybody to have it.
"""

from __future__ import annotations

from rai_missions.mission import Mission
from rai_missions.prove.watched import Watched
from rai_missions.states.terms import Terms
from rai_missions.states.ticker import Trees

__all__ = ("Handed",)


class Handed(Watched):
    """A chart that finds out who has control when it looks."""

    def __init__(self, mission: Mission, ticker: Trees | None = None, *, terms: Terms | None = None) -> None:
        self._holder: str | None = None
        self.is_calm = False
        """The operator leaves the mission alone: nobody pauses it, and control goes where the mission asks it to go."""
        super().__init__(mission, ticker, terms=terms)
        self._needed = frozenset(node.control for node in self._graph.order if node.control is not None)
        self.anybody_else = "operator" if "operator" not in self._needed else "nobody"
        """Stands for all who have control where no state wants them to."""
        self.is_going_on = False
        """The mission is resumed: what waits for control may find that it was given meanwhile."""

        self.found = ""
        """Whom the last look has found."""

    @property
    def holder(self) -> str:
        """Who has control."""
        if self._holder is None:
            who: str = self.choices.pick(self._possible())
            self._holder = self.found = who
        return self._holder

    @holder.setter
    def holder(self, who: str) -> None:
        self._holder = who

    def _possible(self) -> list[str]:
        """Those whom it makes a difference to find."""
        here = {node.control for node in self._config.nodes if node.control is not None}
        if not self.is_going_on:
            here -= self.waited_for  # it would have begun
        return [*sorted(here), self.anybody_else]

    @property
    def waited_for(self) -> set[str]:
        """Whose control something waits for."""
        found = {self._graph.nodes[name].control for name in self._pending}
        return {who for who in found if who is not None}

    @property
    def is_in_hand(self) -> bool:
        """Something runs that needs control."""
        nodes = self._graph.nodes
        return any(nodes[name].control is not None for name in self._running)

    def let_go(self) -> None:
        """Forget who has control, unless something runs by it."""
        if self._needed and not self.is_calm and not self.is_in_hand:
            self._holder = None
