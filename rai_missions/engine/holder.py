# SPDX-License-Identifier: Apache-2.0
"""Who holds control: what happens as it changes hands, as the operator takes it, and as the operator gives it back."""

from __future__ import annotations

import math
from collections.abc import Container

from rai_missions.engine.hold import HOLDERS
from rai_missions.engine.macrostep import Microsteps
from rai_missions.engine.nodes import Node
from rai_missions.errors import suggestion
from rai_missions.event import Event, is_taken

__all__ = ("Holder",)


class Holder(Microsteps):
    """A chart that follows who holds control."""

    def _control(self, event: Event) -> None:
        """Control is with a holder from now on: what waited for it starts, what needs another waits."""
        if event.name not in HOLDERS:
            self._refused = f"nobody called '{event.name}' can hold control{suggestion(event.name, HOLDERS)}"
            return
        before = self.held_by
        self.taken = self._is_taken(event)
        self.holder, self._asked = event.name, "" if self._asked == event.name else self._asked
        self.notes.append(f"control: {event.name}")
        if self.mode == "ready":
            return
        if self.held_by != before:
            self._held_since = self.view.at
        self._change_hands()

    def _is_taken(self, event: Event) -> bool:
        """Whether the operator has taken control, rather than been given it by the mission."""
        return is_taken(event, holder=self.holder, taken=self.taken, asked=self._asked)

    def _change_hands(self) -> None:
        held, was = self._held_controls(), frozenset(self._frozen)
        freed = was - held
        for name in [name for name in self._running if self._is_lost(self._graph.nodes[name], held | freed)]:
            self._leave_activity(self._graph.nodes[name])
            self._pending[name] = math.inf
            self.notes.append(f"{name} waits until control is with {self._graph.nodes[name].control} again")
        if freed:
            self._thaw(freed)
        if held - was:
            self._freeze(held - was)
        if self.mode == "paused":
            return
        for name in sorted(self._pending, key=lambda each: self._graph.nodes[each].index):
            if self._graph.nodes[name].control == self.holder:
                self._get_control(name)
        self._complete(None)
        if freed:
            self._handle_kept()

    def _is_lost(self, node: Node, waiting: Container[str]) -> bool:
        """What runs there has lost control, and neither waits for the hand-back nor continues by it."""
        return node.control is not None and node.control != self.holder and node.control not in waiting

    def _get_control(self, name: str) -> None:
        """What waits for control has it."""
        if self._pending.pop(name, None) is not None and name not in self._running:
            self._begin(self._graph.nodes[name])

    # -- taken, and given back ------------------------------------------------------------------------------------

    def _freeze(self, controls: frozenset[str]) -> None:
        """The states that need one of these are held from now on."""
        nodes = self._graph.nodes
        self._frozen = {**self._frozen, **dict.fromkeys(controls, self._run_at)}
        laid = {name for name in self._pending if nodes[name].control in controls}
        laid |= {node.name for node in self._config.atomic if node.control in controls and not node.activity}
        for name in list(self._running):
            if nodes[name].control in controls and self._lay_down(nodes[name]):
                laid.add(name)
        for name in laid:
            self._pending.pop(name, None)
        laid -= set(self._suspended)
        self.notes += [f"{name} waits until control is given back" for name in sorted(laid)]
        self._laid_by = tuple(sorted({*self._laid_by, *laid}, key=lambda name: nodes[name].index))

    def _lay_down(self, node: Node) -> bool:
        """End an action or a tree that is to start again later; what a profile says to `keep` goes on."""
        if node.family not in ("action", "tree") or getattr(node.state, "action", None) in self.terms.keep:
            return False
        self._leave_activity(node)
        return True

    def _thaw(self, controls: frozenset[str]) -> None:
        """The states that need one of these are held no more: they have the time that they had left."""
        nodes = self._graph.nodes
        for control in sorted(controls):
            self._shift(self._run_at - self._frozen[control], (control,))
        self._frozen = {control: since for control, since in self._frozen.items() if control not in controls}
        free = tuple(name for name in self._laid_by if nodes[name].control in controls)
        self._laid_by = tuple(name for name in self._laid_by if name not in free)
        if self.mode == "paused":
            self._suspended += free
            self._queue, self._kept = (*self._kept, *self._queue), ()
            return
        self._starting += [nodes[name] for name in free]
        self._due |= {name for name in self._running if nodes[name].control in controls}
        self._ask_back()

    def _ask_back(self) -> None:
        """Ask for the control that what goes on running had."""
        for node in [self._graph.nodes[name] for name in self._running if name not in self._pending]:
            if node.control is not None and node.control != self.holder and not self._is_held(node):
                self._request_control(node)

    def _handle_kept(self) -> None:
        """What came meanwhile happens now, in the order in which it came."""
        kept, self._kept = self._kept, ()
        for event in kept:
            self._handle_late(event)

    def _handle_late(self, event: Event) -> None:
        """What has waited for the hand-back, or the end of a pause, happens now, unless what it is for is held."""
        if self.outcome is not None:
            return
        if event.number and self._is_for_held(event.number):
            self._kept = (*self._kept, event)
        elif event.kind in ("proposal", "behaviour"):
            if not self._dispatch(event) and event.kind == "proposal":
                self.notes.append(f"stale: question {event.number} is no longer asked")
        elif event.number:
            self._report(event)
        elif (trigger := self._trigger_of(event)) is not None:
            self._heard(trigger)
