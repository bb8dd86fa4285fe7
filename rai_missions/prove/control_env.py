# SPDX-License-Identifier: Apache-2.0
"""Who has control: known while something runs that needs it or is held, and left open while nothing does.

Rule: the operator may take control and give it back at any time, so a look finds any holder that it can find.
"""

from __future__ import annotations

from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.hold import OUTCOME
from rai_missions.engine.nodes import Node
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.event import Event
from rai_missions.mission.mission import BUILT_IN_EVENTS, Mission
from rai_missions.prove.instrumented_chart import NOW, InstrumentedChart

__all__ = ("ControlEnvironment",)

OTHERS = ("autonomy", "agent", "operator")
"""Of these the first whose control no active state needs stands for every holder who holds nothing up."""


class ControlEnvironment(InstrumentedChart):
    """A chart that finds out who has control when it looks."""

    def __init__(self, mission: Mission, ticker: Trees | None = None, *, terms: RobotFacts | None = None) -> None:
        self._holder: str | None = None
        self.is_calm = False
        """The operator leaves the mission alone: nobody pauses it, and control goes where the mission asks it to go."""
        super().__init__(mission, ticker, terms=terms)
        self._needed = self._graph.controls
        self.holds = ("nobody", *(("operator",) if "operator" in self._needed else ()))
        """With whom control can be while the mission is held; without states of the operator it makes no difference."""
        self.is_going_on = False
        """The mission is resumed: what waits for control may find that it was given meanwhile."""
        self.found: Event | None = None
        """What has happened to control before the last look, as it was found then."""
        self._named_events = frozenset(name for row in self._graph.rows.values() for name in row.transition.on)
        """The events, and outcomes, that transitions name."""
        self._may_be_held = False
        """Nothing here tells yet whether the operator has taken control."""

    # -- who has it -----------------------------------------------------------------------------------------------

    @property
    def holder(self) -> str:
        """Who has control."""
        if self._holder is None:
            who: str = self.choices.pick(self._possible())
            self._holder, self.found = who, _handed(who, "mission")
        return self._holder

    @holder.setter
    def holder(self, who: str) -> None:
        self._holder = who

    @property
    def held_by(self) -> str:
        """As `Chart.held_by` has it; without a look where it makes no difference."""
        is_held = self._holder == "nobody" or (self._holder == "operator" and self.taken)
        return str(self._holder) if is_held and self.mode not in ("ready", "ended") else ""

    @property
    def is_held(self) -> bool:
        """Some active state waits for the operator to give control back."""
        return bool(self._frozen)

    @property
    def here(self) -> set[str]:
        """Whose control active states need."""
        return {node.control for node in self._config.nodes if node.control is not None}

    @property
    def others(self) -> list[str]:
        """Those who can have control without a hold: whoever is needed here, and one for all who are not."""
        here = self.here
        return [*sorted(here), *[who for who in OTHERS if who not in here][:1]]

    def _possible(self) -> list[str]:
        """Those whom it makes a difference to find."""
        others = self.others
        waited = set() if self.is_going_on else self.waited_for  # it would have begun
        return [who for who in others if who not in waited] or others

    @property
    def waited_for(self) -> set[str]:
        """Whose control something waits for."""
        found = {self._graph.nodes[name].control for name in self._pending}
        return {who for who in found if who is not None}

    @property
    def is_in_hand(self) -> bool:
        """Something runs that needs control."""
        nodes = self._graph.nodes
        return any(nodes[name].control is not None for name in self._running)

    def let_go(self) -> None:
        """Forget who has control, unless something here runs by it, or is held."""
        if not self._needed or self.is_calm:
            return
        if self.mode == "paused" or not (self._frozen and self.here):
            self._frozen, self.taken = {}, False
            if self.mode == "paused" or not self.is_in_hand:
                self._holder = None

    # -- taken, and given back ------------------------------------------------------------------------------------

    def leave_open(self) -> None:
        """A step begins: where nothing that is active needs control, the operator may have taken it."""
        self._may_be_held = bool(self._needed) and not self.is_calm and self._holder is None and not self.here

    def _enter(self, node: Node) -> None:
        if node.control is not None and self._may_be_held and self._holder is None:
            self._may_be_held = False
            held = self.choices.choose(1 + len(self.holds))
            if held:
                self.take(self.holds[held - 1])
                self._frozen = dict.fromkeys(self._held_controls(), NOW)
        super()._enter(node)

    def take(self, who: str) -> None:
        """The operator has taken control, or it is with nobody."""
        self._holder, self.taken, self.found = who, who == "operator", _handed(who, "operator")

    def _is_taken(self, event: Event) -> bool:
        return event.name == "operator" and event.data.get("by") == "operator"

    def _pause(self) -> None:
        """While it is paused it makes no difference who has control: whoever has it then is found as it is resumed."""
        super()._pause()
        if self.mode == "paused":
            nodes = self._graph.nodes
            names = {*self._suspended, *self._laid_by}
            self._suspended = tuple(sorted(names, key=lambda name: nodes[name].index))
            self._laid_by = ()
            self._queue, self._kept = self._kept, ()

    def _keep(self, event: Event) -> None:
        """What comes from outside can come just as well right after the hand-back; all else is kept, once."""
        if _is_new(event, self._kept):
            super()._keep(event)

    def _wait_out_pause(self, event: Event) -> None:
        """The same for the end of a pause, where some transition names it."""
        if event.name in self._named_events and _is_new(event, self._queue):
            super()._wait_out_pause(event)


def _is_new(event: Event, waiting: tuple[Event, ...]) -> bool:
    """Whether it comes from inside, and nothing that waits makes the same difference."""
    is_own = event.kind == OUTCOME or event.name in BUILT_IN_EVENTS
    return is_own and all(kept_words(event) != kept_words(each) for each in waiting)


def kept_words(event: Event) -> tuple[str, str]:
    """All that makes a difference of an event that is kept."""
    data = event.data
    return event.name, str(data.get("state", data.get("action", data.get("call", ""))))


def _handed(who: str, by: str) -> Event:
    return Event(who, NOW, {"by": by}, "control")
