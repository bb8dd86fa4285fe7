# SPDX-License-Identifier: Apache-2.0
"""A mission laid out for the rules: each state, row, guard, effect, read and write once, with its place.

Rule: whatever two rules need is worked out here, in one walk; a rule never walks the mission itself.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping
from typing import Any, NamedTuple

from rai_missions.check.name_table import Lexicon
from rai_missions.check.pointers import NodeRef, guard_parts, pointer, template_reads, tree_nodes
from rai_missions.guards import Guard
from rai_missions.kinds import PATH
from rai_missions.mission.mission import BUILT_IN_EVENTS, Mission
from rai_missions.states import (
    Action,
    Call,
    Decision,
    DecisionSpec,
    Each,
    Final,
    Include,
    Option,
    State,
    Transition,
    Tree,
)
from rai_missions.states.effects import Call as CallEffect
from rai_missions.states.effects import Effect, Publish, Raise, Set
from rai_missions.states.tree import (
    ActionLeaf,
    CallLeaf,
    CheckLeaf,
    DecisionLeaf,
    EternalGuard,
    PublishLeaf,
    SetLeaf,
    StatusToBlackboard,
)

__all__ = ("EffectUse", "GuardUse", "KeyWrite", "MissionIndex", "Read", "Scope", "StateRef", "TransitionRef", "Work")


class StateRef:
    """A state where it is: its place, its parent, and the span of the states inside it."""

    __slots__ = ("children", "index", "last", "name", "parent", "place", "rows", "state")

    def __init__(self, name: str, place: str, state: State, parent: StateRef | None, index: int) -> None:
        self.name, self.place, self.state, self.parent, self.index = name, place, state, parent, index
        self.last = index
        """The index of the last state inside it."""
        self.children: list[StateRef] = []
        self.rows: list[TransitionRef] = []

    def inside(self, other: StateRef | None) -> bool:
        """Whether it is a proper descendant of another; everything is inside the mission (None)."""
        return other is None or other.index < self.index <= other.last

    def upward(self) -> Iterator[StateRef]:
        """It and its ancestors, innermost first."""
        here: StateRef | None = self
        while here is not None:
            yield here
            here = here.parent

    def __repr__(self) -> str:
        return f"<{self.name}>"


class TransitionRef(NamedTuple):
    """A transition where it is; `owner` is None for the mission's own."""

    owner: StateRef | None
    place: str
    transition: Transition


class Scope(NamedTuple):
    """What is around a read: whose it is, and what `event.…` and `answer.…` can mean there."""

    owner: StateRef | None = None
    row: TransitionRef | None = None
    option: Option | None = None
    """The option in whose subtree of a tree it is."""


class Read(NamedTuple):
    """A path that something looks at."""

    path: str
    place: str
    scope: Scope


class KeyWrite(NamedTuple):
    """A key that something writes."""

    key: str
    place: str
    by: str
    """`set`, `add`, `from`, `result`, `each`, or `status` for what a tree's node reports."""
    value: Any
    """The constant, the number added, or the path."""
    scope: Scope


class GuardUse(NamedTuple):
    """A guard where it is, and what it decides: `row`, `option`, `achieved`, `requires`, `invariant` or `tree`."""

    guard: Guard
    place: str
    role: str
    scope: Scope


class EffectUse(NamedTuple):
    """An effect where it is."""

    effect: Effect
    place: str
    scope: Scope


class Work(NamedTuple):
    """An action or a call, of a state or a leaf."""

    work: Action | Call | ActionLeaf | CallLeaf
    place: str
    owner: StateRef
    timed: bool
    """A `timeout` of the tree around it bounds it."""


