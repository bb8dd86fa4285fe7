# SPDX-License-Identifier: Apache-2.0
"""What makes a difference while a state is active: what it looks at, and whatever it leads to before that is written.

Source: live variables, A. V. Aho et al., Compilers (2nd ed.), section 9.2.5, on the transitions of a chart.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator
from itertools import dropwhile

from rai_missions.engine.compiled.graph import Graph
from rai_missions.engine.compiled.states import CompiledState, CompiledTransition
from rai_missions.prove.analysis.state_reads import ANSWER, KNOWN, StateReads
from rai_missions.states.compound import Each
from rai_missions.states.effects import Set

__all__ = ("RECALL", "LiveTable", "root_of")

RECALL = "recall "
"""Prefix of the name of a history state that may be looked up."""


class LiveTable:
    """The words of each state: paths, actions, histories and parameters that make a difference while it is active.

    A history leads back to all that is inside its parent, unless it *returns*: then the parent is active now, and what
    was active inside when it is left is known only then. Why what is inside need not be read again there: a run that
    returns does from then on what it could have done, had it stayed where it left. So its first look at a key that
    nothing has written since is a look of the run that stays, and is among the words of what is active now. Only
    entries are made again: those of the states on the way are among these words as well, and those of what is active
    now are added by `entered_again`.

    Args:
        reads: What each state looks at.
        graph: The mission, compiled.
        rewritten: The histories whose parent is always left before they are looked up again.
        flee: The state for a cancel.
        returning: Those of the rewritten ones that return; deep, or with no states inside those that they remember.
    """

    def __init__(
        self,
        reads: StateReads,
        graph: Graph,
        *,
        rewritten: Collection[CompiledState],
        flee: CompiledState | None,
        returning: frozenset[CompiledState] = frozenset(),
    ) -> None:
        self._reads, self._graph, self._rewritten = reads, graph, rewritten
        self._flee, self._returning = flee, returning
        self._entered: dict[CompiledState, frozenset[CompiledState]] = {}
        self._on_entry = {node: reads.on_entry(node) for node in graph.order}
        self._live = {node: reads.of_state(node) for node in graph.order}
        while self._spread():
            pass

    def of(self, nodes: Iterable[CompiledState]) -> frozenset[str]:
        """What makes a difference while these are active."""
        return frozenset[str]().union(*(self._live[node] for node in nodes))

    def entered_again(self, nodes: Collection[CompiledState]) -> frozenset[str]:
        """What is looked at as those of the active states are entered to which a history returns."""
        back = [node for node in nodes if any(each.parent in node.ancestors for each in self._returning)]
        return frozenset[str]().union(*(self._on_entry[node] for node in back))

    def of_transition(self, transition: CompiledTransition) -> frozenset[str]:
        """What a transition looks at, and what makes a difference behind it that its effects have not written."""
        definition, reads = transition.definition, self._reads
        found = {*reads.mentions(definition.when), *reads.of_effects(definition.do)}
        written = {
            effect.set
            for effect in definition.do
            if isinstance(effect, Set)
            and effect.add is None
            and (effect.source is None or reads.is_known(effect.source, effect.set, transition))
        }
        later = self._once_in(transition.targets, _staying(transition))
        recalled = {RECALL + target.name for target in transition.targets if target.is_history}
        return frozenset(found | recalled) | {word for word in later if root_of(word) not in written}

    def _spread(self) -> bool:
        """One round; whether anything was learned."""
        before = sum(len(words) for words in self._live.values())
        for node in reversed(self._graph.order):  # most transitions lead to later states, whose needs are known then
            found = self._live[node].union(*(self._once_entered(node, transition) for transition in node.transitions))
            if node.is_each:
                found |= self._once_in(node.initial, (node, *node.ancestors), again={node})
            if node.state is None and self._flee is not None:
                found |= self._once_in((self._flee,))
            self._live[node] = found - {
                RECALL + each.name for each in self._rewritten if each.parent is node or each.parent in node.ancestors
            }
        return sum(len(words) for words in self._live.values()) > before

    def _once_entered(self, node: CompiledState, transition: CompiledTransition) -> frozenset[str]:
        """What a transition needs from the entry of its state on: an outcome comes with what was written just before.

        That is what the state has worked out, or the answer that was given.
        """
        words, state = self.of_transition(transition), node.state
        named, of = transition.definition.on, transition.definition.of
        written = set[str]()
        if state is not None and named and state.computed().issuperset(named):
            written.add(getattr(state, "into", ""))
        asking = node if of is None else self._graph.nodes[of]
        if named and (asking.options & transition.outcomes).issuperset(named) and ANSWER not in self._reads.keys:
            written.add(ANSWER)
        return frozenset(word for word in words if root_of(word) not in written) if written else words

    def _once_in(
        self,
        targets: Collection[CompiledState],
        kept: Collection[CompiledState] = (),
        again: Collection[CompiledState] = (),
    ) -> frozenset[str]:
        """What makes a difference once these are entered, where some states around them stay active.

        What is inside a list is entered only once its key has the item. So it was written before that is looked at.

        Args:
            targets: The states.
            kept: Those around them that stay active.
            again: Lists of these that have another item.
        """
        begun = {*again, *_lists_begun(targets, kept)}
        found = set[str]()
        for node in self._into(targets):
            words = self._live[node] if node in kept else self._live[node] | self._on_entry[node]
            items = {each.state.item for each in begun if node.inside(each) and isinstance(each.state, Each)}
            found |= {word for word in words if root_of(word) not in items} if items else words
        return frozenset(found)

    def _into(self, targets: Iterable[CompiledState]) -> set[CompiledState]:
        """All that may be active once these are entered, with what was active before."""
        return {node for target in targets for node in self._around(target)}

    def _around(self, target: CompiledState) -> frozenset[CompiledState]:
        """A target, what is entered inside it, its ancestors, and the other regions."""
        if target not in self._entered:
            found = {target, *target.ancestors}
            found |= set(self._inside(target))
            for ancestor in target.ancestors:
                if ancestor.is_parallel:
                    found |= {node for node in self._graph.order if node.inside(ancestor)}
            self._entered[target] = frozenset(found)
        return self._entered[target]

    def _inside(self, node: CompiledState) -> Iterator[CompiledState]:
        """What may be entered with a state by default; of a history, all that it can lead back to."""
        if node in self._returning:
            return
        if node.is_history or node.is_parallel or node.is_each:
            top = node.parent if node.is_history else node
            yield from (each for each in self._graph.order if top is not None and each.inside(top))
            return
        for initial in node.initial:
            yield from (initial, *(each for each in initial.ancestors if each.inside(node)))
            yield from self._inside(initial)
            for between in initial.ancestors:
                if between.is_parallel and between.inside(node):
                    yield from (each for each in self._graph.order if each.inside(between))


def root_of(word: str) -> str:
    """The key that a word is about."""
    return word.removeprefix(KNOWN).partition(".")[0]


def _lists_begun(targets: Collection[CompiledState], kept: Collection[CompiledState]) -> Iterator[CompiledState]:
    """The lists that begin as these are entered: a history may lead back to the item that one had."""
    if any(target.is_history for target in targets):
        return
    for target in targets:
        around = (each for each in (target, *target.ancestors) if each not in kept)
        yield from (each for each in (*around, *_below(target)) if each.is_each)


def _below(node: CompiledState) -> Iterator[CompiledState]:
    """All that is inside a state."""
    for child in node.children:
        yield child
        yield from _below(child)


def _staying(transition: CompiledTransition) -> tuple[CompiledState, ...]:
    """The states around a transition that stay active: the domain of its targets, and what is around that.

    A parallel state is no domain: a transition from one of its regions to another leaves it, and enters it again.
    """
    targets = transition.targets
    return tuple(
        dropwhile(
            lambda node: not node.is_compound or not all(target.inside(node) for target in targets),
            transition.source.ancestors,
        )
    )
