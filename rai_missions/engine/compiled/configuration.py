# SPDX-License-Identifier: Apache-2.0
"""A set of active states, what can happen in it, and what was worked out of that so far."""

from __future__ import annotations

import math
from bisect import bisect_left, bisect_right
from collections.abc import Iterable
from functools import cached_property
from operator import attrgetter
from typing import Any

from rai_missions.engine.compiled.states import Act, CompiledState, CompiledTransition, Write, WriteAct
from rai_missions.engine.step import Move
from rai_missions.guards.view import Test, Truth
from rai_missions.states.transition import ANY_EVENT

__all__ = (
    "CompiledMove",
    "Configuration",
    "DirectMove",
    "Looked",
    "Plan",
    "exchanged",
    "innermost",
    "inside",
    "leaves",
    "ordered",
)

_index, _name, _control, _watches = map(attrgetter, ("index", "name", "control", "watches"))

Plan = tuple[tuple[CompiledTransition, ...], ...]
"""Chains of transitions: of each the first fires whose guard is true."""


class CompiledMove:
    """What taking certain transitions in a configuration does: a `Move` and all that the chart needs to make it."""

    __slots__ = (
        "acts", "config", "entered", "exited", "lists", "plain", "remember", "shifts", "value", "values", "write",
    )  # fmt: skip

    def __init__(self, value: Move, config: Configuration, acts: tuple[Act, ...]) -> None:
        self.value, self.values, self.config, self.acts = value, (value,), config, acts
        only = acts[0] if len(acts) == 1 else None
        self.write: Write | None = only.write if isinstance(only, WriteAct) else None
        """Does what `acts` do, where that is one write and no one watches keys."""
        self.exited: tuple[CompiledState, ...] = ()
        self.entered: tuple[CompiledState, ...] = ()
        self.remember: tuple[tuple[int, tuple[CompiledState, ...]], ...] = ()
        """History state and what it leads back to from now on."""
        self.lists: tuple[tuple[CompiledState, CompiledState], ...] = ()
        """History state and each `each` that it leads back into from now on."""
        self.shifts: frozenset[str] = frozenset()
        """The states that it makes active or inactive, by their `presence`."""
        self.plain = False
        """Nothing but the move and its acts: no timer, activity, final, history, or transition without an event.

        `Chart.send` makes such a move by itself, without `macrostep.make_move`: what must happen at each entry or exit
        has to be done in both places.
        """


Looked = tuple[tuple[str, Truth], ...]
"""JSON pointers of guards that were looked at, and their truth."""
DirectMove = tuple[Test | None, Looked, CompiledMove]
"""The guard of the transition, if it has one, what a step notes of it where it is true, and what taking it does."""


