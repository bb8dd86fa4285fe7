# SPDX-License-Identifier: Apache-2.0
"""The machine of a tree: ticks it, starts and ends its leaves with the machines that the states of the same words use.

Rule: what a tick ends has ended before what it starts is started. A tree is ticked again in the same step only for a
reason that `Rounds` has room for; without room it rests, and never fails for it.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import Any, Literal, NamedTuple

from rai_missions.engine.activities.action import GoalActivity
from rai_missions.engine.activities.activity import (
    NO_KEYS,
    ActivityHost,
    Bench,
    Machine,
    Outcome,
    Turn,
    machine_of,
    remembered,
    watches,
)
from rai_missions.engine.activities.decision import DecisionActivity
from rai_missions.engine.activities.ticker import Ticker, TickResult, TreeState
from rai_missions.engine.activities.tree_rounds import Rounds
from rai_missions.engine.decision import Question, VerdictNote
from rai_missions.engine.step import Effect, PublishMessage
from rai_missions.engine.templates import unpublished
from rai_missions.event import Event
from rai_missions.guards.view import View
from rai_missions.states.state import State

__all__ = (
    "LeafMachine", "RunningLeaf", "TreeActivity", "TreeMachine", "acted", "is_settling", "limit_of", "questions_in",
)  # fmt: skip

Limit = Literal["", "rounds", "writes"]
NO_OUTCOMES: Mapping[str, str] = {}
_new = tuple.__new__


def acted(ticked: TickResult) -> bool:
    """Whether a tick has ended its tree, or did more than to have its nodes remember something else."""
    _, status, started, ended, writes, published, _, begun, rounds, _ = ticked
    return status != "running" or bool(started or ended or writes or published or begun or rounds)


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
        for leaf in state.leaves.values():
            yield from questions_in(leaf.state)


def is_settling(state: Any) -> bool:
    """Whether a machine in this state, a tree's leaves included, waits for facts that confirm a server's result."""
    if isinstance(state, TreeActivity):
        return any(is_settling(leaf.state) for leaf in state.leaves.values())
    return isinstance(state, GoalActivity) and state.phase == "settling"


class _TurnDraft:
    """What a turn is gathering."""

    __slots__ = ("changed", "effects", "has_written", "leaves", "limit", "news", "notes", "outcomes", "tree", "wake")

    def __init__(self, state: TreeActivity) -> None:
        self.tree, self.leaves, self.wake, self.limit = state.tree, dict(state.leaves), state.wake, state.limit
        self.effects: list[Effect] = []
        self.notes: list[str | VerdictNote] = []
        self.outcomes: dict[str, str] = {}
        self.has_written = False
        self.news: set[str] = set()
        """Keys to which the tree has given another value since its last tick began."""
        self.changed: AbstractSet[str] | None = NO_KEYS
        """All else that is another than at the last tick; None where some of it may have been missed."""

    def write(self, host: ActivityHost, writes: Iterable[tuple[str, Any]], owner: str) -> None:
        for key, value in writes:
            self.has_written = True
            if host.write_key(key, value, owner):
                self.news.add(key)

    def turn(self, outcome: Outcome | None) -> Turn:
        state = None if outcome is not None else TreeActivity(self.tree, self.leaves, self.wake, self.limit)
        return Turn(state, tuple(self.effects), outcome, notes=tuple(self.notes))


class TreeMachine(Machine):
    """Runs one tree.

    Args:
        ticker: The tree, compiled.
        leaf_machines: Path → the leaf that runs there when a tick asks for it.
        owner: The state.
    """

    def __init__(self, ticker: Ticker, leaf_machines: Mapping[str, LeafMachine], owner: str) -> None:
        self.ticker, self.leaf_machines, self.owner = ticker, leaf_machines, owner

    def begin(self, host: ActivityHost) -> Turn:
        return self._tick(_TurnDraft(TreeActivity()), host)

    def receive(self, state: TreeActivity, event: Event, host: ActivityHost) -> Turn | None:
        draft, concerned = _TurnDraft(state), False
        if state.limit or (event.kind == "tick" and event.data.get("unseen")):
            draft.changed = None
        elif event.kind == "tick":
            draft.changed = event.data["news"]
        for path, leaf in state.leaves.items():
            turn = self._leaf(path, leaf, event, host)
            if turn is not None:
                concerned = True
                self._take(draft, path, turn, leaf.deadline, host)
        if state.limit == "rounds" and self._rounds(host).are_spent:
            turn = self._rest(draft, host)
        elif draft.outcomes or self._is_due(state, event, host):
            turn = self._tick(draft, host)
        elif event.kind == "tick" and self.ticker.watches(state.tree, keys := event.data["keys"]):
            news = event.data["news"]
            if news is keys or self.ticker.watches(state.tree, news):
                turn = self._look(draft, host)
            else:  # the same value, and it grows stale later
                draft.wake = self.ticker.wake_at(draft.tree, host.view)
                turn = draft.turn(None)
        else:
            return draft.turn(None) if concerned else None
        return turn if concerned or self._is_another(turn, draft, state) else None

    def is_for_tree(self, state: TreeActivity, key: str) -> bool:
        """Whether a key that was written concerns the tree alone, and no leaf that runs."""
        return not (state.limit or self._leaf_watches(state, (key,)))

    def look(self, state: TreeActivity, key: str, view: View, late_s: float) -> TickResult:
        """The tick with which `receive` begins where a key that is for the tree alone has another value."""
        return self.ticker.tick(state.tree, view, NO_OUTCOMES, late_s, (key,))

    def rest(self, state: TreeActivity, ticked: TickResult, view: View) -> TreeActivity:
        """What it remembers after such a tick that has not `acted`."""
        tree, wake = ticked.state, self.ticker.wake_at(ticked.state, view)
        if wake == state.wake and (tree is state.tree or tree == state.tree):
            return state
        return _new(TreeActivity, (tree, state.leaves, wake, ""))

    def follow(self, state: TreeActivity, ticked: TickResult, host: ActivityHost) -> Turn | None:
        """What `receive` returns after such a tick."""
        draft = _TurnDraft(state)
        self._rounds(host).was_written()
        turn = self._tick(draft, host, ticked)
        return turn if self._is_another(turn, draft, state) else None

    @staticmethod
    def _is_due(state: TreeActivity, event: Event, host: ActivityHost) -> bool:
        """Whether the tree's own time has come, or that of the rounds that had no room in the step before."""
        return event.kind == "tick" and (host.view.at >= state.wake or state.limit == "rounds")

    def _look(self, draft: _TurnDraft, host: ActivityHost) -> Turn:
        """A key at which the next tick may look has another value."""
        if self._rounds(host).was_written():
            return self._tick(draft, host)
        draft.limit = "writes"
        return draft.turn(None)

    def _rounds(self, host: ActivityHost) -> Rounds:
        return host.rounds(self.owner, self.ticker.loops)

    @staticmethod
    def _is_another(turn: Turn, draft: _TurnDraft, before: TreeActivity) -> bool:
        return draft.has_written or bool(turn.effects or turn.outcome or turn.notes) or turn.state != before

    def _leaf(self, path: str, leaf: RunningLeaf, event: Event, host: ActivityHost) -> Turn | None:
        leaf_machine = self.leaf_machines[path]
        if event.kind == "tick" and host.view.at >= leaf.deadline:
            left = leaf_machine.machine.leave(leaf.state, host)
            return left._replace(outcome=Outcome("timed_out"))
        return leaf_machine.machine.receive(leaf.state, event, host)

    def _take(self, draft: _TurnDraft, path: str, turn: Turn, deadline: float, host: ActivityHost) -> None:
        draft.effects += turn.effects
        draft.notes += turn.notes
        draft.write(host, turn.writes, self.owner)
        if turn.outcome is None:
            draft.leaves[path] = RunningLeaf(turn.state, deadline)
            return
        draft.leaves.pop(path, None)
        draft.outcomes[path] = turn.outcome.name
        if turn.outcome.why:
            draft.notes.append(f"{self.owner}#{path} {turn.outcome.name}: {turn.outcome.why}")

    def _tick(self, draft: _TurnDraft, host: ActivityHost, ticked: TickResult | None = None) -> Turn:
        """Tick, unless it was done already, and at once again while there is a reason, and room for it."""
        draft.limit = ""
        while True:
            if ticked is None:
                changed = draft.changed
                if draft.news:
                    changed = changed | draft.news if changed is not None else None
                    draft.news = set()
                late_s = host.begins_at - host.view.at
                ticked = self.ticker.tick(draft.tree, host.view, draft.outcomes, late_s, changed)
            draft.outcomes, draft.changed = {}, NO_KEYS
            self._apply(draft, ticked, host)
            if ticked.status in ("success", "failure"):
                self._end(draft, draft.leaves, host)
                return draft.turn(Outcome("succeeded" if ticked.status == "success" else "failed"))
            if not self._again(draft, ticked, host):
                return self._rest(draft, host)
            ticked = None

    def _again(self, draft: _TurnDraft, ticked: TickResult, host: ActivityHost) -> bool:
        """Whether the next tick is due in this step.

        It is where a loop begins its next round, a leaf has ended as soon as it was started, or the tree has given
        another value to a key that it looks at.
        """
        if not (ticked.rounds or ticked.begun or draft.outcomes or draft.news):
            return False
        rounds = self._rounds(host)
        if rounds.next_begins(ticked):
            draft.limit = "rounds" if rounds.are_spent else ""
            return not draft.limit
        if draft.outcomes:
            has_room = rounds.leaf_ended()
        elif draft.news and self.ticker.watches(draft.tree, draft.news):
            has_room = rounds.wrote()
        else:
            return False
        draft.limit = "" if has_room else "writes"
        return has_room

    def _rest(self, draft: _TurnDraft, host: ActivityHost) -> Turn:
        if draft.outcomes:  # the next tick takes them
            ends = {path: draft.tree.leaves[path]._replace(outcome=end) for path, end in draft.outcomes.items()}
            draft.tree = draft.tree._replace(leaves={**draft.tree.leaves, **ends})
        draft.wake = self.ticker.wake_at(draft.tree, host.view)
        return draft.turn(None)

    def _apply(self, draft: _TurnDraft, ticked: TickResult, host: ActivityHost) -> None:
        draft.tree = ticked.state
        if ticked.writes:
            draft.write(host, ticked.writes, self.owner)
        for topic, (fields, lack) in ticked.published:
            if lack:
                draft.notes.append(unpublished(topic, lack))
            else:
                draft.effects.append(PublishMessage(topic, fields))
        if ticked.ended:
            self._end(draft, ticked.ended, host)
        for path in ticked.started:
            leaf_machine = self.leaf_machines[path]
            deadline = host.begins_at + leaf_machine.timeout_s if leaf_machine.timeout_s is not None else math.inf
            self._take(draft, path, leaf_machine.machine.begin(host), deadline, host)

    def _end(self, draft: _TurnDraft, paths: Iterable[str], host: ActivityHost) -> None:
        for path in list(paths):
            leaf = draft.leaves.pop(path, None)
            if leaf is not None:
                draft.effects += self.leaf_machines[path].machine.leave(leaf.state, host).effects

    def leave(self, state: TreeActivity, host: ActivityHost) -> Turn:
        draft = _TurnDraft(state)
        self.ticker.stop(state.tree, host.view)
        self._end(draft, state.leaves, host)
        return draft.turn(None)._replace(state=None)

    def wake_at(self, state: TreeActivity, view: View) -> float:
        soonest = state.wake
        for path, leaf in state.leaves.items():
            soonest = min(soonest, leaf.deadline, self.leaf_machines[path].machine.wake_at(leaf.state, view))
        return soonest

    def reads(self, state: TreeActivity) -> frozenset[str]:
        each = (self.leaf_machines[path].machine.reads(leaf.state) for path, leaf in state.leaves.items())
        return self.ticker.reads(state.tree).union(*each)

    def watches(self, state: TreeActivity, names: Collection[str]) -> bool:
        return self.ticker.watches(state.tree, names) or self._leaf_watches(state, names)

    def _leaf_watches(self, state: TreeActivity, names: Collection[str]) -> bool:
        machines = self.leaf_machines
        for path, leaf in state.leaves.items():
            machine = machines[path].machine
            if machine.reads(leaf.state) and watches(machine, leaf.state, names):
                return True
        return False

    def awaits(self, state: TreeActivity) -> frozenset[int]:
        each = (self.leaf_machines[path].machine.awaits(leaf.state) for path, leaf in state.leaves.items())
        return frozenset[int]().union(*each)

    def shift(self, state: TreeActivity, by_s: float) -> TreeActivity:
        leaves = {
            path: RunningLeaf(self.leaf_machines[path].machine.shift(leaf.state, by_s), leaf.deadline + by_s)
            for path, leaf in state.leaves.items()
        }
        return TreeActivity(self.ticker.shift(state.tree, by_s), leaves, state.wake + by_s, state.limit)


@machine_of.register
def _(state: State, bench: Bench) -> Machine | None:
    root = state.root()
    if root is None:
        made: Machine | None = state.machine(bench)
        return made
    name, place = bench.owner, f"{bench.place}{state.within('')}"
    leaf_machines: dict[str, LeafMachine] = {}
    for path, node in root.paths():
        machine = machine_of(node, bench._replace(owner=f"{name}#{path}", place=f"{place}/{path}".rstrip("/")))
        if machine is not None:
            leaf_machines[path] = LeafMachine(machine, getattr(node, "timeout_s", None))
    return TreeMachine(bench.trees.compile(root, place, bench.keys, name), leaf_machines, name)
