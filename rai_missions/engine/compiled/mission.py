# SPDX-License-Identifier: Apache-2.0
"""A mission compiled once: its states in document order, its transitions with their guards as functions."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from rai_missions.engine.compiled.configuration import Configuration
from rai_missions.engine.compiled.states import Act, CompiledGuard, CompiledState, CompiledTransition, Content
from rai_missions.errors import UsageError, escaped
from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Truth
from rai_missions.mission.mission import Mission
from rai_missions.states.effects import Effect
from rai_missions.states.final import Final
from rai_missions.states.history import History
from rai_missions.states.state import OUTCOMES, State
from rai_missions.states.transition import Transition

__all__ = ("CompiledMission",)

CONFIGURATIONS = 4096
"""How many configurations are remembered, unless four for each state are more; past that all are forgotten."""


class CompiledMission:
    """A mission, ready to be stepped.

    Args:
        mission: One that `check` finds no fault in; names that do not resolve raise `KeyError`.
        content: How effects, and the entry of lists and finals, are compiled.
    """

    def __init__(self, mission: Mission, content: Content) -> None:
        self.mission = mission
        self.root = CompiledState("", "", None, None, 0)
        self.nodes: dict[str, CompiledState] = {}
        self.order: list[CompiledState] = [self.root]
        self.transitions: dict[str, CompiledTransition] = {}
        """JSON pointer → transition."""
        self.named: set[str] = set()
        """The predicates of the user's program that transitions, finals and invariants name."""
        self.uses_history = False
        """Some default entry looks up a memory, so that every move may depend on what is remembered."""
        self._content = content
        self._add(mission.states, self.root, "/states")
        self.root.last = len(self.order) - 1
        self.options = {name for node in self.order if node.options and node.state for name in node.state.outcomes()}
        self._outcomes = frozenset(OUTCOMES).union(self.options) - mission.events.keys()
        """The words of `on` that are no events."""
        self._has_history = any(node.is_history for node in self.order)
        self._link()
        self.controls = frozenset(node.control for node in self.order if node.control is not None)
        """Whose control its states need."""
        self.invariants = {
            name: self.condition(guard, f"/invariants/{name}", "", counts=False)
            for name, guard in mission.invariants.items()
        }
        guarded = [(each.source, each.condition) for each in self.transitions.values() if each.condition is not None]
        guarded += [(self.root, each) for each in self.invariants.values()]
        self.held_owners = {memory: node for node, condition in guarded for memory in condition.held_guards}
        """Memory of a `held` guard → the state whose transition it guards; the root for an invariant."""
        self.invariant_reads = frozenset[str]().union(*(each.reads for each in self.invariants.values()))
        self._configurations: dict[tuple[CompiledState, ...], Configuration] = {}
        self.empty = Configuration((), (self.root,))

    def _add(self, states: Mapping[str, State], parent: CompiledState, place: str) -> None:
        for name, state in states.items():
            node = CompiledState(name, f"{place}/{escaped(name)}", state, parent, len(self.order))
            self.order.append(node)
            self.nodes[name] = node
            (parent.history if node.is_history else parent.children).append(node)
            if children := state.children():
                self._add(children, node, f"{node.place}/{state.child_place()}")
                node.last = len(self.order) - 1

    def _link(self) -> None:
        self.root.initial = tuple(self.nodes[name] for name in self.mission.initial)
        for node in self.order[1:]:
            node.initial = tuple([self.nodes[name] for name in _leads(node)])
        self.uses_history = any(target.is_history for node in self.order for target in node.initial)
        self._transitions(self.root, self.mission.transitions)
        for node in self.order[1:]:
            state = node.state
            assert state is not None
            node.clocked = node.clocked or node.activity  # its machine's guards, a profile's too, may ask for its age
            if state.entry:
                node.entry = self._acts(state.entry, f"{node.place}/entry", node)
            if state.exit:
                node.exit = self._acts(state.exit, f"{node.place}/exit", node)
            if isinstance(state, Final) and state.requires is not None:
                node.requires = self.condition(state.requires, f"{node.place}/requires", node.name)
            if not node.is_history:  # its transition is its default, which never fires
                self._transitions(node, state.transitions)
        self._follow_histories()

    def _follow_histories(self) -> None:
        """See that each history leads to a state where there is no memory.

        Raises:
            UsageError: One leads back to itself.
        """
        for node in self.order:
            seen, todo = set[CompiledState](), [node] if node.is_history else []
            while todo:
                for each in todo.pop().initial:
                    if each is node:
                        raise UsageError(
                            f"the history '{node.name}' leads to itself where there is no memory; "
                            'give it a default, "transitions": [{"to": …}], that is a state'
                        )
                    todo += [each] if each.is_history and each not in seen else []
                    seen.add(each)

    def _transitions(self, node: CompiledState, transitions: Iterable[Transition]) -> None:
        for index, definition in enumerate(transitions):
            transition = CompiledTransition(definition, f"{node.place}/transitions/{index}", node)
            transition.targets = tuple([self.nodes[name] for name in definition.to])
            if self._has_history:
                transition.uses_history = self.uses_history or any(target.is_history for target in transition.targets)
            if definition.do:
                transition.acts = self._acts(definition.do, f"{transition.place}/do", node)
            if definition.when is not None:
                transition.condition = self.condition(definition.when, transition.place, node.name, counts=True)
                transition.test = transition.condition.test
            if not self._outcomes.isdisjoint(definition.on):
                transition.outcomes = self._outcomes.intersection(definition.on)
            node.transitions.append(transition)
            if definition.of is not None:
                self.nodes[definition.of].of_it.append(transition)
            self.transitions[transition.place] = transition
            node.timed = node.timed or definition.after_s is not None
            has_held = transition.condition is not None and bool(transition.condition.held_guards)
            node.watches = node.watches or definition.eventless or has_held

    def _acts(self, effects: Iterable[Effect], place: str, node: CompiledState) -> tuple[Act, ...]:
        return tuple(
            [self._content.effect(effect, f"{place}/{index}", node.name) for index, effect in enumerate(effects)]
        )

    def condition(self, guard: Guard, place: str, state: str, *, counts: Truth = None) -> CompiledGuard:
        """A guard compiled for a place; the states whose age it asks for are clocked from now on.

        Args:
            guard: As the mission has it.
            place: Its JSON pointer.
            state: Whose it is.
            counts: Which of its values counts there.
        """
        site = self._content.site(place, self.mission.blackboard, state)
        test = guard.compiled(site, counts)
        self.named |= site.named
        for name in site.clocked:
            (self.nodes[name] if name else self.root).clocked = True
        reads, instants = frozenset(site.reads), tuple(site.instants)
        return CompiledGuard(place, guard, test, reads, site.watched, instants, dict(site.held_guards), counts)

    def configuration(self, atomic: Iterable[CompiledState]) -> Configuration:
        """The one `Configuration` of these innermost states."""
        nodes = tuple(sorted(atomic, key=lambda node: node.index))
        if (found := self._configurations.get(nodes)) is not None:
            return found
        around = {each for node in nodes for each in (node, *node.ancestors)} or {self.root}
        return self.configured(nodes, tuple(sorted(around, key=lambda node: node.index)))

    def configured(self, atomic: tuple[CompiledState, ...], order: tuple[CompiledState, ...]) -> Configuration:
        """The one `Configuration` of these innermost states and of all active states, both in document order."""
        found = self._configurations.get(atomic)
        if found is None:
            if len(self._configurations) >= max(CONFIGURATIONS, 4 * len(self.order)):
                for each in self._configurations.values():
                    each.forget()
                self._configurations.clear()
            found = self._configurations[atomic] = Configuration(atomic, order)
        return found


def _leads(node: CompiledState) -> Iterable[str]:
    """What entering a state by default leads to: its `initial`; of a history its default, or its parent's `initial`."""
    if isinstance(node.state, History) and node.state.default:
        return node.state.default
    around = node.parent if node.is_history else node
    if around is None or around.state is None:
        return ()
    return around.state.starts()
