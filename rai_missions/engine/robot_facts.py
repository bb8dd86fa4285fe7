# SPDX-License-Identifier: Apache-2.0
"""What the pure engine needs to know of the robot: which actions occupy what, and what their ends rest on.

Rule: how the robot is reached is not known here; that is the profile's, and the engine never sees it.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import NoneType
from typing import NamedTuple

from rai_missions.given import check_given
from rai_missions.guards.guard import Guard

__all__ = ("RobotFacts", "check_facts")


class RobotFacts(NamedTuple):
    """A robot profile as far as rules can depend on it. The empty one is that of a robot of which nothing is known."""

    uses: Mapping[str, frozenset[str] | None] = {}
    """Action → what it occupies; two that share one conflict. None, and an action that is not here: all there is."""
    keep: frozenset[str] = frozenset()
    """The actions whose goals continue while the mission is paused."""
    succeeded: Mapping[str, Guard] = {}
    """Composed action → the guard over the blackboard that is true once it has succeeded."""
    failed: Mapping[str, Guard] = {}
    """Composed action → the guard over the blackboard that is true once it has failed."""
    repeat: frozenset[str] = frozenset()
    """The actions and services that may be started again when no one knows whether they were."""

    def conflict(self, one: str, other: str) -> bool:
        """Whether two actions occupy something in common."""
        first, second = self.uses.get(one), self.uses.get(other)
        return first is None or second is None or not first.isdisjoint(second)


def check_facts(given: object) -> None:
    """Refuse as `robot_facts` what is of another kind, unless none are given; see `check_given`.

    Raises:
        UsageError: It is.
    """
    check_given(
        given, (RobotFacts, NoneType), "robot_facts", "what rai_missions.profile.robot_facts makes of a profile"
    )
