# SPDX-License-Identifier: Apache-2.0
"""A state of a run taken apart, into a part for each group of regions and all that is left, and put together again.

Rule: a part holds what belongs to states of its regions, by name; whatever cannot be attributed to one is left in the
frame. So two states are the same exactly where frame, parts and store are the same.
"""

from __future__ import annotations

from collections import defaultdict
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.activities.tree import TreeActivity
from rai_missions.engine.compiled.configuration import Configuration
from rai_missions.engine.compiled.graph import is_done
from rai_missions.engine.compiled.states import CompiledState
from rai_missions.engine.semantics.handover import is_kept
from rai_missions.engine.state import TABLE, FieldKind, RunState, copied
from rai_missions.prove.abstraction.abstraction import Abstraction
from rai_missions.prove.abstraction.activity_key import waits_for_time
from rai_missions.prove.abstraction.open_world import OpenWorld
from rai_missions.prove.abstraction.state_key import Ahead, Place, SavedState, StateCodec
from rai_missions.prove.abstraction.store import Store, fingerprint
from rai_missions.prove.analysis.branches import Groups, groups_key
from rai_missions.prove.exploration.regions import TIME, RegionGroups, Regions

__all__ = ("Part", "PartedState", "RegionParts", "StateFrame")

PARTED: tuple[FieldKind, ...] = ("activities", "settling", "ages", "since", "timers", "goals", "board")
"""What is divided among the groups, entry by entry."""
IN_ORDER: tuple[FieldKind, ...] = ("activities", "settling")
"""The fields in which the order of the entries of several groups makes a difference."""


class PartedState(NamedTuple):
    """A state of a run but for its store: the numbers of its frame and of each part."""

    frame: int
    parts: tuple[int, ...]

    def moved(self, frame: int, changed: Iterable[tuple[int, int]]) -> PartedState:
        """The one with another frame and some other parts."""
        parts = [*self.parts]
        for group, part in changed:
            parts[group] = part
        return PartedState(frame, tuple(parts))


class Part(NamedTuple):
    """What belongs to a group of regions."""

    atomic: tuple[CompiledState, ...]
    """Its innermost active states."""
    fields: Mapping[str, Mapping[Any, Any]]
    """Field of a run → its entries."""
    groups: Mapping[str, Groups]
    """Tree → the groups of its waits."""
    wakes: int
    """What it waits for, as bits: see `Regions.tokens`."""
    is_quiet: bool
    """Leaving it does nothing: nothing runs or is known in it, and no state has an `exit`."""
    runs: tuple[bool, bool]
    """Something runs in it that a pause leaves as it is, or a tree."""
    is_ended: bool
    """Each of its regions has come to its end."""
    reads: frozenset[str]
    """What of what may be read later rests on its states, and not on those around them."""


class StateFrame(NamedTuple):
    """What is left of a state without its parts."""

    parallel: RegionGroups
    run: RunState
    order: Mapping[str, tuple[int, ...]]
    """Field of a run → the groups whose entries it has, one after the other."""
    ahead: Ahead


