# SPDX-License-Identifier: Apache-2.0
"""A run put into any of its states again, and what distinguishes two of its states.

Rule: time does not pass: a timer has run out or it has not, a state is old enough for a guard or it is not yet. Which
fields a run has is read from `engine.state.TABLE`; here is only what of each kind of field makes a difference.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from functools import partial
from operator import attrgetter
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.state import FIELD_KINDS, TABLE, FieldKind, RunState, StepDraft, copied
from rai_missions.event import Event
from rai_missions.keys import Stamped
from rai_missions.prove.abstraction.abstraction import INDIFFERENT, PURSUED, Abstraction, relink_stopped
from rai_missions.prove.abstraction.activity_key import key_of, plain, timer_key
from rai_missions.prove.abstraction.control_env import kept_words
from rai_missions.prove.abstraction.nondeterminism import OpenBoard
from rai_missions.prove.abstraction.open_rounds import PREFIX, list_name
from rai_missions.prove.abstraction.open_world import NOW, OpenWorld
from rai_missions.prove.abstraction.store import Kept, Rivals, Store, StoreQuery, Stores, fingerprint, first_alike
from rai_missions.prove.analysis.branches import Groups, groups_key
from rai_missions.prove.analysis.counts import Count, clamped
from rai_missions.prove.analysis.liveness import Later
from rai_missions.prove.analysis.loops import Loop
from rai_missions.prove.analysis.parts import guards_in, own_parts, parts
from rai_missions.states.tree.leaves import ActionLeaf

__all__ = ("Place", "SavedState", "StateCodec")

NONE: dict[Any, Any] = {}
AS_IT_IS: frozenset[FieldKind] = frozenset(("value", "states", "begins"))
"""What is compared as it is."""
NO_DRAFT = StepDraft()
"""Saved states have gathered nothing."""
REMEMBERED = 4096
"""Configurations of which is remembered what makes a difference from there on."""
A_LITTLE_S = 1e-3
"""A state is older than a guard asks for by so much, so that a sum of floats does not fall short."""


class SavedState(NamedTuple):
    """All that a run remembers but its store, to put it back."""

    run: RunState
    groups: Mapping[str, Groups]


class Place(NamedTuple):
    """A state of a run, to put it back into it."""

    saved: SavedState
    store: Store


class Ahead(NamedTuple):
    """What makes a difference of a store from a configuration on."""

    kept: Kept
    """Of each of the mission's own keys, and of each list, what may be read of it."""
    question: StoreQuery
    """Asks for all that makes a difference."""


