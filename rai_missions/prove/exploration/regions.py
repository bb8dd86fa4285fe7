# SPDX-License-Identifier: Apache-2.0
"""Which regions of a parallel state look at each other: those that do not are explored part by part.

Rule: two regions are in one group if anything but the mission's own keys connects them. Where that is not known for
certain, they are in one group, or the parallel state is explored as a whole.

What connects regions is found in the text of a mission: a name that appears in two of them (a state, an event, a key
that the robot reports), actions that exclude each other. Keys of the mission itself connect none: what a step asks of
them, and writes, is noted as it is made (`store`, `wakes`). Nor does a rule around them that names states of both: one
that an event fires makes each step rest on both (`named`), one that waits is woken by what it watches (`outside`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.activities.activity import GOALS
from rai_missions.engine.compiled.states import CompiledGuard, CompiledState, CompiledTransition
from rai_missions.engine.state import TimerKey
from rai_missions.guards.view import presence
from rai_missions.mission.mission import BUILT_IN_EVENTS
from rai_missions.prove.abstraction.open_world import OpenWorld
from rai_missions.prove.analysis.parts import guards_in, own_parts, parts, texts_in
from rai_missions.prove.stimulus import Stimulus
from rai_missions.states.action import Action
from rai_missions.states.effects import Raise
from rai_missions.states.transition import ANY_EVENT
from rai_missions.states.tree.leaves import ActionLeaf

__all__ = ("OUTSIDE", "TIME", "RegionGroups", "Regions")

TIME = "#time"
"""Something may go stale, or have lasted for long enough, at the instant at which something else has expired."""
ANY_KEY = "*"
OUTSIDE, OF_GOALS = -1, -2
"""In place of a group: what concerns the mission around the regions, and goals that nothing pursues."""


class RegionGroups(NamedTuple):
    """A parallel state whose regions are explored part by part."""

    node: CompiledState
    group_of: Mapping[str, int]
    """State inside it → its group."""
    members: tuple[tuple[CompiledState, ...], ...]
    """Of each group its regions."""
    key_of: Mapping[str, int]
    """Key that the robot reports → the group that reads it."""
    events: Mapping[str, int]
    """Event → the group that has transitions for it; of what rules outside handle, `OUTSIDE`."""
    handlers: Mapping[str, frozenset[int]]
    """Event → the groups in whose text it appears."""
    outside: Mapping[int, frozenset[str]]
    """Group → what wakes the rules around it that name its states."""
    named: frozenset[int]
    """The groups whose states are named by rules around them that an event fires, or whose events these raise."""
    trees: frozenset[int]
    """The groups that have trees."""

    @property
    def every(self) -> frozenset[int]:
        """All groups."""
        return frozenset(range(len(self.members)))


class ParallelTexts(NamedTuple):
    """A parallel state as it is read, before its regions are in groups."""

    node: CompiledState
    region_of: Mapping[str, int]
    """State inside it → its region."""
    texts: tuple[frozenset[str], ...]
    """Of each region its words."""
    waiting: Sequence[CompiledGuard]
    """The guards around it that may fire without an event."""
    firing: Sequence[CompiledTransition]
    """The guarded transitions around it."""


class Regions:
    """The parallel states of a mission that are explored part by part.

    Args:
        chart: The mission.
        world: What the surroundings can be.
    """

    def __init__(self, chart: Chart, world: OpenWorld) -> None:
        self._chart, self._world = chart, world
        graph, mission = chart.program.graph, chart.mission
        self._events = frozenset(mission.events).union(BUILT_IN_EVENTS)
        is_plain = not (
            graph.controls
            or world.predicates
            or mission.uses
            or world.own_fade
            or world.doubts
            or any(node.is_history for node in graph.order)
        )
        found = [self._parallel(node) for node in graph.order if is_plain and _is_outermost(node)]
        self.parallels: dict[CompiledState, RegionGroups] = {each.node: each for each in found if each is not None}
        self.tokens = self._tokens()
        """What a step may wake others by; nothing waits for anything else."""

    def _tokens(self) -> Mapping[str, int]:
        """Token → its bit; of states those that guards name."""
        mission, facts = self._chart.mission, self._chart.robot_facts
        guards = guards_in((mission, facts.succeeded, facts.failed))
        states = {presence(name) for guard in guards for name in guard.states()}
        tokens = (TIME, GOALS, ANY_KEY, *sorted(mission.blackboard), *sorted(states))
        return {token: 1 << at for at, token in enumerate(tokens)}

    def named_by(self, node: CompiledState) -> Iterator[str]:
        """The keys and states that the guards of a state name."""
        for guard in guards_in(own_parts(node.state)):
            yield from (path.split(".")[0] for path in guard.paths())
            yield from map(presence, guard.states())

    def mask(self, tokens: Iterable[str]) -> int:
        """Tokens as bits; of any key also the bit of what waits for any."""
        found = 0
        for token in tokens:
            found |= self.tokens.get(token, 0)
            if not token.startswith("#"):
                found |= self.tokens[ANY_KEY]
        return found

    # -- groups ---------------------------------------------------------------------------------------------------

    def _parallel(self, node: CompiledState) -> RegionGroups | None:
        """The groups of a parallel state; None where it is explored as a whole."""
        regions, inside = node.children, [each for each in self._chart.program.graph.order if each.inside(node)]
        waiting = [*self._waiting(node), *(condition for _, condition in self._chart.program.invariants)]
        fleeting = self._world.fleeting
        if any(each.is_each for each in inside) or any(not each.reads.isdisjoint(fleeting) for each in waiting):
            return None
        region_of = {
            each.name: at for at, top in enumerate(regions) for each in inside if each is top or each.inside(top)
        }
        texts = tuple(frozenset(self._text(top)) for top in regions)
        firing = [each for each in _transitions(node) if each.condition is not None]
        read = ParallelTexts(node, region_of, texts, waiting, firing)
        groups = self._joined(read)
        return self._grouped(read, groups) if len(groups) > 1 else None

    def _joined(self, read: ParallelTexts) -> list[list[int]]:
        """The regions that are in one group."""
        leads = JoinedNumbers(len(read.texts))
        for token in (*self._events, *self._world.fleeting, *read.region_of):  # they connect wherever two have them
            leads.join(at for at, text in enumerate(read.texts) if token in text or read.region_of.get(token) == at)
        actions = [_actions(top) for top in read.node.children]
        for at, some in enumerate(actions):
            leads.join(
                other
                for other, others in enumerate(actions)
                if other == at or any(self._chart.robot_facts.conflict(one, two) for one in some for two in others)
            )
        return leads.groups()

    def _grouped(self, read: ParallelTexts, groups: list[list[int]]) -> RegionGroups:
        """What concerns which of the groups."""
        node, texts = read.node, read.texts
        number = {at: group for group, members in enumerate(groups) for at in members}
        group_of = {name: number[at] for name, at in read.region_of.items()}
        around = [
            *self._chart.mission.transitions,
            *(part for each in (node, *node.ancestors) for part in own_parts(each.state)),
        ]
        outer = frozenset(_names(around))
        key_of = {
            key: number[at] for key in sorted(self._world.fleeting) for at, text in enumerate(texts) if key in text
        }
        handlers = {
            event: frozenset(number[at] for at, text in enumerate(texts) if event in text) for event in self._events
        }
        fired = {event for each in _transitions(node) for event in each.definition.on}
        is_any = ANY_EVENT in fired
        events = {
            event: OUTSIDE if is_any or event in fired or len(some) != 1 else min(some)
            for event, some in handlers.items()
        }
        around_raise = {each.event for each in parts(around, Raise)} | (outer - fired)
        named = {group_of[name] for each in read.firing for name in _states(each.condition) if name in group_of}
        named |= {group for key, group in key_of.items() if key in outer}
        named |= {group for event, some in handlers.items() if event in around_raise for group in some}
        outside = {
            group: frozenset().union(
                *(each.watched for each in read.waiting if any(group_of.get(name) == group for name in _states(each)))
            )
            for group in range(len(groups))
        }
        trees = {group_of[name] for name in read.region_of if self._has_tree(name)}
        members = tuple(tuple(node.children[at] for at in each) for each in groups)
        return RegionGroups(
            node, group_of, members, key_of, events, handlers, outside, frozenset(named), frozenset(trees)
        )

    def _has_tree(self, name: str) -> bool:
        state = self._chart.program.graph.nodes[name].state
        return state is not None and state.root() is not None

    def _text(self, top: CompiledState) -> Iterator[str]:
        """Every word of a region, with what a profile adds to its actions."""
        words = set(_names(top.state))
        facts = self._chart.robot_facts
        for action in _actions(top):
            words |= set(_names([facts.succeeded.get(action), facts.failed.get(action)]))
        yield from words
        if ANY_EVENT in words:
            yield from self._events

    def _waiting(self, node: CompiledState) -> Iterator[CompiledGuard]:
        """The guards of rules around a parallel state that may fire without an event."""
        for each in _transitions(node):
            if each.condition is not None and (each.definition.eventless or each.condition.held_guards):
                yield each.condition

    # -- what concerns whom ---------------------------------------------------------------------------------------

    def scope(self, parallel: RegionGroups, happening: Stimulus, owner: str) -> int:
        """The group that something concerns; `OUTSIDE` for all else.

        Args:
            parallel: What is active.
            happening: What can happen.
            owner: The state whose goal, call, question or behaviour it is about.
        """
        if happening.is_of_goal:
            return OF_GOALS
        if happening.timer is not None:
            owner = self.timer_owner(happening.timer[0])
        elif happening.event:
            return parallel.events.get(happening.event, OUTSIDE)
        elif happening.key:
            return parallel.key_of.get(happening.key, OUTSIDE)
        owner = owner.partition("#")[0] or happening.owner
        return parallel.group_of.get(owner, OUTSIDE)

    def timer_owner(self, key: TimerKey) -> str:
        """The state to which a timer belongs; empty for that of an event that is raised later."""
        kind, which = key
        if kind == "after":
            return self._chart.program.graph.transitions[which].source.name
        return str(which) if kind == "timeout" else ""

    def concerned(self, parallel: RegionGroups, happening: Stimulus, scope: int) -> frozenset[int]:
        """The groups that something may look at, whatever it wakes."""
        looking = parallel.named | parallel.trees if happening.is_tick else parallel.named
        if scope >= 0:
            return looking | {scope}
        if happening.event:
            return looking | parallel.handlers.get(happening.event, frozenset())
        if happening.is_tick and happening.kind == "write":
            return looking
        if happening.kind in ("time", "robot") or happening.is_cancel:
            built_in = (parallel.handlers.get(event, frozenset()) for event in BUILT_IN_EVENTS)
            return looking.union(*built_in)
        return parallel.every


class JoinedNumbers:
    """Numbers that are joined into groups.

    Args:
        many: How many there are.
    """

    def __init__(self, many: int) -> None:
        self._lead = list(range(many))

    def join(self, some: Iterable[int]) -> None:
        """Put regions into one group."""
        found = {self._lead[each] for each in some}
        if found:
            self._lead = [min(found) if each in found else each for each in self._lead]

    def groups(self) -> list[list[int]]:
        """Each group, ascending."""
        return [[at for at, lead in enumerate(self._lead) if lead == first] for first in sorted(set(self._lead))]


def _is_outermost(node: CompiledState) -> bool:
    return node.is_parallel and not any(each.is_parallel or each.is_each for each in node.ancestors)


def _transitions(node: CompiledState) -> list[CompiledTransition]:
    """The transitions of a state and of those around it."""
    return [transition for each in (node, *node.ancestors) for transition in each.transitions]


def _states(condition: CompiledGuard | None) -> frozenset[str]:
    if condition is None:
        return frozenset()
    return frozenset(name for guard in condition.guard.walk() for name in guard.states())


def _actions(top: CompiledState) -> frozenset[str]:
    return frozenset(each.action for kind in (Action, ActionLeaf) for each in parts(top.state, kind))


def _names(value: Any) -> Iterator[str]:
    """Every text in a part of a mission; of a path also the key that it begins with."""
    for text in texts_in(value):
        yield text
        if "." in text:
            yield text.partition(".")[0]
