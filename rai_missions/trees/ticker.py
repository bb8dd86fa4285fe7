# SPDX-License-Identifier: Apache-2.0
"""One compiled tree: restored from its state, ticked once, and read back.

Rule: the live behaviours are only where a tick is worked out; all that they remember is in the `TreeState`.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from rai_missions.engine.activities.ticker import Leaf, LoopRound, TickResult, TreeState
from rai_missions.engine.trees.sites import shifted
from rai_missions.engine.trees.tick import Tick, TickView
from rai_missions.guards.view import View, concerns
from rai_missions.keys import Key
from rai_missions.states.tree import TreeNode
from rai_missions.trees.builder import TreeBuilder
from rai_missions.trees.dependencies import BehaviourWatch, TickReads
from rai_missions.trees.leaves import ActivityLeaf, AskBehaviour, WaitBehaviour
from rai_missions.trees.nodes import INVALID, RUNNING, STATUSES, WORDS, TimeoutBehaviour, TracedBehaviour

__all__ = ("TreeTicker",)

PLAIN = {word: {"status": word} for word in STATUSES}
"""What a node remembers that remembers nothing but its status."""


class TreeTicker:
    """Ticks one tree. Two of them share nothing, and a state may be given to any that was compiled for the same tree.

    Args:
        root: The tree.
        place: Its JSON pointer in the mission.
        keys: The mission's keys.
        state: The state that runs it.
    """

    def __init__(self, root: TreeNode, place: str, keys: Mapping[str, Key], state: str) -> None:
        self.round, self.state = Tick(), state
        builder = TreeBuilder(place, keys, state, self.round)
        self.root: Any = builder.build(root)
        self.live: dict[str, TracedBehaviour] = builder.live
        self.activity_leaves = [node for node in self.live.values() if isinstance(node, ActivityLeaf | AskBehaviour)]
        self.waits = {path for path, node in self.live.items() if isinstance(node, WaitBehaviour | TimeoutBehaviour)}
        self.watch = BehaviourWatch(self.live)
        self.loops = len(self.watch.turns)
        self._shown: TreeState | None = None
        self._looked: tuple[TreeState | None, TickReads | None] = (None, None)
        """What was worked out last, and of which state."""

    def tick(
        self,
        state: TreeState,
        view: View,
        outcomes: Mapping[str, str],
        late_s: float = 0.0,
        changed: Collection[str] | None = None,
    ) -> TickResult:
        sight = self._restore(state, view)
        sight.late_s = late_s
        self._shown = None
        pending = {path: leaf.outcome for path, leaf in state.leaves.items() if leaf.outcome}
        self.round.begin(sight, {**pending, **outcomes} if pending else outcomes)
        before = self.watch.turning() if self.loops else frozenset[str]()
        self.root.tick_once()
        begun, ended = self.watch.turned(before, self.round.trace) if self.loops else ((), ())
        return self._ticked(sight, begun, ended)

    def stop(self, state: TreeState, view: View) -> TickResult:
        sight = self._restore(state, view)
        self._shown = None
        self.round.begin(sight, {path: leaf.outcome for path, leaf in state.leaves.items() if leaf.outcome})
        self.root.stop(INVALID)
        return self._ticked(sight)

    def wake_at(self, state: TreeState, view: View) -> float:
        sight = self._restore(state, view)
        return self.watch.wake_at(self.root, sight, self._looked_at(state).instants)

    def reads(self, state: TreeState) -> frozenset[str]:
        return self._looked_at(state).watched

    def watches(self, state: TreeState, names: Collection[str]) -> bool:
        return concerns(self.reads(state), names)

    def _looked_at(self, state: TreeState) -> TickReads:
        of, looked = self._looked
        if of is not state or looked is None:
            self._recall(state)
            looked = self.watch.looked_at(self.root)
            self._looked = (state, looked)
        return looked

    def shift(self, state: TreeState, by_s: float) -> TreeState:
        """The state as it would be had everything happened so much later, in seconds: what a pause makes of it."""
        return shifted(state, by_s)

    def _restore(self, state: TreeState, view: View) -> TickView:
        self._recall(state)
        root = state.nodes.get("", {})
        sight = TickView(view, self.state, root.get("began", view.at), root.get("held", {}))
        return self.watch.note_held(sight)

    def _recall(self, state: TreeState) -> None:
        if self._shown is not None and state is self._shown:
            return
        self._shown = None
        for path, node in self.live.items():
            memory = state.nodes.get(path) or PLAIN["invalid"]
            node.status = STATUSES[memory.get("status", "invalid")]
            node.recall(memory)
        for node in self.activity_leaves:
            if node.path in state.leaves and isinstance(node, ActivityLeaf):
                node.refused = state.leaves[node.path].outcome == "rejected"
        self._shown = state

    def _ticked(self, sight: TickView, begun: tuple[str, ...] = (), rounds: tuple[LoopRound, ...] = ()) -> TickResult:
        done, status = self.round, WORDS[self.root.status]
        if done.writes:
            sight = self.watch.note_held(sight)
        leaves = {node.path: Leaf(node.run) for node in self.activity_leaves if node.awaited}
        self._shown = TreeState(self._memories(sight), leaves)
        started, ended = tuple(done.started), tuple(done.ended)
        writes, published, trace = tuple(done.writes), tuple(done.published), tuple(done.trace)
        begun_waits = (self.live[path] for path, call, _ in trace if call == "initialise" and path in self.waits)
        waits = tuple(node.path for node in begun_waits if node.status is RUNNING)
        return TickResult(self._shown, status, started, ended, writes, published, trace, begun, rounds, waits)

    def _memories(self, sight: TickView) -> dict[str, Any]:
        memories: dict[str, Any] = {}
        for path, node in self.live.items():
            status, memory = WORDS[node.status], node.kept()
            if memory:
                memories[path] = {"status": status, **memory}
            elif status != "invalid":
                memories[path] = PLAIN[status]
        held = {"held": dict(sight.true_since)} if sight.true_since else {}
        memories[""] = {**memories.get("", PLAIN[WORDS[INVALID]]), "began": sight.began, **held}
        return memories
