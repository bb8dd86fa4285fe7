# SPDX-License-Identifier: Apache-2.0
"""What the rules of a mission leave open, and where a run may be watched: the only hooks of the engine.

Rule: a run of its own has nothing left open and no one who watches. `prove` gives a program surroundings that can be
anything.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from rai_missions.engine.activities.activity import Machine
from rai_missions.engine.compiled.states import CompiledState
from rai_missions.event import Event
from rai_missions.guards.view import Site, Truth
from rai_missions.keys import Key
from rai_missions.states.control import Holder

if TYPE_CHECKING:
    from rai_missions.engine.compiled.configuration import CompiledMove
    from rai_missions.engine.state import RunState

__all__ = ("Surroundings",)


class Surroundings:
    """Nothing is left open."""

    def predicate(self, state: RunState, name: str, arguments: Mapping[str, Any]) -> Truth:
        """The value of a predicate of the user's program that was not given."""
        return None

    def holder(self, state: RunState) -> Holder:
        """Who has control, where that was left open until a rule looks."""
        raise LookupError("who has control is open only in a proof")

    def site(self, place: str, keys: Mapping[str, Key], state: str) -> Site:
        """Where a guard is compiled: of a transition, a final, an invariant, or of an activity."""
        return Site(place, keys, state)

    def machine(self, node: CompiledState, machine: Machine) -> Machine:
        """The machine of a state's activity, as it is to be used."""
        return machine

    def before_move(self, state: RunState, move: CompiledMove) -> bool:
        """A microstep is about to be made; False where the macrostep goes round for ever and is to be ended."""
        return True

    def before_entry(self, state: RunState, node: CompiledState) -> None:
        """A state is about to be entered."""

    def before_round(self, state: RunState, node: CompiledState) -> None:
        """The next round of an `each` is about to begin, or its end to be reported."""

    def waits(self, state: RunState, event: Event, waiting: tuple[Event, ...]) -> bool:
        """Whether an event is kept until the end of a pause, or the hand-back, after those that wait already."""
        return True
