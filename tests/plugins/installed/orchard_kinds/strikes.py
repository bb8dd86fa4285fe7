# SPDX-License-Identifier: Apache-2.0
"""A service that is called several times: `{"strikes": 3, "service": "bell", "every_s": 2}`."""

from __future__ import annotations

import math
from typing import Annotated, Any, ClassVar, NamedTuple

from pydantic import Field

from rai_missions.engine.activities.activity import NO_KEYS, ActivityHost, Bench, Outcome, Turn, remembered
from rai_missions.engine.step import CallService
from rai_missions.event import Event
from rai_missions.guards.view import View
from rai_missions.model import Integer, Seconds, ServiceName
from rai_missions.states.state import State

__all__ = ("Strikes",)


class Strikes(State, word="strikes"):
    """Calls a service so often; the first call that fails ends it."""

    positional: ClassVar = ("strikes", "service")

    strikes: Annotated[Integer, Field(ge=1)]
    service: ServiceName
    every_s: Seconds = 1.0

    def outcomes(self) -> frozenset[str]:
        return super().outcomes() | {"succeeded", "failed"}

    def activity(self) -> str:
        return f"{self.strikes} strikes of {self.service}"

    def machine(self, bench: Bench) -> StrikesMachine:
        return StrikesMachine(self, bench.owner)


@remembered("orchard_kinds/Strikes")
class Struck(NamedTuple):
    """How far it has come."""

    done: int
    number: int
    """Of the call that is under way; 0 during a pause."""
    due: float = math.inf
    """When the pause is over."""


class StrikesMachine:
    """Calls, waits, and calls again."""

    def __init__(self, definition: Strikes, owner: str) -> None:
        self.definition, self.owner = definition, owner

    def begin(self, host: ActivityHost) -> Turn:
        return self._call(0, host)

    def _call(self, done: int, host: ActivityHost) -> Turn:
        number = host.next_number()
        call = CallService(number, self.owner, self.definition.service, {}, None)
        return Turn(Struck(done, number), (call,))

    def receive(self, state: Struck, event: Event, host: ActivityHost) -> Turn | None:
        if event.kind == "tick":
            return self._call(state.done, host) if host.view.at >= state.due else None
        if event.kind != "result" or event.number != state.number or not state.number:
            return None
        if event.name != "succeeded":
            return Turn(None, outcome=Outcome("failed", why=f"strike {state.done + 1} failed"))
        if state.done + 1 == self.definition.strikes:
            return Turn(None, outcome=Outcome("succeeded"))
        return Turn(Struck(state.done + 1, 0, host.view.at + self.definition.every_s))

    def leave(self, state: Struck, host: ActivityHost) -> Turn:
        return Turn(None)

    def wake_at(self, state: Struck, view: View) -> float:
        return state.due

    def reads(self, state: Struck) -> frozenset[str]:
        return NO_KEYS

    def awaits(self, state: Struck) -> frozenset[int]:
        return frozenset({state.number} if state.number else ())

    def shift(self, state: Struck, by_s: float) -> Any:
        return state._replace(due=state.due + by_s)