class Configuration:
    """A set of active states, and what can happen in it.

    Rule: what is made here at once costs as much as changes; of many regions one configuration a microstep is made.
    """

    __slots__ = (
        "__dict__", "atomic", "direct", "eventless", "held_guards", "instants", "moves", "order", "plans", "reads",
        "watchful",
    )  # fmt: skip

    def __init__(self, atomic: tuple[CompiledState, ...], order: tuple[CompiledState, ...]) -> None:
        self.atomic = atomic
        """The innermost active states, in document order."""
        self.order = order
        """All active states and the root, in document order."""
        self.plans: dict[str, Plan] = {}
        self.moves: dict[Any, CompiledMove] = {}
        self.direct: dict[str, DirectMove] = {}
        """An event that makes the same plain move whenever it makes one → that move; of the events so far."""
        watching = [*filter(_watches, order)]
        self.eventless = self._chains(None, declared=False) if watching else ()
        transitions = [each for node in watching for each in node.transitions]
        guarded = [(each.condition, each.definition.eventless) for each in transitions if each.condition is not None]
        self.held_guards = {memory: test for condition, _ in guarded for memory, test in condition.held_guards.items()}
        looked_at = [condition for condition, eventless in guarded if eventless or condition.held_guards]
        self.reads = frozenset[str]().union(*(condition.reads for condition in looked_at))
        self.instants = tuple(instant for condition in looked_at for instant in condition.instants)
        self.watchful = bool(self.eventless or self.held_guards)

    @cached_property
    def key(self) -> tuple[int, ...]:
        """The indices of the innermost states: equal for equal configurations, also those of another chart."""
        return tuple(map(_index, self.atomic))

    def is_active(self, node: CompiledState) -> bool:
        """Whether a state is active; the root is."""
        at = bisect_left(self.order, node.index, key=_index)
        return at < len(self.order) and self.order[at] is node

    @cached_property
    def nodes(self) -> frozenset[CompiledState]:
        """All active states and the root."""
        return frozenset(self.order)

    @cached_property
    def active(self) -> frozenset[str]:
        """The names of the active states, ancestors included."""
        return frozenset(map(_name, self.order[1:]))

    @cached_property
    def controls(self) -> frozenset[str]:
        """Whose control the active states need."""
        found: frozenset[str | None] = frozenset(map(_control, self.order))
        return frozenset(each for each in found if each is not None)

    def forget(self) -> None:
        """Drop the moves that were worked out; they lead round in circles, which only a search for garbage finds."""
        self.moves.clear()
        self.direct.clear()

    def plan(self, event: str, *, declared: bool) -> Plan:
        """The transitions that an event may fire, a tuple an innermost state, in the order in which they are tried."""
        plan = self.plans[event] = self._chains(event, declared=declared)
        return plan

    def _chains(self, event: str | None, *, declared: bool) -> Plan:
        """The transitions that an event may fire, or those that need no event: one chain an innermost state."""
        found = [_chain(node, event, declared=declared) for node in self.atomic]
        return tuple([chain for chain in found if chain])

    def outcome_plan(self, source: CompiledState, outcome: str, *, option: bool, climbs: bool, is_late: bool) -> Plan:
        """The transitions for an outcome: those of its own state, of its ancestors if it climbs, or that name it.

        Once its state was left, only those that name it: they wait for the event, as in SCXML, and not on the state.
        """
        owners = () if is_late else (source, *source.ancestors) if climbs and not option else (source,)
        own = [each for node in owners for each in node.transitions if each.definition.of is None]
        wanted = {each for each in (*own, *source.of_it) if outcome in each.outcomes}
        tops = {each.source for each in wanted if self.is_active(each.source)}
        atomic = {each for top in tops for each in inside(self.atomic, top) or (top,)}
        chains = (
            tuple([each for owner in (node, *node.ancestors) for each in owner.transitions if each in wanted])
            for node in sorted(atomic, key=_index)
        )
        return tuple([chain for chain in chains if chain])


def inside(nodes: tuple[CompiledState, ...], domain: CompiledState | None) -> tuple[CompiledState, ...]:
    """The states inside a domain, of some in document order; empty without a domain."""
    if domain is None:
        return ()
    first, end = (bisect_right(nodes, index, key=_index) for index in (domain.index, domain.last))
    return nodes[first:end]


def exchanged(
    nodes: tuple[CompiledState, ...], out: Iterable[CompiledState], into: Iterable[CompiledState]
) -> tuple[CompiledState, ...]:
    """Some states in document order without some of them, and with others."""
    found = [*nodes]
    for node in out:
        at = bisect_left(found, node.index, key=_index)
        if at < len(found) and found[at] is node:
            del found[at]
    for node in into:
        at = bisect_left(found, node.index, key=_index)
        if at == len(found) or found[at] is not node:
            found.insert(at, node)
    return tuple(found)


def innermost(order: tuple[CompiledState, ...], nodes: Iterable[CompiledState]) -> list[CompiledState]:
    """The given states that occur in `order` and contain no other state of it; both are in document order."""
    found, end = [], len(order)
    for node in nodes:
        at = bisect_left(order, node.index, key=_index)
        if at < end and order[at] is node and (at + 1 == end or order[at + 1].index > node.last):
            found.append(node)
    return found


def ordered(nodes: Iterable[CompiledState]) -> tuple[CompiledState, ...]:
    """States in document order."""
    return tuple(sorted(nodes, key=_index))


def leaves(order: tuple[CompiledState, ...]) -> tuple[CompiledState, ...]:
    """The innermost of all that is active, the root before it: none are where the root is alone."""
    following = (*map(_index, order[2:]), math.inf)
    return tuple([node for node, after in zip(order[1:], following, strict=False) if after > node.last])


def _chain(node: CompiledState, event: str | None, *, declared: bool) -> tuple[CompiledTransition, ...]:
    """What an event, or no event, may fire of a state's transitions and its ancestors', innermost first."""
    found = node.chains.get(event)
    if found is None:

        def wanted(transition: CompiledTransition) -> bool:
            on = transition.definition.on
            if event is None:
                return transition.definition.eventless
            return (event in on and event not in transition.outcomes) or (declared and ANY_EVENT in on)

        found = tuple(
            transition for each in (node, *node.ancestors) for transition in each.transitions if wanted(transition)
        )
        if declared or event is None:  # any other word comes from outside, and there is no end of them
            node.chains[event] = found
    return found