class RegionParts:
    """Takes states apart, and puts them together.

    Args:
        chart: The mission.
        world: What the surroundings can be.
        codec: Saves and compares states.
        rest: What may be read later.
        regions: Which parallel states are taken apart.
    """

    def __init__(self, chart: Chart, world: OpenWorld, codec: StateCodec, rest: Abstraction, regions: Regions) -> None:
        self._chart, self._world, self._codec, self._rest, self.regions = chart, world, codec, rest, regions
        self._parted = {each.name: each.kind for each in TABLE if each.kind in PARTED}
        self._in_order = tuple(each.name for each in TABLE if each.kind in IN_ORDER)
        graph = chart.program.graph
        self._is_kept = frozenset(name for name, node in graph.nodes.items() if is_kept(chart.program, node))
        """The states whose activity a pause leaves as it is."""
        self.frames: list[StateFrame] = []
        self.parts: dict[CompiledState, list[list[Part]]] = {
            each.node: [[] for _ in each.members] for each in regions.parallels.values()
        }
        self._frame_numbers: dict[bytes, int] = {}
        self._part_numbers: dict[tuple[CompiledState, int, bytes], int] = {}

    # -- taken apart ----------------------------------------------------------------------------------------------

    def active(self, config: Configuration) -> RegionGroups | None:
        """The parallel state that is taken apart where these states are active."""
        return next((each for node, each in self.regions.parallels.items() if node in config.nodes), None)

    def takes(self, run: RunState) -> bool:
        """Whether a state is taken apart."""
        parallel = self.active(run.config) if run.mode == "running" and run.final is None else None
        return parallel is not None and all(
            name in parallel.group_of for field in self._in_order for name in getattr(run, field)
        )

    def parted(self, saved: SavedState) -> PartedState:
        """The numbers of a saved state's frame and parts; it is one that is taken apart."""
        run = saved.run
        parallel = self.active(run.config)
        assert parallel is not None
        fields: list[dict[str, dict[Any, Any]]] = [defaultdict(dict) for _ in parallel.members]
        left: dict[str, dict[Any, Any]] = {}
        order: dict[str, tuple[int, ...]] = {}
        for name, kind in self._parted.items():
            found, rest = [], {}
            for key, value in getattr(run, name).items():
                group = self._group(parallel, kind, key, value)
                if group is None:
                    rest[key] = value
                else:
                    fields[group][name][key] = value
                    found.append(group)
            left[name] = rest
            if name in self._in_order:
                order[name] = tuple(found)
        parts = [self._part(parallel, group, saved, each) for group, each in enumerate(fields)]
        return PartedState(self._frame(parallel, run, left, order), tuple(parts))

    def _group(self, parallel: RegionGroups, kind: FieldKind, key: Any, value: Any) -> int | None:
        """The group to which an entry belongs; None where it belongs to none."""
        if kind == "board":
            return parallel.key_of.get(key)
        if kind == "since":
            return parallel.group_of.get(self._chart.program.graph.held_owners[key].name)
        if kind == "timers":
            return parallel.group_of.get(self.regions.timer_owner(key))
        owner = value.owner.partition("#")[0] if kind == "goals" else key
        return parallel.group_of.get(owner)

    def _part(self, parallel: RegionGroups, group: int, saved: SavedState, fields: Mapping[str, dict[Any, Any]]) -> int:
        run, of = saved.run, parallel.group_of
        atomic = tuple(node for node in run.config.atomic if of.get(node.name) == group)
        groups = {name: each for name, each in saved.groups.items() if of.get(name) == group}
        keys = [(name, self._codec.key_of(name, entries)) for name, entries in sorted(fields.items())]
        place = parallel.node, group, fingerprint(([node.index for node in atomic], keys, groups_key(groups)))
        number, known = self._part_numbers.get(place), self.parts[parallel.node][group]
        if number is None:
            number = self._part_numbers[place] = len(known)
            known.append(self._made(parallel, group, atomic, fields, groups))
        return number

    def _made(
        self,
        parallel: RegionGroups,
        group: int,
        atomic: tuple[CompiledState, ...],
        fields: Mapping[str, dict[Any, Any]],
        groups: Mapping[str, Groups],
    ) -> Part:
        of = parallel.group_of
        nodes = {each for node in atomic for each in (node, *node.ancestors) if of.get(each.name) == group}
        running = fields.get("running", {})
        is_quiet = not (running or fields.get("board") or fields.get("goals") or any(node.exit for node in nodes))
        kept = any(name in self._is_kept for name in running)
        trees = any(isinstance(each, TreeActivity) for each in running.values())
        wakes = self.regions.mask(self._waits_for(parallel, group, nodes, fields))
        is_ended = all(is_done(region, nodes.__contains__) for region in parallel.members[group])
        around = (parallel.node, *parallel.node.ancestors)
        reads = self._rest.live.within(nodes) - self._rest.live.within(around)
        return Part(atomic, dict(fields), groups, wakes, is_quiet, (kept, trees), is_ended, reads)

    def _waits_for(
        self,
        parallel: RegionGroups,
        group: int,
        nodes: Iterable[CompiledState],
        fields: Mapping[str, Mapping[Any, Any]],
    ) -> Iterable[str]:
        """What wakes something in a part: keys, states, and time where it may change what is known or runs in it."""
        yield from parallel.outside[group]
        for node in nodes:
            for transition in node.transitions:
                condition = transition.condition
                if condition is not None and (transition.definition.eventless or condition.held_guards):
                    yield from condition.watched
        graph, machines = self._chart.program.graph, self._chart.program.machines
        for name in fields.get("settling", ()):
            requires = graph.nodes[name].requires
            yield from requires.watched if requires is not None else ()
        for name, activity in fields.get("running", {}).items():
            machine = machines[name]
            assert machine is not None
            yield from machine.reads(activity)
            if isinstance(activity, TreeActivity):
                yield from self._keys_of(name)
        can_fade = any(
            key in self._world.passing and entry is not None for key, entry in fields.get("board", {}).items()
        )
        spans = any(fields.get(field) for field in ("entered", "true_since", "settling"))
        if can_fade or spans or any(map(waits_for_time, fields.get("running", {}).values())):
            yield TIME

    def _keys_of(self, name: str) -> Iterable[str]:
        """Whatever the guards of a tree name: it looks again in its own way."""
        return self.regions.named_by(self._chart.program.graph.nodes[name])

    def _frame(
        self,
        parallel: RegionGroups,
        run: RunState,
        left: Mapping[str, dict[Any, Any]],
        order: Mapping[str, tuple[int, ...]],
    ) -> int:
        ahead = self._codec.ahead()
        key = (self._codec.run_key_of(run, left), parallel.node.index, sorted(order.items()), id(ahead))
        number = self._frame_numbers.get(mark := fingerprint(key))
        if number is None:
            number = self._frame_numbers[mark] = len(self.frames)
            state = copied(run)
            for name, entries in left.items():
                setattr(state, name, entries)
            self.frames.append(StateFrame(parallel, state, dict(order), ahead))
        return number

    # -- put together ---------------------------------------------------------------------------------------------

    def of(self, parted: PartedState) -> list[Part]:
        """The parts of a state."""
        known = self.parts[self.frames[parted.frame].parallel.node]
        return [known[group][number] for group, number in enumerate(parted.parts)]

    def place(self, parted: PartedState, store: Store) -> Place:
        """The whole state."""
        frame, parts = self.frames[parted.frame], self.of(parted)
        state = copied(frame.run)
        state.config = self._chart.program.graph.configuration(node for part in parts for node in part.atomic)
        for name in self._parted:
            inner = [part.fields.get(name, {}) for part in parts]
            if name in frame.order:
                entries = [iter(each.items()) for each in inner]
                setattr(state, name, dict(next(entries[group]) for group in frame.order[name]))
                continue
            whole = getattr(state, name)
            for each in inner:
                whole.update(each)
        state.watched = frozenset(key for key in state.board if key in self._world.fleeting)
        groups = {name: each for part in parts for name, each in part.groups.items()}
        return Place(SavedState(state, groups), store)
