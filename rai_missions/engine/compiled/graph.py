# SPDX-License-Identifier: Apache-2.0
"""Moves, worked out once: which transitions can be taken together, and what taking them leaves and enters.

Rule: what a configuration and the transitions taken in it lead to is computed once and remembered.
Source: W3C SCXML (REC-scxml-20150901), appendix D; the docstrings give the names used there.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any

from rai_missions.engine.compiled.configuration import (
    CompiledMove,
    Configuration,
    exchanged,
    innermost,
    inside,
    leaves,
    ordered,
)
from rai_missions.engine.compiled.mission import CompiledMission
from rai_missions.engine.compiled.states import Act, CompiledState, CompiledTransition, Memory
from rai_missions.engine.step import Move
from rai_missions.guards.view import presence
from rai_missions.states.history import History

__all__ = ("EnteredStates", "Graph", "is_done")

FEW = 8
"""A change of a smaller part of the active states than one in so many."""
IsActive = Callable[[CompiledState], bool]


class EnteredStates(set[CompiledState]):
    """The states that a move enters."""

    def __init__(self) -> None:
        super().__init__()
        self.recalled: dict[CompiledState, CompiledState] = {}
        """`each` → the history that leads back into it."""
        self.around = set[CompiledState]()
        """What these states are inside of."""

    def add(self, node: CompiledState) -> None:
        super().add(node)
        for each in node.ancestors:
            if each in self.around:
                break
            self.around.add(each)


class Graph(CompiledMission):
    """A compiled mission that knows its moves."""

    # -- selecting ------------------------------------------------------------------------------------------------

    def compatible(
        self, config: Configuration, transitions: list[CompiledTransition], memory: Memory
    ) -> list[CompiledTransition]:
        """The transitions that can be taken together: a descendant's preempts an ancestor's, then document order."""
        if len(transitions) < 2:
            return transitions
        kept: dict[CompiledTransition, tuple[CompiledState, ...]] = {}
        leaving: dict[CompiledState, CompiledTransition] = {}
        for transition in transitions:
            exits = inside(config.order, self._domain(transition, memory))
            clashing = (leaving[node] for node in exits if node in leaving)
            if all(transition.source.inside(other.source) for other in clashing):
                for other in {leaving[node] for node in exits if node in leaving}:
                    for node in kept.pop(other):
                        del leaving[node]
                kept[transition] = exits
                leaving |= dict.fromkeys(exits, transition)
        return [*kept]

    def _targets(self, transition: CompiledTransition, memory: Memory) -> list[CompiledState]:
        """Where a transition leads, history looked up (getEffectiveTargetStates)."""
        return [state for target in transition.targets for state in self._effective(target, memory)]

    def _effective(self, target: CompiledState, memory: Memory) -> list[CompiledState]:
        if not target.is_history:
            return [target]
        return [each for node in memory.get(target.index) or target.initial for each in self._effective(node, memory)]

    def _domain(self, transition: CompiledTransition, memory: Memory) -> CompiledState | None:
        """The state inside which everything is left and entered (getTransitionDomain)."""
        targets = self._targets(transition, memory)
        if not targets:
            return None
        source = transition.source
        if transition.internal and source.is_compound and all(target.inside(source) for target in targets):
            return source
        for ancestor in source.ancestors or (self.root,):
            if ancestor.is_compound and all(target.inside(ancestor) for target in targets):
                return ancestor
        return self.root

    # -- moving ---------------------------------------------------------------------------------------------------

    def move_of(
        self, config: Configuration, transitions: tuple[CompiledTransition, ...], memory: Memory, trigger: str
    ) -> CompiledMove:
        """The move that firing these transitions makes, those preempted left out; worked out once."""
        key: Any = (transitions, trigger)
        uses_history = any(transition.uses_history for transition in transitions)
        if uses_history:
            key = (key, tuple((index, tuple(node.index for node in memory[index])) for index in sorted(memory)))
        found = config.moves.get(key)
        if found is None:
            found = self._worked_out(config, tuple(self.compatible(config, list(transitions), memory)), memory, trigger)
            found.plain = found.plain and not uses_history
            config.moves[key] = found
        return found

    def _worked_out(
        self, config: Configuration, transitions: tuple[CompiledTransition, ...], memory: Memory, trigger: str
    ) -> CompiledMove:
        domains = [self._domain(transition, memory) for transition in transitions]
        exited = {node for domain in {*domains} for node in inside(config.order, domain)}
        if remembered := dict(self._remembered(config, exited)):
            memory = {**memory, **remembered}  # SCXML leaves, and remembers, before it enters
            domains = [self._domain(transition, memory) for transition in transitions]
        entered = EnteredStates()
        for transition, domain in zip(transitions, domains, strict=True):
            if domain is None:
                continue
            for target in transition.targets:
                self._descend(target, entered, memory)
            for target in self._targets(transition, memory):
                self._climb(target, domain, entered, memory)
        acts = tuple(act for transition in transitions for act in transition.acts)
        return self._between(
            config,
            exited,
            entered,
            taken=tuple(transition.place for transition in transitions),
            acts=acts,
            trigger=trigger,
        )

    def start(self, memory: Memory) -> CompiledMove:
        """The entry of the mission: what it waits for begins before that of the states in it, as for any state."""
        return self._between(self.empty, set(), self.around(self.root.initial, self.root, memory), outer=(self.root,))

    def move_to(self, config: Configuration, target: CompiledState, memory: Memory, trigger: str) -> CompiledMove:
        """From wherever it is into a state, everything left."""
        exited = {node for node in config.nodes if node.state is not None}
        return self._between(config, exited, self.around((target,), self.root, memory), trigger=trigger)

    def reenter(self, config: Configuration, node: CompiledState, memory: Memory) -> CompiledMove:
        """What is inside a state is left, and its `initial` entered: the next round of an `each`."""
        exited = {*inside(config.order, node)}
        return self._between(config, exited, self.around(node.initial, node, memory))

    def _between(
        self,
        config: Configuration,
        exited: set[CompiledState],
        entered: EnteredStates,
        *,
        taken: tuple[str, ...] = (),
        acts: tuple[Act, ...] = (),
        trigger: str = "",
        outer: tuple[CompiledState, ...] = (),
    ) -> CompiledMove:
        """The move from what is left and entered: exit innermost first, the transitions' acts, entry outermost first.

        What `outer` waits for begins with it, without being named among the states that are entered.
        """
        out = tuple(sorted(exited, key=lambda node: -node.index))
        into = tuple(sorted(entered, key=lambda node: node.index))
        target = self._moved(config, exited, entered)
        entering = tuple(self._entering(config, exited, into, entered.recalled))
        every = tuple(act for node in out for act in node.exit) + acts + entering
        value = Move(taken, tuple(node.name for node in out), tuple(node.name for node in into), trigger)
        move = CompiledMove(value, target, every)
        move.exited, move.entered = out, (*outer, *into)
        move.shifts = frozenset(presence(node.name) for node in exited ^ entered)
        move.remember = tuple(self._remembered(config, out))
        move.lists = tuple((self.order[at], each) for at, states in move.remember for each in self._lists(at, states))
        quiet = not any(node.timed or node.activity or node.clocked or node.control for node in (*out, *into))
        ends = any(node.is_final or node.is_each for node in (*out, *into))
        watched = config.watchful or target.watchful or self.invariants
        move.plain = quiet and not (ends or move.remember or watched)
        return move

    def _moved(self, config: Configuration, exited: set[CompiledState], entered: set[CompiledState]) -> Configuration:
        """What is active once some states were left and others entered.

        Of many states few change: found from those. Where many do, a look at all costs less.
        """
        if len(exited) + len(entered) > len(config.order) // FEW:
            whole = ordered({*config.order} - exited | entered)
            return self.configured(leaves(whole), whole)
        order = exchanged(config.order, exited, entered)
        around = {node.parent for node in (*exited, *entered) if node.parent is not None} - {self.root}
        before, after = innermost(config.order, exited | around), innermost(order, entered | around)
        return self.configured(exchanged(config.atomic, before, after), order)

    def _entering(
        self,
        config: Configuration,
        exited: set[CompiledState],
        into: tuple[CompiledState, ...],
        recalled: Mapping[CompiledState, CompiledState],
    ) -> Iterable[Act]:
        """The acts of entering these; a final raises the end of its parent, and of a parallel state with it."""
        now = set[CompiledState]()

        def is_active(node: CompiledState) -> bool:
            return node in now or (node not in exited and config.is_active(node))

        for node in into:
            now.add(node)
            if node.is_each:
                yield self._content.enter_each(node, recalled.get(node))
            yield from node.entry
            if node.is_final and node.parent is not None:
                outer = node.parent if node.parent.is_parallel else node.parent.parent
                yield self._content.reach_final(node, tuple(self.complete(outer, is_active)))

    def complete(self, region_of: CompiledState | None, is_active: IsActive) -> Iterable[CompiledState]:
        """The parallel states that may have all their regions in a final now, inner first."""
        while region_of is not None and region_of.is_parallel and is_done(region_of, is_active):
            yield region_of
            region_of = region_of.parent

    def _remembered(
        self, config: Configuration, exited: Iterable[CompiledState]
    ) -> Iterable[tuple[int, tuple[CompiledState, ...]]]:
        for node in exited:
            for history in node.history:
                assert isinstance(history.state, History)
                if history.state.history == "deep":
                    yield history.index, inside(config.atomic, node)
                else:
                    yield history.index, tuple([each for each in inside(config.order, node) if each.parent is node])

    def _lists(self, history: int, states: Iterable[CompiledState]) -> Iterable[CompiledState]:
        """Each `each` that a history leads back into, if these are the states that it leads back to."""
        parent = self.order[history].parent
        assert parent is not None
        inner = {outer for state in states for outer in state.ancestors if outer is parent or outer.inside(parent)}
        return sorted([each for each in inner if each.is_each], key=lambda each: each.index)

    def around(self, targets: Iterable[CompiledState], domain: CompiledState, memory: Memory) -> EnteredStates:
        """All states that are entered with some targets: those around them up to the domain, and defaults inside."""
        entered = EnteredStates()
        self._into(targets, domain, entered, memory)
        return entered

    def _into(
        self, targets: Iterable[CompiledState], domain: CompiledState, entered: EnteredStates, memory: Memory
    ) -> None:
        """Targets, what is entered inside them by default, and what lies between them and the domain."""
        targets = tuple(targets)
        for target in targets:
            self._descend(target, entered, memory)
        for target in targets:
            self._climb(target, domain, entered, memory)

    def _descend(self, node: CompiledState, entered: EnteredStates, memory: Memory) -> None:
        """A target and what is entered inside it by default (addDescendantStatesToEnter)."""
        if node.is_history:
            assert node.parent is not None
            remembered = memory.get(node.index, ())
            targets = remembered or node.initial
            entered.recalled |= dict.fromkeys(self._lists(node.index, remembered), node)
            self._into(targets, node.parent, entered, memory)
            return
        entered.add(node)
        if node.is_parallel:
            self._regions(node, entered, memory)
        elif node.is_compound and not node.is_each:
            self._into(node.initial, node, entered, memory)

    def _climb(self, node: CompiledState, domain: CompiledState, entered: EnteredStates, memory: Memory) -> None:
        """What lies between a target and the domain (addAncestorStatesToEnter)."""
        for ancestor in node.ancestors:
            if ancestor is domain:
                break
            entered.add(ancestor)
            if ancestor.is_parallel:
                self._regions(ancestor, entered, memory)

    def _regions(self, parallel: CompiledState, entered: EnteredStates, memory: Memory) -> None:
        """The regions of a parallel state in which nothing is entered yet, by default."""
        for child in parallel.children:
            if child not in entered and child not in entered.around:
                self._descend(child, entered, memory)


def is_done(node: CompiledState, is_active: IsActive) -> bool:
    """Whether a state may have reached its end (SCXML: isInFinalState); an `each` has as its list shows."""
    if node.is_each:
        return is_active(node)
    if node.is_parallel:
        return all(is_done(child, is_active) for child in reversed(node.children))  # that entered last is done last
    if node.is_final:
        return is_active(node)
    return any(child.is_final and is_active(child) for child in node.children)
