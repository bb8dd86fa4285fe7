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
from rai_missions.guards.view import Site, View, concerns
from rai_missions.keys import Key
from rai_missions.states.tree import TreeNode

__all__ = ("CompiledTicker",)

NOTHING: Mapping[str, Any] = {}
_new = tuple.__new__


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
        self._of_any = self.dependents.get("*", ())
        """The nodes that look at any key."""
        self.timed: tuple[Any, ...] = tuple(node for node, site in sites if site.instants)
        self.held_guards = {name: test for _, site in sites for name, test in site.held_guards.items()}
        self.held_reads = frozenset[str]().union(*(site.watched for _, site in sites if site.held_guards))
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
        self.is_plain = not (self.held_guards or self.own_keys or any(site.clocked for _, site in sites))
        """What is known is seen as it is: the tree writes nothing, and counts no time from its own beginning."""
        self._pending: Mapping[str, str] = NOTHING
        """The outcomes that the state in which the nodes are has for its leaves."""
        self._is_over = False
        """A tick was worked out since `round` was cleared."""
        self._still = TickResult(self.shown, INVALID)
        """What a tick of its state did that did nothing."""
        self._written: Collection[str] = ()
        """What the last tick has written; the mission may have refused it."""
        self._wanted: dict[str, bool] = {}
        """Names that were asked for → whether a change of one wants a tick, in `_asked_in`."""
        self._asked_in: TreeState | None = None
        self._calm: tuple[TreeState | None, float] = (None, 0.0)
        """A state, and until when no guard that is looked at in it changes by time alone."""
        self._parts: list[list[Any]] = [
            [None] * len(self.nodes[at : at + PART]) for at in range(0, len(self.nodes), PART)
        ]

    # -- ticked -------------------------------------------------------------------------------------------------------

    def tick(
        self,
        state: TreeState,
        view: View,
        outcomes: Mapping[str, str],
        late_s: float = 0.0,
        changed: Collection[str] | None = None,
    ) -> TickResult:
        """Tick once; see `Ticker`."""
        if state is not self.shown:
            self._recall(state)
        ends, done, root = outcomes, self.round, self.root
        if changed is None:
            root.doubt()
        else:
            self._wake_all(changed, view.at)
        if self._pending:
            ends = {**self._pending, **outcomes}
        if ends:
            for path in ends:
                self.nodes[self.paths.numbers[path]].wake()
        for node in self.waiting.values():
            if view.at >= node.deadline():
                node.wake()
        if self._is_over:
            done.clear()
            self._is_over = False
        done.look(view if self.is_plain else self._sight(view), ends, late_s)
        if not root.idle:
            root.tick(done)
        if (
            done.touched
            or done.writes
            or done.published
            or done.turned
            or done.turning
            or done.waits
            or ends
            or self.held_guards
            or state is not self._still.state
        ):
            return self._ticked(state)
        return self._still

    def stop(self, state: TreeState, view: View) -> TickResult:
        """End whatever runs; see `Ticker`."""
        self._recall(state)
        self.round.begin(self._sight(view), self._pending)
        self.root.stop(self.round)
        return self._ticked(state)

    def _wake(self, key: str) -> None:
        for node in self.dependents.get(key, ()):
            node.wake()
        if self._of_any and not key.startswith("#"):
            for node in self._of_any:
                node.wake()

    def _wake_all(self, changed: Iterable[str], at: float) -> None:
        for key in changed:
            self._wake(key)
        for key in self._written:
            self._wake(key)
        if self.timed and (self._calm[0] is not self.shown or at >= self._calm[1]):
            for node in self.timed:
                node.wake()

    def _doubt_all(self) -> None:
        for node in self.nodes:
            node.idle = False
            node.todo = -1

    # -- remembered ---------------------------------------------------------------------------------------------------

    def _sight(self, view: View) -> TickView:
        """What a tick sees of a view, where the tree writes keys or counts time by itself."""
        root = self.root.shown or NOTHING
        sight = TickView(view, self.state, root.get("began", view.at), root.get("held", NOTHING))
        if self.held_guards:
            sight.note_held(self.held_guards)
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
        self._pending = {path: leaf.outcome for path, leaf in state.leaves.items() if leaf.outcome}
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

    def _ticked(self, before: TreeState) -> TickResult:
        done, self._is_over = self.round, True
        if done.writes and self.held_guards:
            done.sight.note_held(self.held_guards)
        self._written = [key for key, _ in done.writes] if done.writes else ()
        self.shown = self._remembered(before, done.sight)
        self._pending = NOTHING
        is_short = not (done.started or done.ended or done.writes or done.published)
        if is_short and not (done.turned or done.turning or done.waits):
            self._still = _new(TickResult, (self.shown, self.root.status, (), (), (), (), (), (), (), ()))
            return self._still
        begun: tuple[str, ...] = ()
        rounds: tuple[LoopRound, ...] = ()
        if done.turned or done.turning:
            rounds = tuple(
                [
                    LoopRound(child.path, loop.counted, at_once, loop.status is RUNNING)
                    for loop, child, at_once in done.turned
                ]
            )
            begun = tuple([child.path for child in done.turning if child.status is RUNNING])
        waits = tuple([node.path for node in done.waits if node.status is RUNNING]) if done.waits else ()
        return TickResult(
            self.shown,
            self.root.status,
            tuple(done.started),
            tuple(done.ended),
            tuple(done.writes),
            tuple(done.published),
            (),
            begun,
            rounds,
            waits,
        )

    def _remembered(self, before: TreeState, sight: Any) -> TreeState:
        """The state after a tick; it shares with the one before what is the same."""
        has_run, parts, touched, root = False, self._parts, self.round.touched, self.root
        copied: list[int] = []
        if self.held_guards or root.shown is None:
            touched.append(root)
        for node in touched:
            if node.role:
                self._note(node)
                has_run = has_run or node.role == "activity"
            memory = node.memory()
            if node is root:
                memory = self._with_began(memory, sight)
            if memory is node.shown or memory == node.shown:
                continue
            node.shown = memory
            at, place = divmod(node.number, PART)
            if at not in copied:
                if not copied:
                    parts = parts.copy()
                parts[at] = parts[at].copy()
                copied.append(at)
            parts[at][place] = memory
        leaves = before.leaves
        if has_run or self._pending:
            leaves = {self.nodes[number].path: Leaf(self.awaited[number].run) for number in sorted(self.awaited)}
        if not copied and leaves is before.leaves and isinstance(before.nodes, NodeMemories):
            return before
        self._parts = parts
        return TreeState(NodeMemories(self.paths, parts), leaves)

    def _with_began(self, memory: Mapping[str, Any] | None, sight: Any) -> Mapping[str, Any]:
        """What the root remembers besides: when the tree was ticked first, and since when guards have held."""
        began, held = (
            (self.root.shown or NOTHING).get("began", sight.at),
            sight.true_since if self.held_guards else NOTHING,
        )
        return {**(memory or PLAIN[INVALID]), "began": began, **({"held": dict(held)} if held else {})}

    def shift(self, state: TreeState, by_s: float) -> TreeState:
        """The state as it would be had everything happened so much later; see `Ticker`."""
        return shifted(state, by_s)

    # -- what comes next ----------------------------------------------------------------------------------------------

    def wake_at(self, state: TreeState, view: View) -> float:
        """The next deadline of what runs, or instant at which a guard's facts grow old; see `Ticker`."""
        if state is not self.shown:
            self._recall(state)
        if not (self.waiting or self.timed):
            return math.inf
        soonest, now = math.inf, view.at
        for node in self.waiting.values():
            if now < (due := node.deadline()) < soonest:
                soonest = due
        next_due = math.inf
        sight = view if self.is_plain or not self.timed else self._sight(view)
        for node in self.timed:
            for instant in node.site.instants:
                if now < (due := instant(sight)) < next_due and (
                    node.site.held_guards or (node.looks and node.is_seen())
                ):
                    next_due = due
        self._calm = (state, next_due)
        return min(soonest, next_due)

    def reads(self, state: TreeState) -> frozenset[str]:
        """What wants a tick once it is another; see `Ticker`."""
        self._recall(state)
        seen, rest = set(self.held_reads), [self.root]
        while rest:
            node = rest.pop()
            rest += [child for child in node.children if node.sees(child)]
            if node.site is not None and node.looks:
                seen |= node.site.watched
        return frozenset(seen)

    def watches(self, state: TreeState, names: Collection[str]) -> bool:
        """Whether a change of one of these wants a tick; see `Ticker`."""
        if state is not self.shown:
            self._recall(state)
        if state is not self._asked_in:
            self._asked_in, self._wanted = state, {}
        wanted = self._wanted
        for name in names:  # noqa: SIM110 - quicker
            if wanted[name] if name in wanted else self._wants(name):
                return True
        return False

    def _wants(self, name: str) -> bool:
        """Whether a change of this wants a tick, in the state in which the nodes are."""
        looking = self.dependents.get(name, ())
        if self._of_any and not name.startswith("#"):
            looking = (*looking, *self._of_any)
        wants = bool(self.held_reads) and concerns(self.held_reads, (name,))
        for each in () if wants else looking:
            if each.looks and each.is_seen():
                wants = True
                break
        self._wanted[name] = wants
        return wants


def _dependents(sites: Iterable[tuple[CompiledNode, Site]]) -> Mapping[str, tuple[CompiledNode, ...]]:
    found: dict[str, list[CompiledNode]] = {}
    for node, site in sites:
        for name in site.watched:
            found.setdefault(name, []).append(node)
    return {name: tuple(nodes) for name, nodes in found.items()}
