# SPDX-License-Identifier: Apache-2.0
"""Time: what was due until now happens at its own instant, and the next instant is known."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any

from rai_missions.engine.activities.activity import NO_KEYS, Outcome
from rai_missions.engine.commands import Modes
from rai_missions.engine.macrostep import MOST_MICROSTEPS
from rai_missions.engine.state import Timer, Trigger
from rai_missions.engine.step import CancelGoal

__all__ = ("Instants",)


class Instants(Modes):
    """A chart that knows what time alone does."""

    def _catch_up(self, at: float) -> None:
        """Let everything that was due until `at` happen, each at its own instant."""
        if at < self._wake:
            return
        same, moved = 0, False
        if unfinished := self._unfinished():
            self._due, moved = unfinished, True
            self._instant()
        while (due := self._next_instant()) <= at and same < MOST_MICROSTEPS:
            same, moved = same + 1 if due <= self.view.at else 0, True
            self._due = self._unfinished().union(self._woken(due))
            self.view.at = max(self.view.at, due)
            self._instant()
        if same >= MOST_MICROSTEPS:
            self._endless()
        if moved:
            self._listening = self._reads()  # what comes now finds what time has made of it

    def _woken(self, due: float) -> Iterable[str]:
        """The states whose machines asked for an instant not later than this."""
        for name, machine, state in self._awake() if self._running else ():
            if machine.wake_at(state, self.view) <= due:
                yield name

    def _endless(self) -> None:
        where = ", ".join(sorted(self.view.active))
        self._end("failed", f"timers without end in {where}", cause="cycle")

    def _instant(self) -> None:
        """What time alone does now."""
        self._tree_rounds.clear()
        now = self.view.at
        if self.mode == "paused":
            self._give_up_goals()
            self._check_invariants()
            return
        if self.mode == "canceling" and now >= self._cancel_by:
            self._end("canceled", "the cancel took longer than cancel_s")
        machines, self._due = self._due, NO_KEYS  # their turn comes after that of all timers
        for _ in range(MOST_MICROSTEPS):
            due = [(timer.due, timer.order, key) for key, timer in self._timers.items()
                   if timer.due <= now and timer.control not in self._frozen]  # fmt: skip
            if self.outcome is not None or not due:
                break
            key = min(due)[2]
            self._fire(key, self._timers.pop(key))
        else:
            return self._endless()
        for name in [name for name, until in self._pending.items() if until <= now]:
            if self._pending.get(name, math.inf) > now:
                continue  # the one before led out of it, or anew into it
            del self._pending[name]
            node = self._graph.nodes[name]
            self._given_up.add(node.control)
            self._leave_activity(node)
            self._heard(
                self._outcome_of(node, Outcome("rejected", why=f"{node.control} was not given control in time"))
            )
        self._give_up_goals()
        self._due = machines
        self._poll()
        self._complete(None)

    def _give_up_goals(self) -> None:
        """Goals whose end nobody has confirmed in time are orphans from now on."""
        for goal in self._ledger.overdue(self.view.at):
            self.notes.append(f"goal {goal.number} of '{goal.action}' never confirmed its end: orphaned")
            if goal.phase == "withdrawn":  # nobody may hear its acceptance any more, so the server is told beforehand
                self.effects.append(CancelGoal(goal.number, goal.action))
            self._heard(Trigger("orphaned", {"action": goal.action, "number": goal.number}))

    def _fire(self, key: tuple[str, Any], timer: Timer) -> None:
        kind, which = key
        self._touched = True
        if kind == "after":
            self._heard(Trigger("after_s", {}, row=self._graph.rows[which]))
        elif kind == "timeout":
            node = self._graph.nodes[which]
            self._leave_activity(node)
            self._heard(self._outcome_of(node, Outcome("timed_out", why=f"{timer.name} s have passed")))
        else:
            self._heard(Trigger(timer.name, timer.data))

    def _deadline(self, soonest: float) -> float:
        """The next one of timers, handovers and finals, but for what stands still; at the latest the one given."""
        frozen, nodes = self._frozen, self._graph.nodes
        for timer in self._timers.values():
            if timer.due < soonest and not (frozen and timer.control in frozen):
                soonest = timer.due
        for until in self._pending.values():
            soonest = min(soonest, until)
        for name, until in self._settling.items():
            if until < soonest and (not frozen or self._final is not None or nodes[name].control not in frozen):
                soonest = until
        return soonest

    def _next_instant(self) -> float:
        """The earliest instant at which time alone can change something."""
        now, soonest = self.view.at, self._ledger.wake_at()
        if self.mode == "ended" or self.mode == "ready":
            return soonest if self.mode == "ended" else math.inf
        for _, condition in self._invariants:
            for instant in condition.instants:
                soonest = min(soonest, _later(instant(self.view), now))
        if self.mode == "paused":
            return soonest
        soonest = min(soonest, self._cancel_by)
        soonest = self._deadline(soonest)
        for instant in self._config.instants:
            soonest = min(soonest, _later(instant(self.view), now))
        if self._settling or self._final is not None:
            finals = {self._final, *(self._graph.nodes[name] for name in self._settling)}
            for requires in [final.requires for final in finals if final is not None and final.requires is not None]:
                for instant in requires.instants:
                    soonest = min(soonest, _later(instant(self.view), now))
        for _, machine, state in self._awake() if self._running else ():
            soonest = min(soonest, machine.wake_at(state, self.view))
        return soonest


def _later(instant: float, now: float) -> float:
    return instant if instant > now else math.inf
