# SPDX-License-Identifier: Apache-2.0
"""A mission laid out for the rules: each state, transition, guard, effect, read and write once, with its place.

Rule: whatever two rules need is worked out here, in one walk; a rule never walks the mission itself. What a kind refers
to and holds is in the annotations of its fields: no kind is picked out here.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Iterator, Mapping, Sequence
from functools import cache, cached_property
from typing import Any, NamedTuple

from rai_missions.check.name_table import NameTable
from rai_missions.check.pointers import guard_parts
from rai_missions.errors import escaped, unescaped
from rai_missions.guards import Guard
from rai_missions.mission.mission import BUILT_IN_EVENTS, Mission
from rai_missions.model import MissionModel
from rai_missions.model.references import INTERFACES, TEMPLATE, Interface, fields_of
from rai_missions.states import DecisionSpec, Option, State, Transition
from rai_missions.states.effects import Effect
from rai_missions.states.tree import TreeNode

__all__ = (
    "EffectUse", "GuardUse", "KeyWrite", "MissionIndex", "PathUse", "RobotUse", "Scope", "StateRef", "TransitionRef",
)  # fmt: skip


class StateRef:
    """A state where it is: its place, its parent, and the span of the states inside it."""

    __slots__ = ("children", "control", "index", "last", "name", "options", "parent", "place", "state", "transitions")

    def __init__(self, name: str, place: str, state: State, parent: StateRef | None, index: int) -> None:
        self.name, self.place, self.state, self.parent, self.index = name, place, state, parent, index
        self.last = index
        """The index of the last state inside it."""
        self.children: list[StateRef] = []
        self.transitions: list[TransitionRef] = []
        self.options = state.options
        """The answers that are outcomes of its own."""
        self.control: str | None = state.control or (parent.control if parent is not None else None)
        """Whose control it needs, itself or what it is inside of."""

    def inside(self, other: StateRef | None) -> bool:
        """Whether it is a proper descendant of another; everything is inside the mission (None)."""
        return other is None or other.index < self.index <= other.last

    def upward(self) -> Iterator[StateRef]:
        """This state and its ancestors, innermost first."""
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
    definition: Transition
    targets: Sequence[StateRef]
    """Where it leads, as far as there are such states."""


class Scope(NamedTuple):
    """What is around a read: whose it is, and what `event.…` and `answer.…` can mean there."""

    owner: StateRef | None = None
    transition: TransitionRef | None = None
    option: Option | None = None
    """The option in whose subtree of a tree it is."""
    timed: bool = False
    """A `timeout` of the tree around it bounds it."""


class PathUse(NamedTuple):
    """A path that something looks at."""

    path: str
    place: str
    scope: Scope


class KeyWrite(NamedTuple):
    """A key that something writes: a `KeyValue`, and what is around it."""

    key: str
    place: str
    by: str
    value: Any
    scope: Scope


class GuardUse(NamedTuple):
    """A guard where it is."""

    guard: Guard
    place: str
    role: str
    """The field that holds it: `when`, `achieved`, `requires`, `invariants`, …"""
    scope: Scope


class EffectUse(NamedTuple):
    """An effect where it is."""

    effect: Effect
    place: str
    scope: Scope


class RobotUse(NamedTuple):
    """An action, a service or a topic of the robot, and what uses it: a state, a leaf or an effect."""

    sort: Interface
    name: str
    named_at: str
    """The place of the name."""
    user: Any
    place: str
    scope: Scope


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
        self.transitions: list[TransitionRef] = []
        self.guards: list[GuardUse] = []
        self.parts: list[tuple[str, Guard, GuardUse]] = []
        """Every guard and all inside it: its place, itself, and the whole."""
        self.effects: list[EffectUse] = []
        self.reads: list[PathUse] = []
        self.writes: list[KeyWrite] = []
        self.uses: list[RobotUse] = []
        self.templates: list[tuple[Any, str]] = []
        """Each goal, request, message, payload and value, and its place."""
        self.nodes: list[tuple[TreeNode, str]] = []
        """Every node of a tree, outer before inner."""
        self.state_names: list[tuple[str, str]] = []
        """The place of each name of a state, and the name."""
        self.asked: list[tuple[DecisionSpec, str, StateRef]] = []
        """Each decision, of a state or a leaf."""
        self.remembered: dict[str, object] = {}
        """What rules work out once and share."""
        self._place(mission.states, "/states", None)
        self.by_name: dict[str, StateRef] = {}
        for spot in self.spots:
            self.by_name.setdefault(spot.name, spot)
        self.states = NameTable("state", self.by_name)
        self.keys = NameTable("key", mission.blackboard, "declare it under /blackboard")
        self.events = NameTable("event", (*mission.events, *BUILT_IN_EVENTS), "declare it under /events")
        self._at = {spot.place: spot for spot in self.spots}
        self._look(mission, "", Scope())

    def _place(self, states: Mapping[str, State], place: str, parent: StateRef | None) -> None:
        for name, state in states.items():
            spot = StateRef(name, f"{place}/{escaped(name)}", state, parent, len(self.spots))
            self.spots.append(spot)
            (self.top if parent is None else parent.children).append(spot)
            children = state.children()
            if children:
                self._place(children, f"{spot.place}/{state.child_place()}", spot)
                spot.last = len(self.spots) - 1

    # -- names --------------------------------------------------------------------------------------------------------

    def spot(self, name: str) -> StateRef | None:
        """The state of a name, or the one that a misspelled name was meant for."""
        known = self.by_name.get(name)
        if known is not None:
            return known
        meant = self.states.meant(name)
        return None if meant is None else self.by_name[meant]

    def found(self, names: Iterable[str]) -> list[StateRef]:
        """The states of the names, as far as there are any."""
        return [spot for name in names if (spot := self.spot(name)) is not None]

    @cached_property
    def lasting_keys(self) -> frozenset[str]:
        """See `Mission.lasting_keys`."""
        return self.mission.lasting_keys()

    # -- looking ------------------------------------------------------------------------------------------------------

    def _look(self, thing: MissionModel, place: str, scope: Scope) -> None:
        """Note what a written thing refers to, and what is inside it."""
        self._refer(thing, place, scope)
        for use in fields_of(type(thing)):
            if use.hint == TEMPLATE:
                self.templates.append((getattr(thing, use.name), f"{place}/{use.word}"))
        for written in thing.writes(place):
            self.writes.append(KeyWrite(*written, scope))
        for here, inner in thing.inside(place):
            self._held(inner, here, scope, thing, place)

    def _refer(self, thing: MissionModel, place: str, scope: Scope) -> None:
        for refers, name, here in thing.references(place):
            if refers.sort == "path":
                self.reads.append(PathUse(name, here, scope))
            elif refers.sort == "state":
                self.state_names.append((here, name))
            elif refers.sort in INTERFACES:
                self.uses.append(RobotUse(refers.sort, name, here, thing, place, scope))

    def _held(self, thing: Any, place: str, scope: Scope, holder: MissionModel, around: str) -> None:
        """Note a written thing by its family, then what is inside it; `around` is the place of what holds it."""
        kind: Any = type(thing)
        family = _family(kind)
        if family is Transition:
            scope = self._transition(thing, place, scope.owner)
        elif family is State:
            scope = Scope(self._at[place])
        elif isinstance(holder, TreeNode):
            scope = _below(holder, place[len(around) + 1 :], scope)
        if family is Guard:
            self._guard(thing, place, place[len(around) + 1 :].partition("/")[0], scope)
            return
        if family is Effect:
            self.effects.append(EffectUse(thing, place, scope))
        elif family is DecisionSpec:
            assert scope.owner is not None
            self.asked.append((thing, place, scope.owner))
        elif family is TreeNode:
            self.nodes.append((thing, place))
        self._look(thing, place, scope)

    def _transition(self, definition: Transition, place: str, owner: StateRef | None) -> Scope:
        transition = TransitionRef(owner, place, definition, self.found(definition.to))
        self.transitions.append(transition)
        if owner is not None:
            owner.transitions.append(transition)
        return Scope(owner, transition)

    def _guard(self, guard: Guard, place: str, role: str, scope: Scope) -> None:
        use = GuardUse(guard, place, role, scope)
        self.guards.append(use)
        for here, part in guard_parts(guard, place):
            self.parts.append((here, part, use))
            self._refer(part, here, scope)


@cache
def _family(kind: Any) -> Any:
    """What a written thing of a type is noted as; None for any other."""
    families = (Guard, State, Transition, Effect, DecisionSpec, TreeNode)
    return next((family for family in families if issubclass(kind, family)), None)


def _below(node: TreeNode, branch: str, scope: Scope) -> Scope:
    """The scope of what is under a branch of a tree's node."""
    option = node.option_of(unescaped(branch))
    return scope._replace(option=option or scope.option, timed=scope.timed or node.limits)
