# SPDX-License-Identifier: Apache-2.0
"""What waits while the operator keeps control: a state is held whose innermost `control` is not with its holder.

Rule: held follows from who has control alone. Timers, rows, activities and events ask here, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Container, Iterator
from typing import Any, get_args

from rai_missions.engine.activities.activity import Machine
from rai_missions.engine.nodes import CompiledTransition, Node
from rai_missions.engine.state import Core, Trigger
from rai_missions.event import Event
from rai_missions.states.state import Controller

__all__ = ("HOLDERS", "OUTCOME", "Hold")

HOLDERS = (*get_args(Controller), "nobody")
"""Who can hold control."""
OUTCOME = "outcome"
"""The kind of a kept event that is an outcome: its state and the rest of the trigger are in its data."""


class Hold(Core):
    """A chart that knows which of its states wait for the operator to give control back."""

    @property
    def held_by(self) -> str:
        """`operator`, who has taken control, or `nobody`; empty while the mission is not held."""
        if self.mode in ("ready", "ended"):
            return ""
        return self.holder if self.holder == "nobody" or (self.holder == "operator" and self.taken) else ""

    @property
    def held_since(self) -> float | None:
        """Since when, in seconds on the run's clock; None while the mission is not held."""
        return self._held_since if self.held_by else None

    @property
    def held(self) -> frozenset[str]:
        """The active states that wait until the operator gives control back."""
        return frozenset(node.name for node in self._config.nodes if self._frozen and node.control in self._frozen)

    def still_since(self, name: str) -> float | None:
        """Since when the time of a state stands still, in seconds on the run's clock; None while it runs."""
        instants = [self._paused_at] if self.mode == "paused" else []
        control = self._graph.nodes[name].control
        instants += [self._frozen[control]] if control in self._frozen else []
        return min(instants, default=None)

    def _held_controls(self) -> frozenset[str]:
        """The controls in the mission whose states are held as long as control is where it is."""
        by = self.held_by
        return self._graph.controls - {by} if by else frozenset()

    def _is_held(self, node: Node) -> bool:
        return node.control in self._frozen

    def _now_of(self, control: str | None) -> float:
        """Now, as the states that need this control count time: it stands still while they are held."""
        return self._frozen.get(control, self.view.at) if self._frozen and control is not None else self.view.at

    @property
    def _run_at(self) -> float:
        """Now, or when the run was paused."""
        return self._paused_at if self.mode == "paused" else self.view.at

    def _free(self, plan: tuple[tuple[CompiledTransition, ...], ...]) -> tuple[tuple[CompiledTransition, ...], ...]:
        """A plan without the transitions of held states."""
        chains = (tuple(row for row in chain if not self._is_held(row.source)) for chain in plan)
        return tuple(chain for chain in chains if chain)

    def settle_holds(self) -> None:
        """Give what is held, now, the time that it had left: what begins from here on counts from the same instant."""
        for control in sorted(self._frozen):
            self._shift(self._run_at - self._frozen[control], (control,))
        self._frozen = dict.fromkeys(self._frozen, self._run_at)

    # -- what came meanwhile --------------------------------------------------------------------------------------

    def _keep(self, event: Event) -> None:
        """Have an event wait for the hand-back."""
        self._kept = (*self._kept, event)
        self._touched = True
        what = f"the outcome '{event.name}' of '{event.data['state']}'" if event.kind == OUTCOME else f"'{event.name}'"
        self.notes.append(f"{what} waits until the operator gives control back")

    def _keep_trigger(self, trigger: Trigger) -> None:
        """The same for what only the transitions of held states name, wherever it came from."""
        self._keep(self._event_of(trigger))

    def _event_of(self, trigger: Trigger) -> Event:
        """What a trigger waits as; `_trigger_of` undoes it."""
        name, data, source = trigger.name, trigger.data, trigger.source
        if source is None:
            return Event(name, self.view.at, data)
        given = {"state": source.name, "climbs": trigger.climbs, "why": trigger.why, "data": dict(data)}
        return Event(name, self.view.at, given, OUTCOME)

    def _wait_out_pause(self, event: Event) -> None:
        """Have an event wait until the run is resumed."""
        self._queue = (*self._queue, event)
        self._touched = True

    def _trigger_of(self, event: Event) -> Trigger | None:
        """The trigger that was kept as this event; None where the state that reported it was left meanwhile."""
        if event.kind != OUTCOME:
            return Trigger(event.name, event.data)
        node, data = self._graph.nodes[event.data["state"]], event.data
        is_active = node in self._config.nodes
        return Trigger(event.name, data["data"], node, data["climbs"], data["why"]) if is_active else None

    def _hear_kept(self, numbers: Container[int] | None) -> None:
        """What is left before it was given its report is out of it; the ledger of goals is not.

        Args:
            numbers: Of the starts and questions that nobody waits for any more; None for all that there are.
        """
        left: dict[str, tuple[Event, ...]] = {}
        for store in ("_kept", "_queue"):
            events: tuple[Event, ...] = getattr(self, store)
            gone = [each for each in events if each.number and (numbers is None or each.number in numbers)]
            for event in gone:
                self.effects += self._ledger.hear(event) if event.kind in ("accepted", "result") else ()
            left[store] = tuple(each for each in events if each not in gone) if numbers is not None else ()
        self._kept, self._queue = left["_kept"], left["_queue"]

    # -- time -----------------------------------------------------------------------------------------------------

    def _shift(self, by_s: float, controls: Container[str | None] | None = None) -> None:
        """Give what waits for time as much as it had left.

        Args:
            by_s: How long it has stood still.
            controls: Only for the states that need one of these; for all there is without them.
        """

        def concerns(control: str | None) -> bool:
            return controls is None or control in controls

        nodes = self._graph.nodes
        of = {name: node.control for name, node in nodes.items()}
        since = {memory: self._graph.memories.get(memory) for memory in self.view.held}
        self._timers = {
            key: timer._replace(due=timer.due + by_s) if concerns(timer.control or None) else timer
            for key, timer in self._timers.items()
        }
        self.view.held = {each: at + by_s if concerns(since[each]) else at for each, at in self.view.held.items()}
        self.view.entered = _later(self.view.entered, by_s, of, concerns)
        self._pending = _later(self._pending, by_s, of, concerns)
        self._settling = _later(self._settling, by_s, of, concerns)
        for name, machine, state in self._live():
            if concerns(nodes[name].control):
                self._running[name] = machine.shifted(state, by_s)

    def _live(self) -> Iterator[tuple[str, Machine, Any]]:
        """The machines that run, each with its state; one that is left meanwhile is passed over."""
        for name in tuple(self._running):
            machine = self._machines[name]
            if name in self._running and machine is not None:
                yield name, machine, self._running[name]

    def _awake(self) -> Iterator[tuple[str, Machine, Any]]:
        """Those of them whose state is not held."""
        if not self._frozen:
            return self._live()
        nodes = self._graph.nodes
        return (each for each in self._live() if not self._is_held(nodes[each[0]]))

    def _is_for_held(self, number: int) -> bool:
        """Whether what runs in a held state waits for what comes under this number."""
        return bool(self._frozen) and any(
            number in machine.awaits(state) for name, machine, state in self._live()
            if self._is_held(self._graph.nodes[name])
        )  # fmt: skip


def _later(instants: dict[str, float], by_s: float, of: Any, concerns: Any) -> dict[str, float]:
    """Instants by state, those moved whose control is concerned."""
    return {name: at + by_s if concerns(of.get(name)) else at for name, at in instants.items()}
