# SPDX-License-Identifier: Apache-2.0
"""The machine of a call: one request, one reply."""

from __future__ import annotations

from typing import NamedTuple

from rai_missions.engine.activities.activity import (
    ActivityHost,
    Bench,
    Machine,
    Outcome,
    Turn,
    machine_of,
    remembered,
    result_writes,
)
from rai_missions.engine.step import CallService
from rai_missions.engine.templates import SentTemplate
from rai_missions.event import Event
from rai_missions.guards.view import Site
from rai_missions.states.call import CallFields

__all__ = ("REPLIES", "CallActivity", "CallMachine")

REPLIES = ("succeeded", "failed", "timed_out", "unavailable")
"""How a call ends."""
OUTCOMES = {
    "succeeded": "succeeded",
    "failed": "failed",
    "timed_out": "timed_out",
    "unavailable": "rejected",
    "rejected": "rejected",
}


@remembered("Calling")
class CallActivity(NamedTuple):
    """A reply is awaited."""

    number: int


class CallMachine(Machine):
    """Calls one service."""

    def __init__(self, definition: CallFields, owner: str, site: Site) -> None:
        self.definition, self.owner = definition, owner
        self.request = SentTemplate("request", definition.request, site)

    def begin(self, host: ActivityHost) -> Turn:
        number = host.next_number()
        request, lack = self.request.fill(host.view)
        if lack:
            return Turn(None, outcome=Outcome("rejected", why=lack))
        call = CallService(number, self.owner, self.definition.call, request, self.definition.timeout_s)
        return Turn(CallActivity(number), (call,))

    def receive(self, state: CallActivity, event: Event, host: ActivityHost) -> Turn | None:
        if event.kind != "result" or event.number != state.number:
            return None
        outcome = OUTCOMES.get(event.name, "failed")
        data = dict(event.data)
        writes = result_writes(self.definition.result, data) if outcome == "succeeded" else ()
        return Turn(None, outcome=Outcome(outcome, data, str(data.get("why", ""))), writes=writes)

    def awaits(self, state: CallActivity) -> frozenset[int]:
        return frozenset({state.number})


@machine_of.register(CallFields)
def _(definition: CallFields, bench: Bench) -> CallMachine:
    return CallMachine(definition, bench.owner, bench.site())
