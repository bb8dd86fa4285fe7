# SPDX-License-Identifier: Apache-2.0
"""One compiled tree: restored from its state, ticked where something can change, and read back.

Rule: the live nodes are only where a tick is worked out; all that they remember is in the `TreeState`.
"""

from __future__ import annotations

import math
from collections.abc import Collection, Iterable, Mapping
from typing import Any

from rai_missions.engine.activities.ticker import Leaf, LoopRound, TickResult, TreeState
from rai_missions.engine.trees.build import live_nodes
from rai_missions.engine.trees.leaves import CompiledActivity
from rai_missions.engine.trees.memories import PART, NodeMemories, Paths
from rai_missions.engine.trees.node import INVALID, PLAIN, RUNNING, CompiledNode
from rai_missions.engine.trees.sites import TreePlace, shifted
from rai_missions.engine.trees.tick import Tick, TickView
from rai_missions.guards.guard import Site, View, concerns
from rai_missions.keys import Key
from rai_missions.states.tree import TreeNode

__all__ = ("CompiledTicker",)

NOTHING: Mapping[str, Any] = {}


class CompiledTicker:
    """Ticks one tree. Two of them share nothing, and a state may be given to any that was compiled for the same tree.

    Args:
        root: The tree.
        place: Its JSON pointer in the mission.
        keys: The mission's keys.
        state: The state that runs it.
    """

    def __init__(self, root: TreeNode, place: str, keys: Mapping[str, Key], state: str) -> None:
        self.state = state
        self.nodes = live_nodes(root, TreePlace(place, keys, state))
        self.root: Any = self.nodes[0]
        self.paths = Paths(tuple(node.path for node in self.nodes))
        sites = [(node, node.site) for node in self.nodes if node.site is not None]
        self.dependents = _dependents(sites)
        """Key, or presence of a state → the nodes that look at it."""
        self.timed: tuple[Any, ...] = tuple(node for node, site in sites if site.instants)
        self.holds = {name: test for _, site in sites for name, test in site.holds.items()}
        self.held_by = frozenset[str]().union(*(site.watched for _, site in sites if site.holds))
        """What the guards change by whose duration is counted, whether the next tick looks at them or not."""
        self.loops = sum(len(node.children) for node in self.nodes if node.loops)
        self.round = Tick(self._wake)
        self.awaited: dict[int, Any] = {}
        """The leaves that the chart runs, by number."""
        self.waiting: dict[int, Any] = {}
        """The nodes that have a deadline, by number."""
        self.shown = TreeState()
        """The state in which the nodes are."""
        self.own_keys = {name for node in self.nodes for name in node.writes}
        self._written: Collection[str] = ()
        """What the last tick has written; the mission may have refused it."""
        self._calm: tuple[TreeState | None, float] = (None, 0.0)
        """A state, and until when no guard that is looked at in it changes by time alone."""
        self._parts: list[list[Any]] = [
            [None] * len(self.nodes[at : at + PART]) for at in range(0, len(self.nodes), PART)
        ]

    # -- ticked -------------------------------------------------------------------------------------------------------

    def tick(
        self, state: TreeState, view: View, outcomes: Mapping[str, str], late_s: float = 0.0,
        changed: Collection[str] | None = None,
    ) -> TickResult:  # fmt: skip
        """Tick once; see `Ticker`."""
        sight, ends = self._restore(state, view), outcomes
        sight.late_s = late_s
        if changed is None:
            self._doubt_all()
        else:
            self._wake_all(changed, sight.at)
        if state.leaves:
            pending = _pending(state)
            ends = {**pending, **outcomes} if pending else outcomes
            for path in ends:
                self.nodes[self.paths.numbers[path]].wake()
        for node in self.waiting.values():
            if sight.at >= node.deadline():
                node.wake()
        self.round.begin(sight, ends)
        if not self.root.idle:
            self.root.tick(self.round)
        return self._ticked(state, sight)

    def stop(self, state: TreeState, view: View) -> TickResult:
        """End whatever runs; see `Ticker`."""
        sight = self._restore(state, view)
        self.round.begin(sight, _pending(state))
        self.root.stop(self.round)
        return self._ticked(state, sight)

    def _wake(self, key: str) -> None:
        for node in self.dependents.get(key, ()):
            node.wake()
        if not key.startswith("#"):
            for node in self.dependents.get("*", ()):
                node.wake()

    def _doubt_all(self) -> None:
        for node in self.nodes:
            node.idle = False
            node.todo = -1

    def _wake_all(self, changed: Iterable[str], at: float) -> None:
        for key in changed:
            self._wake(key)
        for key in self._written:
            self._wake(key)
        state, due = self._calm
        if state is not self.shown or at >= due:
            for node in self.timed:
                node.wake()

    # -- remembered ---------------------------------------------------------------------------------------------------

    def _restore(self, state: TreeState, view: View) -> TickView:
        self._recall(state)
        root = self.root.shown or NOTHING
        sight = TickView(view, self.state, root.get("began", view.at), root.get("held", NOTHING))
        return self._hold(sight) if self.holds else sight

    def _hold(self, sight: TickView) -> TickView:
        """Note since when the inner guards of `held` have been true, whether the next tick looks at them or not."""
        held = dict(sight.held)
        sight.held = held
        for name, test in self.holds.items():
            if test(sight) is True:
                held.setdefault(name, sight.at)
            else:
                held.pop(name, None)
        return sight

    def _recall(self, state: TreeState) -> None:
        """Be in a state; only what differs from the one before is touched."""
        if state is self.shown:
            return
        if state.nodes is not self.shown.nodes:
            if isinstance(state.nodes, NodeMemories) and state.nodes.paths is self.paths:
                self._recall_parts(state.nodes.parts)
            else:
                self._recall_all(state.nodes)
        for path, leaf in state.leaves.items():
            node: Any = self.nodes[self.paths.numbers[path]]
            if isinstance(node, CompiledActivity):
                node.refused = leaf.outcome == "rejected"
        self.shown, self._written = state, self.own_keys

    def _recall_parts(self, parts: list[list[Any]]) -> None:
        for at, (part, own) in enumerate(zip(parts, self._parts, strict=True)):
            if part is own:
                continue
            for place, memory in enumerate(part):
                if memory is not own[place]:
                    self._recall_node(self.nodes[at * PART + place], memory)
        self._parts = parts
        for node in self.timed:
            node.wake()

    def _recall_all(self, memories: Mapping[str, Any]) -> None:
        for node in self.nodes:
            self._recall_node(node, memories.get(node.path))
        shown = [node.shown for node in self.nodes]
        self._parts = [shown[at : at + PART] for at in range(0, len(shown), PART)]
        self._doubt_all()

    def _recall_node(self, node: CompiledNode, memory: Mapping[str, Any] | None) -> None:
        node.recall(memory if memory is not None else NOTHING)
        node.shown = memory
        node.idle = True  # so that all above it are woken as well
        node.wake()
        node.todo = -1
        if node.role:
            self._note(node)

    def _note(self, node: Any) -> None:
        """Keep the leaves that the chart runs, and what has a deadline, up to date."""
        if node.role == "activity":
            if node.awaited:
                self.awaited[node.number] = node
            else:
                self.awaited.pop(node.number, None)
        elif node.status is RUNNING:
            self.waiting[node.number] = node
        else:
            self.waiting.pop(node.number, None)

    def _ticked(self, before: TreeState, sight: TickView) -> TickResult:
        done = self.round
        if done.writes and self.holds:
            sight = self._hold(sight)
        self._written = [key for key, _ in done.writes]
        self.shown = self._remembered(before, sight)
        begun: tuple[str, ...] = ()
        rounds: tuple[LoopRound, ...] = ()
        if done.turned or done.turning:
            rounds = tuple([
                LoopRound(child.path, loop.counted, at_once, loop.status is RUNNING)
                for loop, child, at_once in done.turned
            ])  # fmt: skip
            begun = tuple([child.path for child in done.turning if child.status is RUNNING])
        waits = tuple([node.path for node in done.waits if node.status is RUNNING]) if done.waits else ()
        return TickResult(
            self.shown, self.root.status, tuple(done.started), tuple(done.ended), tuple(done.writes),
            tuple(done.published), (), begun, rounds, waits,
        )  # fmt: skip

    def _remembered(self, before: TreeState, sight: TickView) -> TreeState:
        """The state after a tick; it shares with the one before what is the same."""
        has_run, parts, copied, touched = False, self._parts, set[int](), self.round.touched
        if self.holds or self.root.shown is None:
            touched.append(self.root)
        for node in touched:
            if node.role:
                self._note(node)
                has_run = has_run or node.role == "activity"
            memory = node.memory()
            if node is self.root:
                memory = _with_began(memory, sight)
            if memory is node.shown or memory == node.shown:
                continue
            node.shown, (at, place) = memory, divmod(node.number, PART)
            if at not in copied:
                parts = list(parts) if not copied else parts
                parts[at] = list(parts[at])
                copied.add(at)
            parts[at][place] = memory
        leaves = before.leaves
        if has_run or (before.leaves and _pending(before)):
            leaves = {self.nodes[number].path: Leaf(self.awaited[number].run) for number in sorted(self.awaited)}
        if not copied and leaves is before.leaves and isinstance(before.nodes, NodeMemories):
            return before
        self._parts = parts
        return TreeState(NodeMemories(self.paths, parts), leaves)

    def shift(self, state: TreeState, by_s: float) -> TreeState:
        """The state as it would be had everything happened so much later; see `Ticker`."""
        return shifted(state, by_s)

    # -- what comes next ----------------------------------------------------------------------------------------------

    def wake_at(self, state: TreeState, view: View) -> float:
        """The next deadline of what runs, or instant at which a guard's facts grow old; see `Ticker`."""
        sight = self._restore(state, view)
        soonest, now = math.inf, sight.at
        for node in self.waiting.values():
            if now < (due := node.deadline()) < soonest:
                soonest = due
        next_due = math.inf
        for node in self.timed:
            for instant in node.site.instants:
                if now < (due := instant(sight)) < next_due and (node.site.holds or (node.looks and node.is_seen())):
                    next_due = due
        self._calm = (state, next_due)
        return min(soonest, next_due)

    def reads(self, state: TreeState) -> frozenset[str]:
        """What wants a tick once it is another; see `Ticker`."""
        self._recall(state)
        seen, rest = set(self.held_by), [self.root]
        while rest:
            node = rest.pop()
            rest += [child for child in node.children if node.sees(child)]
            if node.site is not None and node.looks:
                seen |= node.site.watched
        return frozenset(seen)

    def listens(self, state: TreeState, names: Collection[str]) -> bool:
        """Whether a change of one of these wants a tick; see `Ticker`."""
        self._recall(state)
        if self.held_by and concerns(self.held_by, names):
            return True
        looking = [node for name in names for node in self.dependents.get(name, ())]
        if "*" in self.dependents and any(not name.startswith("#") for name in names):
            looking += self.dependents["*"]
        return any(node.looks and node.is_seen() for node in looking)


def _with_began(memory: Mapping[str, Any] | None, sight: TickView) -> Mapping[str, Any]:
    """What a root remembers."""
    held = {"held": dict(sight.held)} if sight.held else {}
    return {**(memory or PLAIN[INVALID]), "began": sight.began, **held}


def _pending(state: TreeState) -> Mapping[str, str]:
    return {path: leaf.outcome for path, leaf in state.leaves.items() if leaf.outcome} if state.leaves else NOTHING


def _dependents(sites: Iterable[tuple[CompiledNode, Site]]) -> Mapping[str, tuple[CompiledNode, ...]]:
    found: dict[str, list[CompiledNode]] = {}
    for node, site in sites:
        for name in site.watched:
            found.setdefault(name, []).append(node)
    return {name: tuple(nodes) for name, nodes in found.items()}
