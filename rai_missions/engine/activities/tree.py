# SPDX-License-Identifier: Apache-2.0
"""The machine of a tree: ticks it, starts and ends its leaves with the machines that the states of the same words use.

Rule: what a tick ends has ended before what it starts is started. A tree is ticked again in the same step only for a
reason that `Rounds` has room for; without room it rests, and never fails for it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, Literal, NamedTuple

from rai_missions.engine.activities.action import GoalActivity
from rai_missions.engine.activities.activity import (
    ActivityHost,
    Bench,
    Machine,
    Outcome,
    Turn,
    concerns,
    machine_of,
    remembered,
)
from rai_missions.engine.activities.decision import DecisionActivity
from rai_missions.engine.activities.ticker import Ticked, Ticker, TreeState
from rai_missions.engine.activities.tree_rounds import Rounds
from rai_missions.engine.decision import Question, VerdictNote
from rai_missions.engine.step import Effect, PublishMessage
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.guards.guard import View
from rai_missions.states.state import State

__all__ = ("LeafMachine", "RunningLeaf", "TreeActivity", "TreeMachine", "is_settling", "limit_of", "questions_in")

Limit = Literal["", "rounds", "writes"]


class LeafMachine(NamedTuple):
    """A leaf that the chart can run."""

    machine: Machine
    timeout_s: float | None


@remembered("Tended")
class RunningLeaf(NamedTuple):
    """A leaf that runs."""

    state: Any
    deadline: float


@remembered("Tending")
class TreeActivity(NamedTuple):
    """How far a tree has come."""

    tree: TreeState = TreeState()
    leaves: Mapping[str, RunningLeaf] = {}
    """Path → the leaf that runs there."""
    wake: float = math.inf
    """When the tree itself wants its next tick, if nothing that it reads changes before."""
    limit: Limit = ""
    """The limit at which it rests though it would be ticked again: of `rounds`, which continue in the next step at the
    same instant, or of `writes`, after which it waits for the next event that concerns it."""


def limit_of(state: Any) -> Limit:
    """The limit at which a machine rests in this state; empty for none."""
    return state.limit if isinstance(state, TreeActivity) else ""


def questions_in(state: Any) -> Iterator[Question]:
    """What is asked by a machine in this state, a tree's leaves included."""
    if isinstance(state, DecisionActivity):
        yield state.question
    elif isinstance(state, TreeActivity):
        for tended in state.leaves.values():
            yield from questions_in(tended.state)


def is_settling(state: Any) -> bool:
    """Whether a machine in this state, a tree's leaves included, waits for facts that confirm a server's result."""
    if isinstance(state, TreeActivity):
        return any(is_settling(tended.state) for tended in state.leaves.values())
    return isinstance(state, GoalActivity) and state.phase == "settling"


class _Growth:
    """What a turn is gathering."""

    def __init__(self, state: TreeActivity) -> None:
        self.tree, self.leaves, self.wake, self.limit = state.tree, dict(state.leaves), state.wake, state.limit
        self.effects: list[Effect] = []
        self.notes: list[str | VerdictNote] = []
        self.outcomes: dict[str, str] = {}
        self.has_written = False
        self.news: set[str] = set()
        """Keys to which the tree has given another value since its last tick began."""

    def write(self, desk: ActivityHost, writes: Iterable[tuple[str, Any]], owner: str) -> None:
        for key, value in writes:
            self.has_written = True
            if desk.write_key(key, value, owner):
                self.news.add(key)

    def turn(self, outcome: Outcome | None) -> Turn:
        state = None if outcome is not None else TreeActivity(self.tree, self.leaves, self.wake, self.limit)
        return Turn(state, tuple(self.effects), outcome, notes=tuple(self.notes))


