# SPDX-License-Identifier: Apache-2.0
"""The machine of a tree: ticks it, starts and ends its leaves with the machines that the states of the same words use.

Rule: what a tick ends has ended before what it starts is started.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from rai_missions.event import Event
from rai_missions.guards.guard import View
from rai_missions.states.activity import Desk, Machine, Outcome, Turn, concerns
from rai_missions.states.asking import Asking
from rai_missions.states.ticker import Ticked, Ticker, TreeState
from rai_missions.step import Effect, PublishMessage
from rai_missions.verdict import Question

__all__ = ("Limb", "Tending", "TendingMachine", "questions_in")

MOST_TICKS = 1000
"""Ticks of one tree at one instant; a tree that wants more runs in circles."""


class Limb(NamedTuple):
    """A leaf that the chart can run."""

    machine: Machine
    timeout_s: float | None


class Tended(NamedTuple):
    """A leaf that runs."""

    state: Any
    deadline: float


class Tending(NamedTuple):
    """How far a tree has come."""

    tree: TreeState = TreeState()
    leaves: Mapping[str, Tended] = {}
    """Path → the leaf that runs there."""
    wake: float = math.inf
    """When the tree itself wants its next tick, if nothing that it reads changes before."""


def questions_in(state: Any) -> Iterator[Question]:
    """What is asked by a machine in this state, a tree's leaves included."""
    if isinstance(state, Asking):
        yield state.question
    elif isinstance(state, Tending):
        for tended in state.leaves.values():
            yield from questions_in(tended.state)


class _Growth:
    """What a turn is gathering."""

    def __init__(self, state: Tending) -> None:
        self.tree, self.leaves, self.wake = state.tree, dict(state.leaves), state.wake
        self.effects: list[Effect] = []
        self.notes: list[str] = []
        self.outcomes: dict[str, str] = {}

    def turn(self, outcome: Outcome | None) -> Turn:
        state = None if outcome is not None else Tending(self.tree, self.leaves, self.wake)
        return Turn(state, tuple(self.effects), outcome, notes=tuple(self.notes))


class TendingMachine:
    """Runs one tree.

    Args:
        ticker: The tree, compiled.
        limbs: Path → the leaf that runs there when the tick says so.
        owner: The state.
    """

    def __init__(self, ticker: Ticker, limbs: Mapping[str, Limb], owner: str) -> None:
        self.ticker, self.limbs, self.owner = ticker, limbs, owner

    def begin(self, desk: Desk) -> Turn:
        return self._tick(_Growth(Tending()), desk)

    def hear(self, state: Tending, event: Event, desk: Desk) -> Turn | None:
        growth, heard = _Growth(state), False
        for path, tended in state.leaves.items():
            turn = self._leaf(path, tended, event, desk)
            if turn is not None:
                heard = True
                self._take(growth, path, turn, tended.deadline, desk)
        if not growth.outcomes and not self._wants(state, event, desk):
            return growth.turn(None) if heard else None
        turn = self._tick(growth, desk)
        return turn if self._says(turn, state) else None

    def _wants(self, state: Tending, event: Event, desk: Desk) -> bool:
        """Whether the tree itself is to be ticked: its time has come, or a key that it reads has changed."""
        if event.kind != "tick":
            return False
        return desk.view.at >= state.wake or concerns(self.ticker.reads(state.tree), event.data["keys"])

    @staticmethod
    def _says(turn: Turn, before: Tending) -> bool:
        return bool(turn.effects or turn.outcome or turn.notes) or turn.state != before

    def _leaf(self, path: str, tended: Tended, event: Event, desk: Desk) -> Turn | None:
        limb = self.limbs[path]
        if event.kind == "tick" and desk.view.at >= tended.deadline:
            left = limb.machine.leave(tended.state, desk)
            return left._replace(outcome=Outcome("timed_out"))
        return limb.machine.hear(tended.state, event, desk)

    def _take(self, growth: _Growth, path: str, turn: Turn, deadline: float, desk: Desk) -> None:
        growth.effects += turn.effects
        growth.notes += turn.notes
        for key, value in turn.writes:
            desk.write_key(key, value)
        if turn.outcome is None:
            growth.leaves[path] = Tended(turn.state, deadline)
            return
        growth.leaves.pop(path, None)
        growth.outcomes[path] = turn.outcome.name
        if turn.outcome.why:
            growth.notes.append(f"{self.owner}#{path} {turn.outcome.name}: {turn.outcome.why}")

    def _tick(self, growth: _Growth, desk: Desk) -> Turn:
        """Tick, and at once again where the tree goes on by itself or a leaf has ended as soon as it was started."""
        for _ in range(MOST_TICKS):
            ticked = self.ticker.tick(growth.tree, desk.view, growth.outcomes)
            growth.outcomes = {}
            self._apply(growth, ticked, desk)
            if ticked.status in ("success", "failure"):
                self._end(growth, growth.leaves, desk)
                return growth.turn(Outcome("succeeded" if ticked.status == "success" else "failed"))
            if not ticked.again and not growth.outcomes:
                growth.wake = self.ticker.wake_at(growth.tree, desk.view)
                return growth.turn(None)
        self._end(growth, growth.leaves, desk)
        growth.notes.append(f"the tree in '{self.owner}' was ticked {MOST_TICKS} times without coming to rest")
        return growth.turn(Outcome("failed", why="the tree runs in circles"))

    def _apply(self, growth: _Growth, ticked: Ticked, desk: Desk) -> None:
        growth.tree = ticked.state
        for key, value in ticked.writes:
            desk.write_key(key, value)
        growth.effects += [PublishMessage(topic, message) for topic, message in ticked.published]
        self._end(growth, ticked.ended, desk)
        for path in ticked.started:
            limb = self.limbs[path]
            deadline = desk.view.at + limb.timeout_s if limb.timeout_s is not None else math.inf
            self._take(growth, path, limb.machine.begin(desk), deadline, desk)

    def _end(self, growth: _Growth, paths: Iterable[str], desk: Desk) -> None:
        for path in list(paths):
            tended = growth.leaves.pop(path, None)
            if tended is not None:
                growth.effects += self.limbs[path].machine.leave(tended.state, desk).effects

    def leave(self, state: Tending, desk: Desk) -> Turn:
        growth = _Growth(state)
        self.ticker.stop(state.tree, desk.view)
        self._end(growth, state.leaves, desk)
        return growth.turn(None)._replace(state=None)

    def wake_at(self, state: Tending, view: View) -> float:
        leaves = (
            min(tended.deadline, self.limbs[path].machine.wake_at(tended.state, view))
            for path, tended in state.leaves.items()
        )
        return min([state.wake, *leaves])

    def reads(self, state: Tending) -> frozenset[str]:
        each = (self.limbs[path].machine.reads(tended.state) for path, tended in state.leaves.items())
        return self.ticker.reads(state.tree).union(*each)

    def awaits(self, state: Tending) -> frozenset[int]:
        each = (self.limbs[path].machine.awaits(tended.state) for path, tended in state.leaves.items())
        return frozenset[int]().union(*each)

    def shifted(self, state: Tending, by_s: float) -> Tending:
        leaves = {
            path: Tended(self.limbs[path].machine.shifted(tended.state, by_s), tended.deadline + by_s)
            for path, tended in state.leaves.items()
        }
        return Tending(self._shift(state.tree, by_s), leaves, state.wake + by_s)

    def _shift(self, tree: TreeState, by_s: float) -> TreeState:
        shift: Callable[[TreeState, float], TreeState] | None = getattr(self.ticker, "shifted", None)
        return shift(tree, by_s) if shift is not None else tree
