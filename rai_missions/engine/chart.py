# SPDX-License-Identifier: Apache-2.0
"""The pure semantics: what a mission makes of an event, as a Step.

Rule: everything that decides is in here or below. The same mission, events and times give the same Steps.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

from rai_missions.engine.activities.goal_ledger import OpenGoal
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.configuration import CompiledStep
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.snapshot import Saving, Snapshot
from rai_missions.engine.state import Named
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.guards.guard import Truth
from rai_missions.keys import Stamped, fits, stale_at
from rai_missions.mission.mission import Mission
from rai_missions.model import suggestion

__all__ = ("NOT_STARTED", "Chart", "Named", "Snapshot")

NOT_STARTED = "the mission has not been started"
"""Why an event before the start changes nothing."""

_new = tuple.__new__


class Chart(Saving):
    """One run of a mission, as far as rules decide it.

    Args:
        mission: A mission that `check` finds no fault in.
        ticker: Who ticks trees (`rai_missions.trees.PyTrees()`); needed only where the mission has one.
        terms: What is known of the robot: which actions exclude each other, when a composed one has succeeded.
        named: The predicates that `{"named": …}` guards name.

    Raises:
        UsageError: The mission has a tree and no ticker was given, or names a predicate that was not.
    """

    # -- the public face ------------------------------------------------------------------------------------------

    @property
    def active(self) -> frozenset[str]:
        """The names of the active states, ancestors included."""
        return self.view.active

    @property
    def at(self) -> float:
        """Now, in seconds on the run's clock."""
        return self.view.at

    @property
    def wake_at(self) -> float | None:
        """The earliest instant at which time alone can change something."""
        return None if self._wake == math.inf else self._wake

    @property
    def unheard(self) -> tuple[str, ...]:
        """The robot keys that the start waits for: never received, or stale whenever they were."""
        keys, board = self.mission.blackboard.items(), self.view.board
        waited = (name for name, key in keys if key.source == "robot" and not key.optional)
        return tuple(name for name in waited if name not in board or name in self._outdated)

    @property
    def open_goals(self) -> int:
        """How many goals have an end that has not been confirmed and that the run waits for."""
        return self._ledger.awaited

    @property
    def loose_goals(self) -> tuple[OpenGoal, ...]:
        """The goals that may still be executing, and that no cancel can be relied on to end."""
        return self._ledger.loose

    @property
    def awaited(self) -> frozenset[int]:
        """The numbers of goals, calls, questions and behaviours whose end the run still waits for."""
        each = (machine.awaits(state) for _, machine, state in self._live())
        return frozenset(self._ledger.goals).union(self._calls, *each)

    @property
    def waiting(self) -> Mapping[str, str]:
        """State → who must have control before what it does can begin, or begin again."""
        each = {name: self._graph.nodes[name].control for name in (*self._pending, *self._laid_by)}
        return {name: holder for name, holder in each.items() if holder is not None}

    @property
    def wanted(self) -> frozenset[str]:
        """Who must have control for what waits to begin."""
        wanted = (self._graph.nodes[name].control for name in self._pending)
        return frozenset(holder for holder in wanted if holder is not None)

    def start(self, at: float = 0.0) -> Step:
        """Enter the mission.

        Raises:
            UsageError: It was started before.
        """
        if self.mode != "ready":
            raise UsageError(f"the mission was started before; it is {self.mode}")
        self._clear()
        view = self.view
        view.at = max(at, view.at)
        for name, key in self.mission.blackboard.items():
            if key.initial is not None and key.source != "robot" and view.board[name].at < view.at:
                view.board[name] = Stamped(view.board[name].value, view.at)
        self.mode, self._held_since = "running", view.at
        self._frozen = dict.fromkeys(self._held_controls(), view.at)
        if self._graph.root.clocked:
            view.entered[""] = view.at
        self._after_rows(self._graph.root)
        self._jump(self._graph.start(self._memory))
        self._complete(None)
        return self._close(Event("start", at, kind="command"))

    def write(self, key: str, value: Any, at: float | None = None, *, stamp: float | None = None) -> Step:
        """Tell the blackboard what a key is.

        Args:
            key: Its name.
            value: Its value.
            at: When that is received: now, if nothing else is given.
            stamp: When it was so, also before the run began; `at`, if nothing else is given.

        Raises:
            UsageError: The mission has no such key.
        """
        if key not in self.mission.blackboard:
            raise UsageError(f"the mission has no key '{key}'{suggestion(key, self.mission.blackboard)}")
        data = {"value": value} if stamp is None else {"value": value, "stamp": stamp}
        return self.send(Event(key, self.view.at if at is None else at, data, "write"))

    def send(self, event: Event) -> Step:
        """Let an event happen: everything due before it first, then it, to completion.

        One whose time has passed already happens now.

        Raises:
            UsageError: Its time is not a finite number of seconds.
        """
        name, at, data, kind, _ = event
        if kind != "event" or not self._quick or at >= self._wake:
            return self._send(event)
        view = self.view
        if at > view.at:
            view.at = at
        else:
            at = view.at
        config = self._config
        plan = config.plans.get(name)
        if plan is None:
            plan = config.plan(name, declared=name in self._declared)
        if not plan:
            return self._send(event) if name not in self._declared else self._quiet(event, at)
        view.event = data
        looked: list[tuple[str, Truth]] = []
        rows = self._enabled(plan, looked)
        if not rows:
            return self._quiet(event, at, tuple(looked))
        leap = config.leaps.get((tuple(rows), name))
        if leap is None or not leap.plain or not leap.shifts.isdisjoint(self._listening):
            return self._send(event)
        self._config = leap.config
        view.active = leap.config.active
        self.seq += 1
        wake = None if self._wake == math.inf else self._wake
        if not leap.acts:
            return _new(Step, (self.seq, at, event, leap.moves, tuple(looked), (), None, wake, (), "", (), ()))
        return self._acted(event, leap, looked)

    def _acted(self, event: Event, leap: CompiledStep, looked: list[tuple[str, Truth]]) -> Step:
        """The end of a quick step that does something on the way."""
        for act in leap.acts:
            act(self)
        written = self.written
        if self._internal or (written and self._listening):
            self.seq -= 1
            self.moves.append(leap.move)
            self.looked += looked
            self._complete(None)
            return self._close(event)
        step: Step = _new(Step, (
            self.seq, self.view.at, event, leap.moves, tuple(looked), tuple(written), None,
            None if self._wake == math.inf else self._wake, tuple(self.effects), "", tuple(self.notes), (),
        ))  # fmt: skip
        written.clear()
        if self.effects or self.notes or self._news:
            self._clear()
        return step

    def _quiet(self, event: Event, at: float, looked: tuple[tuple[str, Truth], ...] = ()) -> Step:
        """A step in which no row fired."""
        self.seq += 1
        wake = None if self._wake == math.inf else self._wake
        return _new(Step, (self.seq, at, event, (), looked, (), None, wake, (), "", (), ()))

    @classmethod
    def restore(
        cls, mission: Mission, saved: Snapshot, ticker: Trees | None = None, *, terms: RobotFacts | None = None,
        named: Named | None = None,
    ) -> Chart:  # fmt: skip
        """A chart that goes on where a snapshot was taken."""
        chart = cls(mission, ticker, terms=terms, named=named)
        chart._stand(saved)
        return chart

    def absorb(self, writes: Iterable[tuple[str, Any, float]], *, at: float, seq: int) -> None:
        """Take over what quiet steps wrote, without stepping: a replay stands where the run stood then.

        Args:
            writes: Key, value and stamp.
            at: The time until which nothing else happened.
            seq: The number of the last step until then.
        """
        writes = tuple(writes)
        if not writes and seq == self.seq:
            return
        for key, value, stamp in writes:
            self.view.board[key] = Stamped(value, stamp)
        self.view.at, self.seq = max(self.view.at, at), seq
        self._look_ahead()

    # -- one step -------------------------------------------------------------------------------------------------

    def _send(self, event: Event) -> Step:
        if not math.isfinite(event.at):
            raise UsageError(f"'{event.name}' cannot happen at {event.at} s; give a finite number of seconds")
        self._clear()
        at = max(event.at, self.view.at)
        if event.kind == "command" and event.name == "take_up":
            self._present = float(event.data.get("present", at))
            self._hear_anew(event.data.get("heard", {}))  # before time goes on: nothing is stale that was heard again
        if self.mode == "ready":
            self.view.at = at
            if event.kind == "write":
                self._receive(event)
            elif event.kind == "control":
                self._control(event)
            elif event.kind == "command" and event.name in ("cancel", "kill", "take_up", "migrate"):
                self._command(event)
            else:
                self._refused = NOT_STARTED
            return self._close(event)
        self._catch_up(at)
        self.view.at = at
        self._handle(event)
        return self._close(event)

    def _close(self, event: Event) -> Step:
        if self._given_up:
            self._take_back()
        self.seq += 1
        changed = self.moves or self.effects or self.notes or self._touched or self._refused
        is_quiet = not changed and event.kind in ("write", "tick") and self.mode == "running"
        if is_quiet:
            self._wake = self.view.at if self._unfinished() else self._next_instant()
        else:
            self._look_ahead()
        is_over = self.outcome is not None and self.mode == "ended"
        why = self.why if is_over and (self._ended or not self._refused) else self._refused
        step: Step = _new(Step, (
            self.seq, self.view.at, event, tuple(self.moves), tuple(self.looked), tuple(self.written), self.outcome,
            None if self._wake == math.inf else self._wake, tuple(self.effects), why, tuple(self.notes), self._resting,
        ))  # fmt: skip
        asked = self.looked and any(place.startswith("named:") for place, _ in self.looked)
        self.quiet = not (changed or asked) and event.kind in ("write", "tick")
        self._clear()
        return step

    def _look_ahead(self) -> None:
        """What the next event finds: whether it can take the short way, what it may change, what time alone does."""
        self._quick = self.mode == "running" and self._final is None and self.outcome is None and not self._named
        self._quick = self._quick and not self._frozen
        self._listening = self._reads() if self.mode != "ended" else frozenset()
        self._quick = self._quick and not self._resting
        self._wake = self.view.at if self._unfinished() else self._next_instant()

    def _handle(self, event: Event) -> None:
        self._tree_rounds.clear()
        kind = event.kind
        if kind in ("tick", "feedback"):
            return
        if kind == "command":
            self._command(event)
        elif kind in ("accepted", "result"):
            self._report(event)
        elif kind in ("refused", "lost", "contested", "stray", "over"):
            self._watch_goal(event)
        elif self.outcome is not None:
            self._refused = "the mission has ended"
        elif kind == "write":
            self._write(event)
        elif kind == "control":
            self._control(event)
        elif self._final is not None and self.mode != "paused":
            self._refused = f"the mission is ending in '{self._final.name}'"
        else:
            self._happen(event)

    def _receive(self, event: Event) -> None:
        """A write before the start; a reading that is stale as it comes is no reason to begin."""
        name, board = event.name, self.view.board
        is_known = name in board and name not in self._outdated
        self._write(event)
        if not is_known and name in board:
            is_fresh = self.view.at < stale_at(self.mission.blackboard[name], board[name])
            (self._outdated.discard if is_fresh else self._outdated.add)(name)

    def _write(self, event: Event) -> None:
        key = self.mission.blackboard.get(event.name)
        value = event.data.get("value")
        stamp = min(float(event.data.get("stamp", event.at)), self.view.at)
        if key is None:
            self._refused = f"the mission has no key '{event.name}'{suggestion(event.name, self.mission.blackboard)}"
            return
        if why := fits(key, value):
            self._refused = f"'{event.name}' was not written: {why}"
            return
        entry = self.view.board.get(event.name)
        if entry is not None and entry.at > stamp:
            self._refused = f"'{event.name}' was not written: {entry.at - stamp:.3g} s older than what is known"
            return
        before = self.known(event.name) if self._has_trees else None
        self.view.board[event.name] = Stamped(value, stamp)
        self.written.append((event.name, value))
        if event.name not in self._listening and "*" not in self._listening:
            return
        if self._has_trees:
            self.note_news(event.name, before)
        if self.mode == "paused":
            self._check_invariants()
        elif self.mode != "ready":
            self._poll()
            self._complete(None)
