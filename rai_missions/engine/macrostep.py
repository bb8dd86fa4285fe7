# SPDX-License-Identifier: Apache-2.0
"""Run to completion: which rows a trigger fires, what taking them leaves and enters, until nothing is enabled.

Source: W3C SCXML (REC-scxml-20150901), appendix D, `mainEventLoop`, `selectTransitions`, `microstep`.
"""

from __future__ import annotations

import math
from typing import Any

from rai_missions.engine.completion import Endings
from rai_missions.engine.configuration import CompiledStep
from rai_missions.engine.nodes import CompiledTransition, Node
from rai_missions.engine.state import Trigger
from rai_missions.mission.mission import BUILT_IN_EVENTS

__all__ = ("MOST_MICROSTEPS", "Microsteps")

MOST_MICROSTEPS = 10_000
"""Microsteps at one instant; a mission that wants more runs in circles."""


class Microsteps(Endings):
    """A chart that takes rows."""

    def _heard(self, trigger: Trigger) -> None:
        """A macrostep of its own: after a pause, if there is one; after the end, nothing."""
        if self.outcome is not None:
            return
        if self.mode == "paused":
            self._wait_out_pause(self._event_of(trigger))
        elif self.mode in ("running", "canceling"):
            self._complete(trigger)

    def _complete(self, trigger: Trigger | None) -> None:
        """Take what is enabled until nothing is (SCXML: mainEventLoop)."""
        seen: set[Any] = set()
        left = MOST_MICROSTEPS
        while left > 0:
            left -= 1
            if self.outcome is not None or self.mode not in ("running", "canceling"):
                return
            if self._final is not None:
                return self._settle_final()
            if trigger is not None:
                self._answer(trigger)
                trigger = None
                continue
            if self._config.holds or self._always_held:
                self._hold()
            waiting = self._config.eventless if not self._frozen else self._free(self._config.eventless)
            if waiting and (rows := self._enabled(waiting, self.looked)):
                circle = (self._config.key, tuple(row.place for row in rows), len(self.written), len(self._internal))
                if circle in seen:
                    return self._circle()
                seen.add(circle)
                self._take(rows, "")
            elif self._internal:
                trigger = self._internal.popleft()
                seen.clear()
            elif self._starting:
                self._begin_starting()
            elif self._poll():
                left += 1  # what machines do ends by itself
            else:
                break
        else:
            return self._circle()
        self._settle_nested()
        if self._internal:
            return self._complete(None)
        self._check_invariants()

    def _circle(self) -> None:
        states = " → ".join(dict.fromkeys(name for move in self.moves[-50:] for name in move.entered))
        self._end("failed", f"a cycle without end: {states or 'internal events'}", cause="cycle")

    def _answer(self, trigger: Trigger) -> None:
        """Find the rows that a trigger fires, and take them."""
        view, source = self.view, trigger.source
        if trigger.name == "round" and source is not None and source.is_each:
            return self._next_round(source) if not self._is_held(source) else self._keep_trigger(trigger)
        view.event, option = trigger.data, False
        if trigger.row is not None:
            plan: tuple[tuple[CompiledTransition, ...], ...] = ((trigger.row,),)
        elif source is None:
            declared = trigger.name in self._declared
            found = self._config.plans.get(trigger.name)
            plan = found if found is not None else self._config.plan(trigger.name, declared=declared)
        else:
            option = trigger.name in (source.state.options if source.family == "decision" else ())  # type: ignore[union-attr]
            view.answer = trigger.data if option else view.answer
            plan = self._config.outcome_plan(
                source, trigger.name, option=option, climbs=trigger.climbs and trigger.name != "succeeded"
            )
        free = plan if not self._frozen else self._free(plan)
        rows = self._enabled(free, self.looked)
        if rows:
            self._take(rows, trigger.name)
        elif self._frozen and free != plan:
            self._keep_trigger(trigger)
        elif source is not None:
            self._unanswered(trigger, source)
        elif trigger.name in BUILT_IN_EVENTS or self.moves:
            self.notes.append(f"no row took '{trigger.name}'") if trigger.row is None else None

    def _unanswered(self, trigger: Trigger, source: Node) -> None:
        """An outcome that no row handles: unless it is a success, it is the mission's failure."""
        if trigger.name == "succeeded":
            if source.activity:
                self.notes.append(f"no row took 'succeeded' of '{source.name}'")
        elif trigger.climbs and source in self._config.nodes:
            why = f"{source.name}: {trigger.name}" + (f" ({trigger.why})" if trigger.why else "")
            self._end("failed", why)

    def _take(self, rows: list[CompiledTransition], trigger: str) -> None:
        self._jump(self._graph.leap(self._config, tuple(rows), self._memory, trigger))

    def _jump(self, leap: CompiledStep) -> None:
        """Make one microstep."""
        for node in leap.exited:
            self._exit(node)
        self._memory.update(leap.remember)
        self._config = leap.config
        self.view.active = leap.config.active
        self._shifted |= leap.shifts
        self.moves.append(leap.move)
        for act in leap.acts:
            act(self)
        for node in leap.entered:
            self._enter(node)

    def _exit(self, node: Node) -> None:
        if node.timed:
            self._timers.pop(("timeout", node.name), None)
            for row in node.rows:
                self._timers.pop(("after", row.place), None)
        if node.name in self._running:
            self._leave_activity(node)
        self._forget_waiting(node)
        if self._rounds.pop(node.name, None) is not None:
            for trigger in [each for each in self._internal if each.name == "round" and each.source is node]:
                self._internal.remove(trigger)  # a round that is left is not begun anew
        if node.clocked:
            self.view.entered.pop(node.name, None)
        if self.view.held:
            for row in node.rows:
                for memory in row.condition.holds if row.condition else ():
                    self.view.held.pop(memory, None)
        if node in self._starting:
            self._starting.remove(node)

    def _forget_waiting(self, node: Node) -> None:
        """What a state that is left waited for makes no difference any more."""
        if self._pending.pop(node.name, math.inf) < math.inf:
            self._given_up.add(node.control)
        self._settling.pop(node.name, None)
        if self._laid_by:
            self._laid_by = tuple(name for name in self._laid_by if name != node.name)

    def _enter(self, node: Node) -> None:
        if node.clocked:
            self.view.entered[node.name] = self._now_of(node.control)
        if node.timed:
            self._after_rows(node)
        if (node.activity or node.control) and node in self._config.atomic:
            self._starting.append(node)
        if node.is_each and node in self._config.atomic:
            self._next_round(node)

    def _after_rows(self, node: Node) -> None:
        if node.state is not None and node.state.timeout_s is not None:
            limit_s = node.state.timeout_s
            self._set_timer(("timeout", node.name), self.late_s + limit_s, f"{limit_s:g}", None, node.control)
        for row in node.rows:
            if row.transition.after_s is not None:
                self._set_timer(("after", row.place), row.transition.after_s, "after_s", None, node.control)

    def _hold(self) -> None:
        """Remember since when the guards inside `held` have been true."""
        for memory, test in (*self._config.holds.items(), *self._always_held.items()):
            if self._frozen and self._graph.memories.get(memory) in self._frozen:
                continue
            true = test(self.view) is True
            if true is not (memory in self.view.held):
                self._touched = True
                if true:
                    self.view.held[memory] = self.view.at
                else:
                    del self.view.held[memory]
