# SPDX-License-Identifier: Apache-2.0
"""The machine of a behaviour written in Python: someone ticks it next to the mission, and its end comes as an event."""

from __future__ import annotations

from typing import NamedTuple

from rai_missions.engine.activities.activity import ActivityHost, Bench, Machine, Outcome, Turn, machine_of, remembered
from rai_missions.engine.step import StartBehaviour, StopBehaviour
from rai_missions.event import Event
from rai_missions.states.tree.behaviour import BehaviourLeaf

__all__ = ("BehaviourActivity", "BehaviourMachine")

ENDS = ("success", "failure")


@remembered("Behaving")
class BehaviourActivity(NamedTuple):
    """A live behaviour is ticked."""

    number: int


class BehaviourMachine(Machine):
    """Has one behaviour ticked until it has ended or is left."""

    def __init__(self, owner: str) -> None:
        self.owner = owner

    def begin(self, host: ActivityHost) -> Turn:
        number = host.next_number()
        return Turn(BehaviourActivity(number), (StartBehaviour(number, self.owner),))

    def receive(self, state: BehaviourActivity, event: Event, host: ActivityHost) -> Turn | None:
        if event.kind != "behaviour" or event.number != state.number:
            return None
        status = str(event.data.get("status", ""))
        if status not in ENDS:
            return None
        return Turn(None, outcome=Outcome(status, why=str(event.data.get("why", ""))))

    def leave(self, state: BehaviourActivity, host: ActivityHost) -> Turn:
        return Turn(None, (StopBehaviour(state.number),))

    def awaits(self, state: BehaviourActivity) -> frozenset[int]:
        return frozenset({state.number})


@machine_of.register(BehaviourLeaf)
def _(definition: BehaviourLeaf, bench: Bench) -> BehaviourMachine:
    return BehaviourMachine(bench.owner)