class StateCodec:
    """Saves, loads and compares the states of a run.

    Args:
        chart: The mission.
        world: What the surroundings can be.
        rest: What is forgotten between steps.
    """

    def __init__(self, chart: Chart, world: OpenWorld, rest: Abstraction) -> None:
        self._chart, self._world, self._rest = chart, world, rest
        self._levels = self._thresholds()
        classes = {} if world.is_open else world.values.classes(chart.mission)
        counters = classes.keys() & world.values.counters() if not world.own_fade else frozenset[str]()
        self.stores = Stores(
            chart.robot_facts, classes, counters, rest.saturating, rest.idle if not world.is_open else ()
        )
        world.board.count(counters)
        self._by_config: dict[tuple[int, ...], Ahead] = {}
        self._by_reads: dict[tuple[Later, frozenset[str]], Ahead] = {}
        self.groups: dict[str, Groups] = {}
        """State → the groups of its tree's waits and timeouts, where there are several: see `branches`."""
        self.loops: tuple[Loop, ...] = ()
        """The loops of which a few rounds may represent all."""
        keys_by_kind: Mapping[FieldKind, Callable[[Any], Any]] = {
            "configuration": lambda config: config.key,
            "state": lambda node: node.index,
            "events": self._events_key,
            "memory": self._memory_key,
            "deadline": lambda until: until == math.inf,
            "deadlines": lambda found: [(name, until == math.inf) for name, until in sorted(found.items())],
            "settling": list,
            "controls": sorted,
            "invariants": sorted,
            "timers": lambda timers: sorted([timer_key(key, timer) for key, timer in timers.items()]),
            "rounds": sorted,
            "lists": self._lists_key,
            # in the order in which they are informed of things
            "activities": lambda running: [(name, key_of(activity)) for name, activity in running.items()],
            "calls": lambda calls: sorted(calls.values()),
            "goals": _pursued_key,
            "board": self._board_key,
            "ages": self._ages_key,
            "since": lambda held: [(memory, since == NOW) for memory, since in sorted(held.items())],
            "payload": lambda payload: sorted(payload.items()),
        }
        keyed = [(each.name, keys_by_kind[each.kind]) for each in TABLE if each.kind in keys_by_kind]
        plain_fields = [each.name for each in TABLE if each.kind in AS_IT_IS]
        unclear = set(FIELD_KINDS) ^ (keys_by_kind.keys() | INDIFFERENT | AS_IT_IS)
        assert not unclear, f"{sorted(unclear)}: to be compared as it is, by a key of its own, or not at all"
        self._to_keys = dict(keyed)
        self._keys_of = tuple(to_key for _, to_key in keyed)
        self._keyed_values = attrgetter(*(name for name, _ in keyed))
        self._plain_values = attrgetter(*plain_fields)

    # -- ages -----------------------------------------------------------------------------------------------------

    def _thresholds(self) -> dict[str, tuple[float, ...]]:
        """State → the ages that guards ask for, ascending; empty for the mission itself."""
        mission, facts = self._chart.mission, self._chart.robot_facts
        found = {"": _ages([mission.transitions, mission.invariants])}
        for _, name, state in mission.walk():
            own = own_parts(state)
            actions = {getattr(state, "action", ""), *(leaf.action for leaf in parts(own, ActionLeaf))}
            by_profile = [
                guards[action] for guards in (facts.succeeded, facts.failed) for action in actions & set(guards)
            ]
            found[name] = tuple(sorted({*_ages(own), *_ages(by_profile)}))
        return {name: ages for name, ages in found.items() if ages}

    def next_age(self, name: str) -> float | None:
        """The next age of a state that a guard asks for, in seconds."""
        age = NOW - self._chart.state.entered.get(name, NOW)
        return next((each for each in self._levels.get(name, ()) if each > age), None)

    def grow_old(self, name: str, age: float) -> None:
        """A state has been active for so many seconds."""
        self._chart.state.entered[name] = NOW - age - A_LITTLE_S

    @property
    def aging(self) -> list[str]:
        """The active states whose age can make a difference yet."""
        entered = self._chart.state.entered
        return [name for name in self._levels if name in entered and self.next_age(name) is not None]

    # -- saved and loaded -----------------------------------------------------------------------------------------

    def place(self) -> Place:
        """What `load` puts back; the run is at rest."""
        store = self.stores.store(self.own(), first_alike(self.given_up(), self._rest.rivals))
        return Place(self._saved(copied(self._chart.state)), store)

    def take(self) -> SavedState:
        """The state without its store, and without a copy; the run is only used again once a state was loaded."""
        return self._saved(self._chart.state)

    def _saved(self, state: RunState) -> SavedState:
        own = self._world.own_keys
        state.board = {key: entry for key, entry in self._world.board.entries() if key not in own}
        if state.goals:
            state.goals = {number: goal for number, goal in state.goals.items() if goal.phase in PURSUED}
        if state.lists:
            items = self._world.items
            state.lists = {key: items.closed(key[1], each) for key, each in state.lists.items()}
        state.rounds, state.draft = NONE, NO_DRAFT
        return SavedState(state, self.groups or NONE)

    def own(self) -> dict[str, Any]:
        """What the mission's own keys hold."""
        bounds, items = self._rest.saturating, self._world.items
        found = {key: items.entry(key, entry) for key, entry in self._world.own().items()}
        found |= self._rounds()
        for key in self.stores.counters & found.keys():
            entry = found[key]
            if entry is not None and entry[0].__class__ is Count:
                found[key] = Stamped(clamped(bounds, key, int(entry[0])), entry[1])
        return found

    def changed(self, before: Store, *, is_exact: bool) -> tuple[dict[str, Any], dict[str, int]]:
        """What a step has written to the mission's own keys, and what it has added to the numbers that are counted.

        Args:
            before: The store that it began with.
            is_exact: The values themselves decide how the step goes: nothing is counted on from others.
        """
        written, added = dict[str, Any](), dict[str, int]()
        for key, found in self._world.own().items():
            entry = self._world.items.entry(key, found)
            if before.keys.get(key) is entry or before.board.get(key) is entry:
                continue
            if found is not entry and before.keys.get(key) == entry:
                continue
            if entry is None or entry[0].__class__ is not Count:
                written[key] = entry
            elif is_exact:
                written[key] = Stamped(clamped(self._rest.saturating, key, int(entry[0])), entry[1])
            else:
                added[key] = entry[0].added
        for name, each in self._rounds().items():
            if before.keys.get(name) != each:
                written[name] = each
        return written, added

    def _rounds(self) -> dict[str, Stamped]:
        """The lists that are gone over, by their names in a store."""
        items = self._world.items
        return {list_name(name): Stamped(items.closed(name, each), NOW) for name, each in self._world.rounds.entries()}

    def given_up(self) -> list[Goal]:
        """The goals that nothing pursues."""
        return [goal for goal in self._chart.state.goals.values() if goal.phase not in PURSUED]

    def load(self, place: Place) -> None:
        """Be in a state again."""
        saved, store = place
        state = copied(saved.run)
        self._world.board.refill(saved.run.board, store.board)
        items = self._world.items
        items.load()
        self._world.rounds.refill({name: items.opened(name, each) for name, each in store.rounds.items()})
        if state.lists:
            state.lists = {key: items.opened(key[1], each) for key, each in state.lists.items()}
        state.board, state.rounds = self._world.board, self._world.rounds
        if store.goals:
            state.goals = store.ledger | state.goals
            relink_stopped(state)
        self._chart.state = state
        self.groups = dict(saved.groups) if saved.groups else {}

    # -- what distinguishes states ----------------------------------------------------------------------------------

    def run_key(self) -> bytes:
        """The key of a run, a state without its store, 16 bytes: equal where states differ in their stores alone."""
        state = self._chart.state
        values = self._keyed_values(state)
        keyed = [
            (to_key(value) or None) if value else None for to_key, value in zip(self._keys_of, values, strict=True)
        ]
        return fingerprint((self._plain_values(state), keyed, groups_key(self.groups)))

    def run_key_of(self, run: RunState, fields: Mapping[str, Any]) -> bytes:
        """The `run_key` of what is left of a saved state: with these fields, and no active states."""
        keyed = [
            (name, to_key(value))
            for name, to_key in self._to_keys.items()
            if name != "config" and (value := fields.get(name, getattr(run, name)))
        ]
        return fingerprint((self._plain_values(run), keyed))

    def key_of(self, field: str, entries: Mapping[Any, Any]) -> Any:
        """What distinguishes some entries of a field of a saved state."""
        return self._to_keys[field](entries)

    def ahead(self) -> Ahead:
        """What makes a difference of a store from here on."""
        config = self._chart.state.config
        found = self._by_config.get(config.key)
        if found is None:
            if len(self._by_config) >= REMEMBERED:
                self._by_config.clear()
            reads = self._rest.later, frozenset(list_name(node.name) for node in config.nodes if node.is_each)
            found = self._by_config[config.key] = self._by_reads.get(reads) or self._ahead(*reads)
            self._by_reads[reads] = found
        return found

    def _ahead(self, later: Later, lists: frozenset[str]) -> Ahead:
        is_whole = self._world.own_fade  # that a key goes stale is something that happens
        keys, rivals = sorted(later.roots & self._world.own_keys), self._rest.rivals
        parts: list[Callable[[Store], Any]] = []
        if keys or lists:
            parts.append(partial(_own_key, (*keys, *sorted(lists)), self._rest.idle, later))
        if later.starts or self._rest.names_orphans:
            parts.append(partial(_rivals_key, rivals))
        return Ahead(partial(_kept, lists, None if is_whole else later), StoreQuery(parts))

    def _events_key(self, events: Iterable[Event]) -> Any:
        """The key of events that wait for the hand-back: the data of outcomes, and what rules look at of others."""
        looked = self._world.values.fields("event")
        return [
            (*kept_words(each), each.data["data"] if each.kind == "outcome" else [each.data.get(n) for n in looked])
            for each in events
        ]

    def _memory_key(self, memory: Mapping[int, Any]) -> Any:
        recalls = self._rest.later.recalls
        return [(at, [node.index for node in nodes]) for at, nodes in sorted(memory.items()) if at in recalls]

    def _lists_key(self, lists: Mapping[tuple[str, str], tuple[tuple[Any, ...], int]]) -> Any:
        recalls = {self._chart.program.graph.order[at].name for at in self._rest.later.recalls}
        rest = self._world.items.closed
        return sorted(
            (key, repr(rest(key[1], (items[at:], 0)))) for key, (items, at) in lists.items() if key[0] in recalls
        )

    def _board_key(self, board: Any) -> Any:
        idle, kept, own = self._rest.idle, self._rest.later.roots, self._world.own_keys
        every = board.entries() if isinstance(board, OpenBoard) else board.items()
        entries = sorted([entry for entry in every if entry[0] in kept and entry[0] not in own])
        return [(n, None if entry is None else n in idle or plain(entry[0])) for n, entry in entries]

    def _ages_key(self, entered: Mapping[str, float]) -> Any:
        return [(name, self.next_age(name)) for name in self._levels if name in entered]

    # -- rounds of loops ------------------------------------------------------------------------------------------

    def levels(self) -> tuple[tuple[Loop, int, bytes], ...]:
        """Each loop that runs, how many of its rounds have ended, and the key of the run but for this number."""
        found, state = [], self._chart.state
        for loop in self.loops:
            ended = self._rounds_of(loop)
            if ended is not None:
                running = state.running
                state.running = {**running, loop.state: _counting(running[loop.state], loop, None)}
                found.append((loop, ended, self.run_key()))
                state.running = running
        return tuple(found)

    def _rounds_of(self, loop: Loop) -> int | None:
        """How many rounds of a loop have ended; None where it does not run."""
        activity = self._chart.state.running.get(loop.state)
        memory = activity.tree.nodes.get(loop.path, NONE) if activity is not None else NONE
        return memory.get(loop.word, 0) if memory.get("status") == "running" else None

    def uncounted(self) -> bytes:
        """The key of a state without the rounds of its loops: equal for two states that differ in these alone."""
        state = self._chart.state
        running = state.running
        for loop in self.loops:
            if self._rounds_of(loop) is not None:
                state.running = {**state.running, loop.state: _counting(state.running[loop.state], loop, None)}
        key = self.run_key() + self.ahead().question.of(self.place().store) if state.outcome is None else b""
        state.running = running
        return key

    def go_round(self, loop: Loop, more: int) -> None:
        """Count more rounds of a loop as ended; nothing where it does not run."""
        running, ended = self._chart.state.running, self._rounds_of(loop)
        if ended is not None:
            running[loop.state] = _counting(running[loop.state], loop, ended + more)


