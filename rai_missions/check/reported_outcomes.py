# SPDX-License-Identifier: Apache-2.0
"""Which outcomes a state can report, and which of them can reach the transitions of another."""

from __future__ import annotations

from collections.abc import Iterable

from rai_missions.check.index import MissionIndex, StateRef
from rai_missions.states import Compound, Each, Final, History, Include, Parallel

__all__ = ("ENDS", "OutcomeReports", "reported")

ENDS = frozenset({"succeeded", "failed", "aborted", "canceled", "unverified"})
"""What finals can report."""


class OutcomeReports:
    """Outcomes, by the index of the state."""

    def __init__(self, spots: list[StateRef], top: Iterable[StateRef]) -> None:
        self._ends: list[frozenset[str]] = [frozenset()] * len(spots)
        self._below: list[frozenset[str]] = [frozenset()] * len(spots)
        for spot in reversed(spots):
            ends = self._of(spot)
            if not ends and not spot.children:
                continue
            climbing = (ends & (ENDS | {"timed_out", "rejected", "unclear", "refused"})) - {"succeeded"}
            self._ends[spot.index] = ends
            self._below[spot.index] = climbing.union(*(self._below[child.index] for child in spot.children))
        self.anywhere = frozenset[str]().union(*(self._below[spot.index] for spot in top))
        """What can climb as far as the mission's own transitions."""

    def by(self, spot: StateRef) -> frozenset[str]:
        """What it can report about itself."""
        return self._ends[spot.index]

    def possible_at(self, spot: StateRef | None) -> frozenset[str]:
        """What transitions of it can receive: its own, and what climbs from inside."""
        return self.anywhere if spot is None else self._ends[spot.index] | self._below[spot.index]

    def _of(self, spot: StateRef) -> frozenset[str]:
        state = spot.state
        outcomes = state.outcomes()
        if isinstance(state, Include):
            outcomes |= ENDS
        elif isinstance(state, Each):
            outcomes |= self._finals(spot) | {"succeeded", "failed"}
        elif isinstance(state, Parallel):
            outcomes |= self._together(spot)
        elif isinstance(state, Compound):
            outcomes |= self._finals(spot)
        starts = state.activity() or not (spot.children or isinstance(state, History))
        if starts and spot.control is not None:
            outcomes |= {"rejected"}  # control did not come in time, also for one that only waits
        return frozenset(outcomes)

    def _finals(self, spot: StateRef) -> frozenset[str]:
        finals = [child.state for child in spot.children if isinstance(child.state, Final)]
        return frozenset([final.final for final in finals]) | (
            {"unverified"} if any(final.requires is not None for final in finals) else frozenset()
        )

    def _together(self, spot: StateRef) -> frozenset[str]:
        """The outcomes of regions that can all end; nothing while one of them never does."""
        regions = [child for child in spot.children if not isinstance(child.state, Final | History)]
        ends = [self._ends[region.index] & ENDS for region in regions]
        if not regions or not all(ends):
            return frozenset()
        worst = frozenset[str]().union(*ends) - {"succeeded"}
        return worst | ({"succeeded"} if all("succeeded" in each for each in ends) else frozenset())


def reported(index: MissionIndex) -> OutcomeReports:
    """Which outcomes the states of a mission can report; worked out once."""
    found = index.remembered.get("reported")
    if not isinstance(found, OutcomeReports):
        found = index.remembered["reported"] = OutcomeReports(index.spots, index.top)
    return found
