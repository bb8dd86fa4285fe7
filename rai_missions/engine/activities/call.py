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

__all__ = ("REPLIES", "CallActivity", "CallMachine", "replies_to")

REPLIES = ("succeeded", "failed", "timed_out", "unavailable")
"""How a call ends; `timed_out` only where it has a time (`timeout_s`)."""
UNTIMED = tuple(reply for reply in REPLIES if reply != "timed_out")
"""How a call without a time ends."""
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
        self.known = OUTCOMES.keys() - ({"timed_out"} if definition.timeout_s is None else set())
        """The replies that have an outcome of their own; any other is a failure."""

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
        outcome = OUTCOMES[event.name] if event.name in self.known else "failed"
        data = dict(event.data)
        writes = result_writes(self.definition.result, data) if outcome == "succeeded" else ()
        return Turn(None, outcome=Outcome(outcome, data, str(data.get("why", ""))), writes=writes)

    def awaits(self, state: CallActivity) -> frozenset[int]:
        return frozenset({state.number})


def replies_to(machine: Machine | None) -> tuple[str, ...]:
    """How a call can end that a machine waits for, or an effect has made (None)."""
    if isinstance(machine, CallMachine):
        return REPLIES if "timed_out" in machine.known else UNTIMED
    return UNTIMED if machine is None else REPLIES


@machine_of.register(CallFields)
def _(definition: CallFields, bench: Bench) -> CallMachine:
    return CallMachine(definition, bench.owner, bench.site())