def _kept(lists: frozenset[str], later: Later | None, key: str, entry: Any) -> Any:
    if key.startswith(PREFIX):
        return entry if key in lists else None
    if entry is None or later is None or key in later.keys:
        return entry
    if key not in later.roots:
        return None
    return Stamped(later.of(key, entry[0]), entry[1])


def _pursued_key(goals: Mapping[int, Goal]) -> Any:
    return sorted([(goal.owner, goal.action, goal.phase) for goal in goals.values() if goal.phase in PURSUED])


def _own_key(keys: tuple[str, ...], idle: frozenset[str], later: Later, store: Store) -> Any:
    entries = [(name, store.keys.get(name)) for name in keys]
    return [None if entry is None else name in idle or later.of(name, entry[0]) for name, entry in entries]


def _rivals_key(rivals: Rivals, store: Store) -> Any:
    """What makes a difference of goals that nothing pursues."""
    return sorted([rest for goal in store.goals if (rest := rivals(goal)) is not None])


def _counting(activity: Any, loop: Loop, ended: int | None) -> Any:
    """A tree's state with another number of rounds of a loop; without one where there is none."""
    memory = {word: value for word, value in activity.tree.nodes[loop.path].items() if word != loop.word}
    if ended is not None:
        memory[loop.word] = ended
    return activity._replace(tree=activity.tree._replace(nodes={**activity.tree.nodes, loop.path: memory}))


def _ages(part: Any) -> tuple[float, ...]:
    return tuple(sorted({each.age_s for each in guards_in(part) if each.age_s is not None}))