class TreeMachine(Machine):
    """Runs one tree.

    Args:
        ticker: The tree, compiled.
        limbs: Path → the leaf that runs there when a tick asks for it.
        owner: The state.
    """

    def __init__(self, ticker: Ticker, limbs: Mapping[str, LeafMachine], owner: str) -> None:
        self.ticker, self.limbs, self.owner = ticker, limbs, owner

    def begin(self, desk: ActivityHost) -> Turn:
        return self._tick(_Growth(TreeActivity()), desk)

    def receive(self, state: TreeActivity, event: Event, desk: ActivityHost) -> Turn | None:
        growth, concerned = _Growth(state), False
        for path, tended in state.leaves.items():
            turn = self._leaf(path, tended, event, desk)
            if turn is not None:
                concerned = True
                self._take(growth, path, turn, tended.deadline, desk)
        if state.limit == "rounds" and self._rounds(desk).are_spent:
            turn = self._rest(growth, desk)
        elif growth.outcomes or self._is_due(state, event, desk):
            turn = self._tick(growth, desk)
        elif event.kind == "tick" and concerns(reads := self.ticker.reads(state.tree), event.data["keys"]):
            if concerns(reads, event.data["news"]):
                turn = self._look(growth, desk)
            else:  # the same value, and it grows stale later
                growth.wake = self.ticker.wake_at(growth.tree, desk.view)
                turn = growth.turn(None)
        else:
            return growth.turn(None) if concerned else None
        return turn if concerned or self._is_another(turn, growth, state) else None

    @staticmethod
    def _is_due(state: TreeActivity, event: Event, desk: ActivityHost) -> bool:
        """Whether the tree's own time has come, or that of the rounds that had no room in the step before."""
        return event.kind == "tick" and (desk.view.at >= state.wake or state.limit == "rounds")

    def _look(self, growth: _Growth, desk: ActivityHost) -> Turn:
        """A key at which the next tick may look has another value."""
        if self._rounds(desk).was_written():
            return self._tick(growth, desk)
        growth.limit = "writes"
        return growth.turn(None)

    def _rounds(self, desk: ActivityHost) -> Rounds:
        return desk.rounds(self.owner, self.ticker.loops)

    @staticmethod
    def _is_another(turn: Turn, growth: _Growth, before: TreeActivity) -> bool:
        return growth.has_written or bool(turn.effects or turn.outcome or turn.notes) or turn.state != before

    def _leaf(self, path: str, tended: RunningLeaf, event: Event, desk: ActivityHost) -> Turn | None:
        limb = self.limbs[path]
        if event.kind == "tick" and desk.view.at >= tended.deadline:
            left = limb.machine.leave(tended.state, desk)
            return left._replace(outcome=Outcome("timed_out"))
        return limb.machine.receive(tended.state, event, desk)

    def _take(self, growth: _Growth, path: str, turn: Turn, deadline: float, desk: ActivityHost) -> None:
        growth.effects += turn.effects
        growth.notes += turn.notes
        growth.write(desk, turn.writes, self.owner)
        if turn.outcome is None:
            growth.leaves[path] = RunningLeaf(turn.state, deadline)
            return
        growth.leaves.pop(path, None)
        growth.outcomes[path] = turn.outcome.name
        if turn.outcome.why:
            growth.notes.append(f"{self.owner}#{path} {turn.outcome.name}: {turn.outcome.why}")

    def _tick(self, growth: _Growth, desk: ActivityHost) -> Turn:
        """Tick, and at once again while there is a reason, and room for it."""
        growth.limit = ""
        while True:
            growth.news.clear()
            ticked = self.ticker.tick(growth.tree, desk.view, growth.outcomes, desk.begins_at - desk.view.at)
            growth.outcomes = {}
            self._apply(growth, ticked, desk)
            if ticked.status in ("success", "failure"):
                self._end(growth, growth.leaves, desk)
                return growth.turn(Outcome("succeeded" if ticked.status == "success" else "failed"))
            if not self._again(growth, ticked, self._rounds(desk)):
                return self._rest(growth, desk)

    def _again(self, growth: _Growth, ticked: Ticked, rounds: Rounds) -> bool:
        """Whether the next tick is due in this step.

        It is where a loop begins its next round, a leaf has ended as soon as it was started, or the tree has given
        another value to a key that it looks at.
        """
        if rounds.next_begins(ticked):
            growth.limit = "rounds" if rounds.are_spent else ""
            return not growth.limit
        if growth.outcomes:
            has_room = rounds.leaf_ended()
        elif growth.news and concerns(self.ticker.reads(growth.tree), frozenset(growth.news)):
            has_room = rounds.wrote()
        else:
            return False
        growth.limit = "" if has_room else "writes"
        return has_room

    def _rest(self, growth: _Growth, desk: ActivityHost) -> Turn:
        if growth.outcomes:  # the next tick takes them
            ends = {path: growth.tree.leaves[path]._replace(outcome=end) for path, end in growth.outcomes.items()}
            growth.tree = growth.tree._replace(leaves={**growth.tree.leaves, **ends})
        growth.wake = self.ticker.wake_at(growth.tree, desk.view)
        return growth.turn(None)

    def _apply(self, growth: _Growth, ticked: Ticked, desk: ActivityHost) -> None:
        growth.tree = ticked.state
        growth.write(desk, ticked.writes, self.owner)
        growth.effects += [PublishMessage(topic, message) for topic, message in ticked.published]
        self._end(growth, ticked.ended, desk)
        for path in ticked.started:
            limb = self.limbs[path]
            deadline = desk.begins_at + limb.timeout_s if limb.timeout_s is not None else math.inf
            self._take(growth, path, limb.machine.begin(desk), deadline, desk)

    def _end(self, growth: _Growth, paths: Iterable[str], desk: ActivityHost) -> None:
        for path in list(paths):
            tended = growth.leaves.pop(path, None)
            if tended is not None:
                growth.effects += self.limbs[path].machine.leave(tended.state, desk).effects

    def leave(self, state: TreeActivity, desk: ActivityHost) -> Turn:
        growth = _Growth(state)
        self.ticker.stop(state.tree, desk.view)
        self._end(growth, state.leaves, desk)
        return growth.turn(None)._replace(state=None)

    def wake_at(self, state: TreeActivity, view: View) -> float:
        leaves = (
            min(tended.deadline, self.limbs[path].machine.wake_at(tended.state, view))
            for path, tended in state.leaves.items()
        )
        return min([state.wake, *leaves])

    def reads(self, state: TreeActivity) -> frozenset[str]:
        each = (self.limbs[path].machine.reads(tended.state) for path, tended in state.leaves.items())
        return self.ticker.reads(state.tree).union(*each)

    def awaits(self, state: TreeActivity) -> frozenset[int]:
        each = (self.limbs[path].machine.awaits(tended.state) for path, tended in state.leaves.items())
        return frozenset[int]().union(*each)

    def shifted(self, state: TreeActivity, by_s: float) -> TreeActivity:
        leaves = {
            path: RunningLeaf(self.limbs[path].machine.shifted(tended.state, by_s), tended.deadline + by_s)
            for path, tended in state.leaves.items()
        }
        return TreeActivity(self._shift(state.tree, by_s), leaves, state.wake + by_s, state.limit)

    def _shift(self, tree: TreeState, by_s: float) -> TreeState:
        shift: Callable[[TreeState, float], TreeState] | None = getattr(self.ticker, "shifted", None)
        return shift(tree, by_s) if shift is not None else tree


@machine_of.register
def _(state: State, bench: Bench) -> Machine | None:
    root = state.root()
    if root is None:
        made: Machine | None = state.machine(bench)
        return made
    name, place = bench.owner, f"{bench.place}{state.within('')}"
    if bench.trees is None:
        raise UsageError(f"state '{name}' runs a tree; give the chart a ticker: Chart(mission, ticker=PyTrees())")
    limbs: dict[str, LeafMachine] = {}
    for path, node in root.paths():
        machine = machine_of(node, bench._replace(owner=f"{name}#{path}", place=f"{place}/{path}".rstrip("/")))
        if machine is not None:
            limbs[path] = LeafMachine(machine, getattr(node, "timeout_s", None))
    return TreeMachine(bench.trees.compile(root, place, bench.keys, name), limbs, name)