class MissionIndex:
    """The mission laid out.

    Args:
        mission: The mission.
        predicates: The names of the registered predicates; None if they are not known yet.
    """

    def __init__(self, mission: Mission, predicates: Collection[str] | None = None) -> None:
        self.mission, self.predicates = mission, predicates
        self.spots: list[StateRef] = []
        """In document order."""
        self.top: list[StateRef] = []
        self.rows: list[TransitionRef] = []
        self.guards: list[GuardUse] = []
        self.parts: list[tuple[str, Guard, GuardUse]] = []
        """Every guard and all inside it: its place, itself, and the whole."""
        self.effects: list[EffectUse] = []
        self.reads: list[Read] = []
        self.writes: list[KeyWrite] = []
        self.works: list[Work] = []
        self.planted: list[tuple[StateRef, NodeRef]] = []
        self.asked: list[tuple[DecisionSpec, str, StateRef]] = []
        """Each decision, of a state or a leaf."""
        self.remembered: dict[str, object] = {}
        """What rules work out once and share."""
        self._place(mission.states, "/states", None)
        self.by_name: dict[str, StateRef] = {}
        for spot in self.spots:
            self.by_name.setdefault(spot.name, spot)
        self.states = Lexicon("state", self.by_name)
        self.keys = Lexicon("key", mission.blackboard, "declare it under /blackboard")
        self.events = Lexicon("event", (*mission.events, *BUILT_IN_EVENTS), "declare it under /events")
        for spot in self.spots:
            self._look(spot)
        self._rows(mission.transitions, "", None)
        for name, guard in mission.invariants.items():
            self._guard(guard, pointer("/invariants", name), "invariant", Scope())

    def _place(self, states: Mapping[str, State], place: str, parent: StateRef | None) -> None:
        for name, state in states.items():
            spot = StateRef(name, pointer(place, name), state, parent, len(self.spots))
            self.spots.append(spot)
            (self.top if parent is None else parent.children).append(spot)
            children = state.children()
            if children:
                self._place(children, f"{spot.place}/{state.child_place()}", spot)
                spot.last = len(self.spots) - 1

    # -- names --------------------------------------------------------------------------------------------------------

    def spot(self, name: str) -> StateRef | None:
        """The state of a name, or the one that a misspelled name was meant for."""
        meant = self.states.meant(name)
        return None if meant is None else self.by_name[meant]

    def found(self, names: Iterable[str]) -> list[StateRef]:
        """The states of the names, as far as there are any."""
        return [spot for name in names if (spot := self.spot(name)) is not None]

    # -- looking ------------------------------------------------------------------------------------------------------

    def _look(self, spot: StateRef) -> None:
        state, scope = spot.state, Scope(spot)
        for word, effects in (("entry", state.entry), ("exit", state.exit)):
            self._effects(effects, f"{spot.place}/{word}", scope)
        self._rows(state.transitions, spot.place, spot)
        if isinstance(state, Action | Call):
            self._work(state, spot.place, scope, timed=False)
        elif isinstance(state, Decision):
            self._asked(state.decision, f"{spot.place}/decision", scope)
        elif isinstance(state, Tree):
            for planted in tree_nodes(state.tree, f"{spot.place}/tree"):
                self.planted.append((spot, planted))
                self._node(planted, Scope(spot, option=planted.option))
        elif isinstance(state, Each):
            self.reads.append(Read(state.each, f"{spot.place}/each", scope))
            self.writes.append(KeyWrite(state.item, f"{spot.place}/as", "each", state.each, scope))
        elif isinstance(state, Final) and state.requires is not None:
            self._guard(state.requires, f"{spot.place}/requires", "requires", scope)
        elif isinstance(state, Include):
            self._template(state.with_, f"{spot.place}/with", scope)

    def _node(self, planted: NodeRef, scope: Scope) -> None:
        node, place = planted.node, planted.place
        if isinstance(node, ActionLeaf | CallLeaf):
            self._work(node, place, scope, timed=planted.timed)
        elif isinstance(node, CheckLeaf):
            self._guard(node.check, f"{place}/check", "tree", scope)
        elif isinstance(node, EternalGuard):
            self._guard(node.guard, f"{place}/eternal_guard", "tree", scope)
        elif isinstance(node, SetLeaf):
            self._effects((node.effect(),), "", scope, (place,))
        elif isinstance(node, StatusToBlackboard):
            self.writes.append(KeyWrite(node.key, f"{place}/{node.word}", "status", None, scope))
        elif isinstance(node, PublishLeaf):
            self._template(node.message, f"{place}/message", scope)
        elif isinstance(node, DecisionLeaf):
            self._asked(node.decision, f"{place}/decision", scope)

    def _work(self, work: Action | Call | ActionLeaf | CallLeaf, place: str, scope: Scope, *, timed: bool) -> None:
        assert scope.owner is not None
        self.works.append(Work(work, place, scope.owner, timed))
        if isinstance(work, Action | ActionLeaf):
            self._template(work.goal, f"{place}/goal", scope)
            if work.achieved is not None:
                self._guard(work.achieved, f"{place}/achieved", "achieved", scope)
        else:
            self._template(work.request, f"{place}/request", scope)
        for key, field in work.result.items():
            self.writes.append(KeyWrite(key, pointer(place, "result", key), "result", field, scope))

    def _asked(self, asked: DecisionSpec, place: str, scope: Scope) -> None:
        assert scope.owner is not None
        self.asked.append((asked, place, scope.owner))
        for index, path in enumerate(asked.evidence):
            self.reads.append(Read(path, f"{place}/evidence/{index}", scope))
        for name, guard in asked.guards():
            self._guard(guard, pointer(place, "options", name, "when"), "option", scope)

    def _rows(self, transitions: Iterable[Transition], place: str, owner: StateRef | None) -> None:
        for index, transition in enumerate(transitions):
            row = TransitionRef(owner, f"{place}/transitions/{index}", transition)
            self.rows.append(row)
            if owner is not None:
                owner.rows.append(row)
            scope = Scope(owner, row)
            if transition.when is not None:
                self._guard(transition.when, f"{row.place}/when", "row", scope)
            self._effects(transition.do, f"{row.place}/do", scope)

    def _guard(self, guard: Guard, place: str, role: str, scope: Scope) -> None:
        ruled = GuardUse(guard, place, role, scope)
        self.guards.append(ruled)
        for here, part in guard_parts(guard, place):
            self.parts.append((here, part, ruled))
            self.reads += [Read(each.name, each.place, scope) for each in part.references(here) if each.refers is PATH]

    def _template(self, template: Mapping[str, Any], place: str, scope: Scope) -> None:
        self.reads += [Read(path, here, scope) for path, here in template_reads(template, place)]

    def _effects(self, effects: Iterable[Effect], place: str, scope: Scope, places: tuple[str, ...] = ()) -> None:
        for index, effect in enumerate(effects):
            here = places[index] if places else f"{place}/{index}"
            self.effects.append(EffectUse(effect, here, scope))
            if isinstance(effect, Set):
                self._set(effect, here, scope)
            elif isinstance(effect, Raise):
                self._template(effect.data, f"{here}/data", scope)
            elif isinstance(effect, CallEffect):
                self._template(effect.request, f"{here}/request", scope)
            elif isinstance(effect, Publish):
                self._template(effect.message, f"{here}/message", scope)

    def _set(self, effect: Set, place: str, scope: Scope) -> None:
        if effect.add is not None:
            self.writes.append(KeyWrite(effect.set, place, "add", effect.add, scope))
        elif effect.source is not None:
            self.writes.append(KeyWrite(effect.set, place, "from", effect.source, scope))
            word = "from" if effect.from_ is not None else "value/from"
            self.reads.append(Read(effect.source, f"{place}/{word}", scope))
        else:
            self.writes.append(KeyWrite(effect.set, place, "set", effect.value, scope))
            self.reads += [Read(path, here, scope) for path, here in template_reads(effect.value, f"{place}/value")]
