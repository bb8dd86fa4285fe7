# SPDX-License-Identifier: Apache-2.0
"""Who has control: known while something runs that needs it or is held, and left open while nothing does.

Rule: the operator may take control and give it back at any time, so a look finds any holder that it can find.
"""

from __future__ import annotations

import math

from rai_missions.engine import Chart
from rai_missions.engine.compiled.states import CompiledState
from rai_missions.engine.semantics.hold import held_controls
from rai_missions.engine.state import RunState
from rai_missions.event import Event
from rai_missions.mission.mission import BUILT_IN_EVENTS
from rai_missions.prove.abstraction.nondeterminism import Choices
from rai_missions.prove.abstraction.open_world import NOW
from rai_missions.states.control import Holder

__all__ = ("ControlEnvironment", "control_event", "kept_words")

OTHERS = ("autonomy", "agent", "operator")
"""Holders; the first whose control no active state needs represents every holder who holds nothing up."""


class ControlEnvironment:
    """Finds out who has control when a rule looks.

    Args:
        chart: The mission.
        choices: Where what is left open is chosen.
        is_calm: The operator leaves the mission alone: control goes where the mission asks it to go.
    """

    def __init__(self, chart: Chart, choices: Choices, *, is_calm: bool = False) -> None:
        self._chart, self._choices, self.is_calm = chart, choices, is_calm
        self.needed = chart.program.graph.controls
        """Whose control states of the mission need."""
        self.holds: tuple[Holder, ...] = ("nobody", *(("operator",) if "operator" in self.needed else ()))
        """With whom control can be while the mission is held; without states of the operator it makes no difference."""
        self.is_resuming = False
        """The mission is resumed: what waits for control may find that it was given meanwhile."""
        self.found: Event | None = None
        """What has happened to control before the last look, as it was found then."""
        transitions = chart.program.graph.transitions.values()
        self._named_events = frozenset(name for transition in transitions for name in transition.definition.on)
        """The events, and outcomes, that transitions name."""
        self._may_be_held = False
        """It is not known yet whether the operator has taken control."""

    # -- who has it -----------------------------------------------------------------------------------------------

    def find(self, state: RunState) -> Holder:
        """A rule looks who has control."""
        who: Holder = self._choices.pick(self._possible())
        state.holder, self.found = who, control_event(who, "mission")
        return who

    @property
    def is_held(self) -> bool:
        """Some active state waits for the operator to give control back."""
        return bool(self._chart.state.frozen)

    @property
    def here(self) -> frozenset[str]:
        """Whose control active states need."""
        return self._chart.state.config.controls

    @property
    def others(self) -> list[str]:
        """The holders that can have control without a hold: all who are needed here, and one for all others."""
        here = self.here
        return [*sorted(here), *[who for who in OTHERS if who not in here][:1]]

    def _possible(self) -> list[str]:
        """The holders that it makes a difference to find."""
        others = self.others
        waited = set() if self.is_resuming else self.waited_for  # it would have begun
        return [who for who in others if who not in waited] or others

    @property
    def waited_for(self) -> set[str]:
        """Whose control something waits for."""
        nodes = self._chart.program.graph.nodes
        found = {nodes[name].control for name in self._chart.state.awaiting_control}
        return {who for who in found if who is not None}

    @property
    def is_in_hand(self) -> bool:
        """Something runs that needs control."""
        nodes = self._chart.program.graph.nodes
        return any(nodes[name].control is not None for name in self._chart.state.running)

    def let_go(self) -> None:
        """Forget who has control, unless something here runs by it, or is held."""
        state = self._chart.state
        if not self.needed or self.is_calm:
            return
        if state.mode == "paused" or not (state.frozen and self.here):
            state.frozen, state.taken = {}, False
            if state.mode == "paused" or not self.is_in_hand:
                state.holder = None

    # -- taken, and given back ------------------------------------------------------------------------------------

    def leave_open(self) -> None:
        """A step begins: where nothing that is active needs control, the operator may have taken it."""
        is_open = self._chart.state.holder is None and not self.here
        self._may_be_held = bool(self.needed) and not self.is_calm and is_open

    def enter(self, state: RunState, node: CompiledState) -> None:
        """The first state that needs control is entered: now it makes a difference whether the operator took it."""
        if node.control is not None and self._may_be_held and state.holder is None:
            self._may_be_held = False
            held = self._choices.choose(1 + len(self.holds))
            if held:
                self.take(self.holds[held - 1])
                state.frozen = dict.fromkeys(held_controls(self._chart.program, state), NOW)

    def take(self, who: Holder) -> None:
        """The operator has taken control, or it is with no one."""
        state = self._chart.state
        state.holder, state.taken, self.found = who, who == "operator", control_event(who, "operator")

    # -- what waits -----------------------------------------------------------------------------------------------

    def lay_by(self) -> None:
        """The mission is paused: while it is, it makes no difference who has control, or why something waits."""
        state, nodes = self._chart.state, self._chart.program.graph.nodes
        asked = {
            name for name, until in state.awaiting_control.items() if until < math.inf and name not in state.running
        }
        state.awaiting_control = {name: until for name, until in state.awaiting_control.items() if name not in asked}
        names = {*state.paused_starts, *state.held_starts, *asked}  # each begins at the end, or asks for control then
        state.paused_starts = tuple(sorted(names, key=lambda name: nodes[name].index))
        state.held_starts = ()
        state.paused_events, state.held_events = state.held_events, ()

    def waits(self, state: RunState, event: Event, waiting: tuple[Event, ...]) -> bool:
        """What comes from outside can come just as well right after the hand-back; all else is kept, once.

        The same for the end of a pause, where some transition names it.
        """
        is_own = event.kind == "outcome" or event.name in BUILT_IN_EVENTS
        if not is_own or any(kept_words(event) == kept_words(each) for each in waiting):
            return False
        return state.mode != "paused" or event.name in self._named_events


def kept_words(event: Event) -> tuple[str, str]:
    """All that makes a difference of an event that is kept."""
    data = event.data
    return event.name, str(data.get("state", data.get("action", data.get("call", ""))))


def control_event(who: str, by: str) -> Event:
    """Control is with someone from now on."""
    data = {"by": by, "role": "operator"} if by == "operator" else {"by": by}
    return Event(who, NOW, data, "control")
