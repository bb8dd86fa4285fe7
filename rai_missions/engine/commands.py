# SPDX-License-Identifier: Apache-2.0
"""Pause, resume, cancel and kill: what a person may do to any mission, drawn in none."""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rai_missions.engine.activities.tree import is_settling, questions_in
from rai_missions.engine.holder import Holder
from rai_missions.engine.state import Trigger
from rai_missions.event import KINDS, Event
from rai_missions.keys import Stamped, fits
from rai_missions.model import suggestion

__all__ = ("Modes",)


class Modes(Holder):
    """A chart that obeys commands."""

    def _command(self, event: Event) -> None:
        by = str(event.data.get("by", "")) or "command"
        if event.name == "take_up":
            self._touched = True  # what the robot has said since was noted before
            if self.mode == "paused":
                self._begin_new()
                self._check_invariants()
            elif self.mode != "ready" and self.outcome is None:
                self._ask_again()
                self._begin_new()
                self._due = frozenset(self._running)  # each may have read what is not known any more
                self._poll()
                self._complete(None)
        elif event.name == "migrate" and self.mode == "ready":
            self._migrate(event.data)
        elif self.outcome is not None:
            self._refused = "the mission has ended"
        elif event.name == "kill":
            self._kill(f"killed by {by}")
        elif event.name == "cancel":
            self._cancel(by)
        elif event.name == "pause":
            self._pause()
        elif event.name == "resume":
            self._resume()
        else:
            self._refused = f"no command '{event.name}'{suggestion(event.name, ('pause', 'resume', 'cancel', 'kill'))}"

    def _hear_anew(self, heard: Mapping[str, Any]) -> None:
        """Another process goes on: what the robot said to the one before counts no more, if it can grow stale at all.

        Args:
            heard: Key → its value and stamp, as the robot says it now.
        """
        keys, board = self.mission.blackboard, self.view.board
        before = (
            {name: self.known(name) for name, key in keys.items() if key.source == "robot"} if self._has_trees else {}
        )
        for name in [name for name in board if keys[name].source == "robot" and keys[name].max_age_s is not None]:
            del board[name]
        for name, (value, at) in heard.items():
            if name in keys and not fits(keys[name], value):
                board[name] = Stamped(value, float(at))
                self.written.append((name, value))
        for name, known in before.items():
            self.note_news(name, known)
        self._look_ahead()

    def _ask_again(self) -> None:
        """Give what another process asks for once more its time.

        A handover has all of it; a question, and what waits for facts to confirm a result, has what was left of it.
        """
        for name, machine, state in self._awake() if self.late_s else ():
            if any(questions_in(state)) or is_settling(state):
                self._running[name] = machine.shifted(state, self.late_s)
        for name in self._settling:
            self._settling[name] += 0.0 if self._is_held(self._graph.nodes[name]) else self.late_s
        for name, until in self._pending.items():
            node = self._graph.nodes[name]
            if node.state is not None and until < math.inf and not self._is_held(node):
                self._pending[name] = max(until, self.view.at + node.state.handover_s)

    def _begin_new(self) -> None:
        """Begin what a migration has brought: `entry` where nothing was before, and what runs there."""
        unbegun, self._unbegun = self._unbegun, ()
        for name, is_new in unbegun:
            node = self._graph.nodes[name]
            for act in node.entry if is_new else ():
                act(self)
            if (node.activity or node.control) and node in self._config.atomic:
                self._starting.append(node)
        if self.mode == "paused":
            self._suspended += tuple(node.name for node in self._starting)
            self._starting = []

    def _migrate(self, data: Mapping[str, Any]) -> None:
        """Stand where a run of another mission stood."""
        raise NotImplementedError

    def _look_ahead(self) -> None:
        """See what the next event may change."""
        raise NotImplementedError

    def _cancel(self, by: str) -> None:
        if self.mode == "canceling":
            self._refused = "it is being canceled already"
            return
        self._hear_kept(None)
        if self.mode == "paused":
            self._make_up_pause()
        self._suspended = self._laid_by = ()
        self.mode, self.why = "canceling", f"canceled by {by}"
        self._cancel_by = self.view.at + self.mission.cancel_s
        if self.mission.on_cancel is None or not self._config.atomic:
            self._end("canceled", self.why)
            return
        self._final = None
        target = self._graph.nodes[self.mission.on_cancel]
        self._jump(self._graph.flee(self._config, target, self._memory, "cancel"))
        self._complete(None)

    def _pause(self) -> None:
        if self.mode != "running":
            self._refused = f"only a running mission can be paused; it is {self.mode}"
            return
        self.mode, self._paused_at = "paused", self.view.at
        self._suspended = tuple(name for name in list(self._running) if self._lay_down(self._graph.nodes[name]))
        self.notes.append("paused")

    def _resume(self) -> None:
        if self.mode != "paused":
            self._refused = f"only a paused mission can be resumed; it is {self.mode}"
            return
        self._make_up_pause()
        self.mode, self._ledger.changed = "running", True
        self.notes.append("resumed")
        self._starting += [self._graph.nodes[name] for name in self._suspended]
        for name in [name for name in self._pending if self._graph.nodes[name].control == self.holder]:
            del self._pending[name]
            self._starting += [self._graph.nodes[name]] if name not in self._running else []
        queue, self._queue, self._suspended = self._queue, (), ()
        self._due |= frozenset(self._running)  # each may have read what has changed since
        self._ask_back()
        self._complete(None)
        for event in queue:
            self._handle_late(event)

    def _make_up_pause(self) -> None:
        """Time goes on: for held states from where it stood when the run was paused."""
        by_s = self.view.at - self._paused_at
        self._shift(by_s)
        self._frozen = {control: since + by_s for control, since in self._frozen.items()}

    def _happen(self, event: Event) -> None:
        """Something of the world outside, unless nobody knows it; while paused it waits."""
        name, kind = event.name, event.kind
        if kind == "event" and name not in self._declared:
            self._refused = f"the mission declares no event '{name}'{suggestion(name, self._declared)}"
        elif kind not in ("event", "doubt", "proposal", "behaviour"):
            self._refused = f"there is no event of kind '{kind}'{suggestion(kind, KINDS)}"
        elif self.mode == "paused":
            self._wait_out_pause(event)
        elif kind in ("event", "doubt"):
            self._heard(Trigger(name, event.data))
        elif self._is_for_held(event.number):
            self._keep(event)
        elif not self._dispatch(event) and kind == "proposal":
            self._refused = f"stale: question {event.number} is no longer asked"
