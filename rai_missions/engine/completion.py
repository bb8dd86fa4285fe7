# SPDX-License-Identifier: Apache-2.0
"""How things end: rounds of a list, finals, parallel states, the mission; and what must never be false."""

from __future__ import annotations

from typing import Any

from rai_missions.engine.activities.activity import Outcome
from rai_missions.engine.nodes import Condition, Node
from rai_missions.engine.running import Activities
from rai_missions.engine.state import Trigger
from rai_missions.engine.step import Cause
from rai_missions.guards.guard import Operand, Site
from rai_missions.keys import fits
from rai_missions.states.compound import Each
from rai_missions.states.final import Final, worst

__all__ = ("Endings",)


class Endings(Activities):
    """A chart that knows when something is over."""

    def enter_each(self, node: Node) -> None:
        """Copy the list of an `each`; its first item is current from here on."""
        assert isinstance(node.state, Each)
        value = Operand(node.state.each, Site(node.place, self.mission.blackboard)).read(self.view)
        self._rounds[node.name] = (tuple(value) if isinstance(value, list | tuple) else (), 0)
        if not isinstance(value, list | tuple):
            self._internal.append(
                self._outcome_of(node, Outcome("failed", why=f"the list {node.state.each} is unknown"))
            )
        elif value:
            self._set_item(node, value[0])

    def _set_item(self, node: Node, item: Any) -> bool:
        """Make an item the current one. One that does not fit its key ends the `each`: its round would use another."""
        assert isinstance(node.state, Each)
        key = self.mission.blackboard.get(node.state.item)
        why = fits(key, item) if key is not None else "the mission has no such key"
        if why and not any(trigger.source is node for trigger in self._internal):
            why = f"an item cannot be '{node.state.item}': {why}"
            self._internal.append(self._outcome_of(node, Outcome("failed", why=why)))
        if not why:
            self.write_key(node.state.item, item)
        return not why

    def _next_round(self, node: Node) -> None:
        items, index = self._rounds[node.name]
        if index < len(items):
            if self._set_item(node, items[index]):
                self._jump(self._graph.reenter(self._config, node, self._memory))
        elif not any(trigger.source is node for trigger in self._internal):
            self._internal.append(self._outcome_of(node, Outcome("succeeded")))

    def reach_final(self, node: Node, complete: tuple[Node, ...]) -> None:
        """A final was entered: at the top it ends the mission, else its parent, and parallel states with it."""
        parent = node.parent
        assert parent is not None and isinstance(node.state, Final)
        if parent.state is None:
            self._final = node
            return
        if parent.is_parallel:
            self._complete_parallels(complete)
            return
        if node.requires is not None and node.requires.test(self.view) is not True:
            late_s = self.late_s + self.mission.settle_s
            self._settling[node.name] = self._now_of(node.control) + late_s
            if late_s > 0:
                return
            del self._settling[node.name]
            self._finish(parent, "unverified", complete, why=self._falls_short(node.requires))
            return
        self._finish(parent, node.state.final, complete)

    def _finish(self, parent: Node, outcome: str, complete: tuple[Node, ...], why: str = "") -> None:
        if parent.is_each and outcome == "succeeded" and parent.name in self._rounds:
            items, index = self._rounds[parent.name]
            self._rounds[parent.name] = (items, index + 1)
            if index + 1 < len(items):
                self._internal.append(Trigger("round", {}, parent))
                return
        in_region = parent.parent is not None and parent.parent.is_parallel
        trigger = self._outcome_of(parent, Outcome(outcome, why=why))
        self._internal.append(trigger._replace(climbs=not in_region))
        self._complete_parallels(complete)

    def _complete_parallels(self, complete: tuple[Node, ...]) -> None:
        """Parallel states whose regions have all ended report the worst of their outcomes, the inner first."""
        for parallel in complete:
            outer = parallel.parent is not None and parallel.parent.is_parallel
            done = self._outcome_of(parallel, Outcome(self._worst(parallel)))
            self._internal.append(done._replace(climbs=not outer))

    def _worst(self, parallel: Node) -> str:
        """The outcome of a parallel state whose regions have all ended."""
        found = []
        for region in parallel.children:
            if region.is_parallel:
                found.append(self._worst(region))
            if isinstance(region.state, Final):
                found.append(region.state.final)
            for child in region.children:
                if child.is_final and child in self._config.nodes and isinstance(child.state, Final):
                    found.append(child.state.final)
        return worst(found)

    def _settle_final(self) -> None:
        """A top-level final is reached: it counts once its `requires` is true, unless that takes too long."""
        self._check_invariants()
        node = self._final
        if node is None or self.outcome is not None:
            return
        assert isinstance(node.state, Final)
        requires = node.requires
        if requires is None:
            return self._end(node.state.final, f"'{node.name}' was reached")
        value = requires.test(self.view)
        self.looked.append((requires.place, value))
        until = self._settling.setdefault(node.name, self.begins_at + self.mission.settle_s)
        if value is True:
            self._end(node.state.final, f"'{node.name}' was reached, and {requires.guard.words()}")
        elif self.view.at >= until:
            self._end("failed", f"'{node.name}' was reached, but {self._falls_short(requires)}")

    def _settle_nested(self) -> None:
        """Finals inside other states whose `requires` was not true when they were entered."""
        for name, until in list(self._settling.items()):
            node = self._graph.nodes[name]
            if self._frozen and self._is_held(node):
                continue
            assert node.parent is not None and node.requires is not None and isinstance(node.state, Final)
            complete = tuple(self._graph.complete(node.parent.parent, self._config.nodes))
            if node.requires.test(self.view) is True:
                del self._settling[name]
                self._finish(node.parent, node.state.final, complete)
            elif self.view.at >= until:
                del self._settling[name]
                self._finish(node.parent, "unverified", complete, why=self._falls_short(node.requires))

    def _falls_short(self, condition: Condition) -> str:
        value = condition.test(self.view)
        unknown = [self._age(key) for key in sorted(condition.reads) if self._age(key)]
        said = "false" if value is False else "unknown"
        return f"'{condition.guard.words()}' is {said}" + (
            f" ({', '.join(unknown)})" if unknown and value is None else ""
        )

    def _age(self, key: str) -> str:
        entry, written = self.view.board.get(key), self.mission.blackboard.get(key)
        if entry is None:
            return f"{key} was never heard"
        stale = written is not None and written.max_age_s is not None and self.view.at >= entry.at + written.max_age_s
        return f"{key} is {self.view.at - entry.at:.1f} s old" if stale else ""

    def _check_invariants(self) -> None:
        if self.outcome is not None or not self._invariants:
            return
        unknown = set()
        for name, condition in self._invariants:
            value = condition.test(self.view)
            if value is False:
                self.looked.append((condition.place, value))
                self.false_invariant = name
                return self._kill(f"invariant '{name}' is false: {condition.guard.words()}", cause="invariant")
            if value is None:
                unknown.add(name)
        for name in sorted(unknown - self._unknown):
            self.notes.append(f"invariant '{name}' is unknown")
        self._touched = self._touched or self._unknown != unknown
        self._unknown = frozenset(unknown)

    def _kill(self, why: str, *, cause: Cause = "") -> None:
        self.effects += self._ledger.stop_all(self.begins_at)
        self.holder, self.taken = "nobody", False
        self._end("aborted", why, killed=True, cause=cause)

    def _end(self, outcome: str, why: str, *, killed: bool = False, cause: Cause = "") -> None:
        """The mission is over: everything that runs is ended, and the active states do what they do when left.

        Args:
            outcome: How it ended.
            why: The rule that decided it.
            killed: By an emergency stop or an invariant: no `exit` is done, and a cancel under way makes no difference.
            cause: What it was, where no rule of the mission ended it; a cancel under way ends as a cancel all the same.
        """
        if self.outcome is not None:
            return
        if self.mode == "canceling" and not killed:
            outcome, why, cause = "canceled", self.why, ""
        self.outcome, self.why, self.cause, self._ended, self._touched = outcome, why, cause, True, True
        self._hear_kept(None)
        for name in list(self._running):
            self._leave_activity(self._graph.nodes[name])
        for node in () if killed else sorted(self._config.nodes, key=lambda node: -node.index):
            for act in node.exit:
                act(self)
        for goal in list(self._ledger.goals.values()):
            self.effects += self._ledger.cancel(goal.number, self.begins_at)
        self._timers.clear()
        self._pending.clear()
        self._settling.clear()
        self._internal.clear()
        self._starting, self._laid_by, self._asked = [], (), ""
        self.mode = "ended"
