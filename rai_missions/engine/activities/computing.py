# SPDX-License-Identifier: Apache-2.0
"""The machine of what is worked out at once: from keys that are known, a value for a key of the mission.

Rule: it begins and ends in one step and remembers nothing. A fact that is missing or stale is not worked with.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.engine.activities.activity import ActivityHost, Machine, Outcome, Turn
from rai_missions.event import Event
from rai_missions.guards.view import Operand, Site

__all__ = ("ComputedResult", "ComputingMachine")


class ComputedResult(NamedTuple):
    """What was worked out."""

    outcome: str
    value: Mapping[str, Any]
    """What is written."""
    why: str = ""


class ComputingMachine(Machine):
    """Works one thing out.

    Args:
        owner: The state.
        site: Of what it reads.
        given: The paths of what it is worked out from.
        into: The key that it is written to.
        compute: A pure function of their values.
        follows: Whether it also takes what was written last, or None, as its last value.
    """

    def __init__(
        self,
        owner: str,
        site: Site,
        given: Sequence[str],
        into: str,
        compute: Callable[..., ComputedResult],
        *,
        follows: bool = False,
    ) -> None:
        self.owner, self.site, self.into, self.compute, self.follows = owner, site, into, compute, follows
        self.given = [(path, Operand(path, site)) for path in given]

    def computing(self, compute: Callable[..., ComputedResult]) -> ComputingMachine:
        """This machine with another function to compute by, as a proof needs it."""
        return ComputingMachine(self.owner, self.site, [path for path, _ in self.given], self.into, compute)

    def begin(self, host: ActivityHost) -> Turn:
        known = [(path, operand.read(host.view)) for path, operand in self.given]
        if unknown := [path for path, value in known if value is None]:
            return Turn(None, outcome=Outcome("rejected", why=f"unknown: {', '.join(unknown)}"))
        values = [value for _, value in known]
        if self.follows:
            last = host.view.board.get(self.into)
            values.append(None if last is None else last.value)
        outcome, value, why = self.compute(*values)
        return Turn(None, outcome=Outcome(outcome, why=why), writes=((self.into, dict(value)),))

    def receive(self, state: Any, event: Event, host: ActivityHost) -> Turn | None:
        return None

    def awaits(self, state: Any) -> frozenset[int]:
        return frozenset()
