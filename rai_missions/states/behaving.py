# SPDX-License-Identifier: Apache-2.0
"""The machine of a behaviour written in Python: somebody ticks it beside the mission, and its end comes as an event."""

from __future__ import annotations

import math
from typing import NamedTuple

from rai_missions.event import Event
from rai_missions.guards.guard import View
from rai_missions.states.activity import NO_KEYS, Desk, Outcome, Turn
from rai_missions.step import StartBehaviour, StopBehaviour

__all__ = ("Behaving", "BehavingMachine")

ENDS = ("success", "failure")


class Behaving(NamedTuple):
    """A live behaviour is ticked."""

    number: int


class BehavingMachine:
    """Has one behaviour ticked until it has ended or is left."""

    def __init__(self, owner: str) -> None:
        self.owner = owner

    def begin(self, desk: Desk) -> Turn:
        number = desk.next_number()
        return Turn(Behaving(number), (StartBehaviour(number, self.owner),))

    def hear(self, state: Behaving, event: Event, desk: Desk) -> Turn | None:
        if event.kind != "behaviour" or event.number != state.number:
            return None
        status = str(event.data.get("status", ""))
        if status not in ENDS:
            return None
        return Turn(None, outcome=Outcome(status, why=str(event.data.get("why", ""))))

    def leave(self, state: Behaving, desk: Desk) -> Turn:
        return Turn(None, (StopBehaviour(state.number),))

    def wake_at(self, state: Behaving, view: View) -> float:
        return math.inf

    def reads(self, state: Behaving) -> frozenset[str]:
        return NO_KEYS

    def awaits(self, state: Behaving) -> frozenset[int]:
        return frozenset({state.number})

    def shifted(self, state: Behaving, by_s: float) -> Behaving:
        return state
