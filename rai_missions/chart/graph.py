# SPDX-License-Identifier: Apache-2.0
"""A mission compiled: states in document order, rows with their guards as functions, and moves worked out once.

Rule: what a configuration and the rows taken in it lead to is computed once and remembered.
The algorithms are those of W3C SCXML (REC-scxml-20150901, appendix D), with the names used there in the docstrings.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, NamedTuple

from rai_missions.effects import Effect
from rai_missions.guards.guard import Guard, Instant, Site, Test
from rai_missions.mission import Mission
from rai_missions.states.compound import Each, Parallel
from rai_missions.states.final import Final
from rai_missions.states.history import History
from rai_missions.states.state import ANY_EVENT, OUTCOMES, State, Transition
from rai_missions.step import Move

__all__ = ("Condition", "Configuration", "Graph", "Leap", "Memory", "Node", "Row")

Act = Callable[[Any], None]
"""An effect compiled: does its work on the chart it is given."""
Memory = Mapping[int, tuple["Node", ...]]
"""Index of a history state → the states it leads back to."""

CONFIGURATIONS = 4096
"""How many configurations are remembered; a mission that visits more forgets them all and starts again."""


class Condition(NamedTuple):
    """A guard compiled, with what it depends on."""

    place: str
    guard: Guard
    test: Test
    reads: frozenset[str]
    instants: tuple[Instant, ...]
    holds: Mapping[str, Test]


class Node:
    """A state, where it stands among the others."""

    __slots__ = (
        "activity", "ancestors", "children", "clocked", "control", "depth", "entry", "exit", "family", "history",
        "index", "initial", "is_compound", "is_each", "is_final", "is_history", "is_parallel", "name", "parent",
        "place", "requires", "rows", "state", "timed",
    )  # fmt: skip

    def __init__(self, name: str, place: str, state: State | None, parent: Node | None, index: int) -> None:
        self.name, self.place, self.state, self.parent, self.index = name, place, state, parent, index
        self.ancestors: tuple[Node, ...] = () if parent is None else (parent, *parent.ancestors)
        """Innermost first, the mission itself (the root) last."""
        self.depth = len(self.ancestors)
        self.children: list[Node] = []
        self.rows: list[Row] = []
        self.initial: tuple[Node, ...] = ()
        self.history: list[Node] = []
        self.entry: tuple[Act, ...] = ()
        self.exit: tuple[Act, ...] = ()
        self.is_history, self.is_final = isinstance(state, History), isinstance(state, Final)
        self.is_parallel, self.is_each = isinstance(state, Parallel), isinstance(state, Each)
        self.is_compound = state is None or (bool(state.children()) and not self.is_parallel)
        self.control: str | None = (state.control if state else None) or (parent.control if parent else None)
        self.activity = bool(state and state.activity() and not self.is_each)
        self.timed = bool(state and state.timeout_s is not None)
        self.clocked = False
        self.requires: Condition | None = None
        self.family = state.word if state else ""

    def inside(self, other: Node) -> bool:
        """Whether it is a proper descendant of another (SCXML: isDescendant)."""
        return other in self.ancestors

    def __repr__(self) -> str:
        return f"<{self.name or 'mission'}>"


class Row:
    """A transition compiled."""

    __slots__ = (
        "acts",
        "condition",
        "internal",
        "outcomes",
        "place",
        "recalls",
        "source",
        "targets",
        "test",
        "transition",
    )

    def __init__(self, transition: Transition, place: str, source: Node) -> None:
        self.transition, self.place, self.source = transition, place, source
        self.targets: tuple[Node, ...] = ()
        self.acts: tuple[Act, ...] = ()
        self.condition: Condition | None = None
        self.test: Test | None = None
        self.internal = transition.internal
        self.recalls = False
        """Where it leads depends on what is remembered."""
        self.outcomes: frozenset[str] = frozenset()
        """The words of `on` that are outcomes or options, not events."""


class Leap:
    """What taking certain rows in a configuration does: a `Move` and all that the chart needs to make it."""

    __slots__ = (
        "acts", "config", "entered", "exited", "move", "moves", "plain", "remember",
    )  # fmt: skip

    def __init__(self, move: Move, config: Configuration, acts: tuple[Act, ...]) -> None:
        self.move, self.moves, self.config, self.acts = move, (move,), config, acts
        self.exited: tuple[Node, ...] = ()
        self.entered: tuple[Node, ...] = ()
        self.remember: tuple[tuple[int, tuple[Node, ...]], ...] = ()
        """History state and what it leads back to from now on."""
        self.plain = False
        """Nothing but the move and its acts: no timer, activity, final, history, or row without an event."""


class Configuration:
    """A set of active states, and what can happen in it."""

    __slots__ = (
        "active",
        "atomic",
        "eventless",
        "holds",
        "instants",
        "key",
        "leaps",
        "nodes",
        "plans",
        "reads",
        "watchful",
    )

    def __init__(self, atomic: tuple[Node, ...], root: Node) -> None:
        self.atomic = atomic
        """The innermost active states, in document order."""
        self.key = tuple(node.index for node in atomic)
        self.nodes = {each for node in atomic for each in (node, *node.ancestors)} or {root}
        self.active = frozenset(node.name for node in self.nodes if node.state is not None)
        self.plans: dict[str, tuple[tuple[Row, ...], ...]] = {}
        self.leaps: dict[Any, Leap] = {}
        self.eventless = self._candidates(lambda row: row.transition.eventless)
        rows = [row for node in self.nodes for row in node.rows]
        waiting = [row.condition for row in rows if row.condition and row.transition.eventless]
        self.holds = {memory: test for row in rows if row.condition for memory, test in row.condition.holds.items()}
        self.reads = frozenset[str]().union(*(condition.reads for condition in waiting), *(
            row.condition.reads for row in rows if row.condition and row.condition.holds
        ))  # fmt: skip
        self.instants = tuple(instant for condition in waiting for instant in condition.instants)
        self.watchful = bool(self.eventless or self.holds)

    def _candidates(self, wanted: Callable[[Row], bool]) -> tuple[tuple[Row, ...], ...]:
        """For each innermost state its rows and its ancestors', in the order in which they are tried."""
        chains = (
            tuple(row for each in (node, *node.ancestors) for row in each.rows if wanted(row)) for node in self.atomic
        )
        return tuple(chain for chain in chains if chain)

    def plan(self, event: str, *, declared: bool) -> tuple[tuple[Row, ...], ...]:
        """The rows that an event may fire, a tuple an innermost state, in the order in which they are tried."""

        def wanted(row: Row) -> bool:
            on = row.transition.on
            return (event in on and event not in row.outcomes) or (declared and ANY_EVENT in on)

        plan = self.plans[event] = self._candidates(wanted)
        return plan

    def outcome_plan(self, source: Node, outcome: str, *, option: bool, climbs: bool) -> tuple[tuple[Row, ...], ...]:
        """The rows that an outcome may fire: those of its own state, of its ancestors if it climbs, or that name it."""

        def wanted(row: Row) -> bool:
            if outcome not in row.transition.on or outcome not in row.outcomes:
                return False
            if row.transition.of is not None:
                return row.transition.of == source.name
            return row.source is source or (climbs and not option and row.source in source.ancestors)

        return self._candidates(wanted)


class Graph:
    """A mission, ready to be stepped.

    Args:
        mission: One that `check` finds no fault in; names that do not resolve raise `KeyError`.
        compile_effect: Makes an act of a written effect; given by the chart, since acts work on it.
    """

    def __init__(self, mission: Mission, compile_effect: Callable[[Any, str, str], Act]) -> None:
        self.mission = mission
        self.root = Node("", "", None, None, 0)
        self.nodes: dict[str, Node] = {}
        self.order: list[Node] = [self.root]
        self.rows: dict[str, Row] = {}
        """JSON pointer → row."""
        self.recalls = False
        """Some default entry looks up a memory, so that every leap may depend on what is remembered."""
        self.options = {
            name for _, _, state in mission.walk() for name in (state.outcomes() if state.word == "decision" else ())
        }
        self._add(mission.states, self.root, "/states")
        self._act = compile_effect
        self._link()
        self.invariants = {
            name: self.condition(guard, f"/invariants/{name}", "") for name, guard in mission.invariants.items()
        }
        self.invariant_reads = frozenset[str]().union(*(each.reads for each in self.invariants.values()))
        self._configurations: dict[tuple[int, ...], Configuration] = {}
        self.empty = Configuration((), self.root)

    def _add(self, states: Mapping[str, State], parent: Node, place: str) -> None:
        for name, state in states.items():
            node = Node(name, f"{place}/{name.replace('/', '~1')}", state, parent, len(self.order))
            self.order.append(node)
            self.nodes[name] = node
            (parent.history if node.is_history else parent.children).append(node)
            self._add(state.children(), node, f"{node.place}/{state.child_place()}")

    def _link(self) -> None:
        self.root.initial = tuple(self.nodes[name] for name in self.mission.initial)
        starts = [name for _, _, state in self.mission.walk() for name in getattr(state, "initial", ())]
        self.recalls = any(self.nodes[name].is_history for name in starts)
        self._rows(self.root, self.mission.transitions)
        for node in self.order[1:]:
            state = node.state
            assert state is not None
            node.initial = tuple(self.nodes[name] for name in getattr(state, "initial", ()))
            node.entry = self._acts(state.entry, f"{node.place}/entry", node)
            node.exit = self._acts(state.exit, f"{node.place}/exit", node)
            if isinstance(state, Final) and state.requires is not None:
                node.requires = self.condition(state.requires, f"{node.place}/requires", node.name)
            self._rows(node, state.transitions)

    def _rows(self, node: Node, rows: Iterable[Transition]) -> None:
        for index, transition in enumerate(rows):
            row = Row(transition, f"{node.place}/transitions/{index}", node)
            row.targets = tuple(self.nodes[name] for name in transition.to)
            row.recalls = self.recalls or any(target.is_history for target in row.targets)
            row.acts = self._acts(transition.do, f"{row.place}/do", node)
            if transition.when is not None:
                row.condition = self.condition(transition.when, row.place, node.name)
                row.test = row.condition.test
            declared = self.mission.events
            words = set(OUTCOMES) | self.options
            row.outcomes = frozenset(word for word in transition.on if word in words and word not in declared)
            node.rows.append(row)
            self.rows[row.place] = row
            node.timed = node.timed or transition.after_s is not None

    def _acts(self, effects: Iterable[Effect], place: str, node: Node) -> tuple[Act, ...]:
        return tuple(self._act(effect, f"{place}/{index}", node.name) for index, effect in enumerate(effects))

    def condition(self, guard: Guard, place: str, state: str) -> Condition:
        """A guard compiled for a place; the states whose age it asks for are clocked from now on."""
        site = Site(place, self.mission.blackboard, state)
        test = guard.compile(site)
        for name in site.clocked:
            (self.nodes[name] if name else self.root).clocked = True
        return Condition(place, guard, test, frozenset(site.reads), tuple(site.instants), dict(site.holds))

    def configuration(self, atomic: Iterable[Node]) -> Configuration:
        """The one `Configuration` of these innermost states."""
        nodes = tuple(sorted(atomic, key=lambda node: node.index))
        key = tuple(node.index for node in nodes)
        found = self._configurations.get(key)
        if found is None:
            if len(self._configurations) >= CONFIGURATIONS:
                self._configurations.clear()
            found = self._configurations[key] = Configuration(nodes, self.root)
        return found

    # -- selecting ------------------------------------------------------------------------------------------------

    def compatible(self, config: Configuration, rows: list[Row], memory: Memory) -> list[Row]:
        """The rows that can be taken together: a descendant's preempts an ancestor's, then document order."""
        if len(rows) < 2:
            return rows
        kept: list[tuple[Row, set[Node]]] = []
        for row in rows:
            exits = set(self._exit_set(config, row, memory))
            clashing = [(other, theirs) for other, theirs in kept if exits & theirs]
            if all(row.source.inside(other.source) for other, _ in clashing):
                kept = [pair for pair in kept if pair not in clashing]
                kept.append((row, exits))
        return [row for row, _ in kept]

    def _targets(self, row: Row, memory: Memory) -> list[Node]:
        """Where a row leads, history looked up (getEffectiveTargetStates)."""
        return [state for target in row.targets for state in self._effective(target, memory)]

    def _effective(self, target: Node, memory: Memory) -> list[Node]:
        if not target.is_history:
            return [target]
        assert target.parent is not None
        return [
            each for node in memory.get(target.index) or target.parent.initial for each in self._effective(node, memory)
        ]

    def _domain(self, row: Row, memory: Memory) -> Node | None:
        """The state inside which everything is left and entered (getTransitionDomain)."""
        targets = self._targets(row, memory)
        if not targets:
            return None
        source = row.source
        if row.internal and source.is_compound and all(target.inside(source) for target in targets):
            return source
        for ancestor in source.ancestors or (self.root,):
            if ancestor.is_compound and all(target.inside(ancestor) for target in targets):
                return ancestor
        return self.root

    def _exit_set(self, config: Configuration, row: Row, memory: Memory) -> list[Node]:
        domain = self._domain(row, memory)
        return [] if domain is None else [node for node in config.nodes if node.inside(domain)]

    # -- moving ---------------------------------------------------------------------------------------------------

    def leap(self, config: Configuration, rows: tuple[Row, ...], memory: Memory, trigger: str) -> Leap:
        """What firing these rows does, those preempted left out; worked out once for what it depends on."""
        key: Any = (rows, trigger)
        recalls = any(row.recalls for row in rows)
        if recalls:
            key = (key, tuple((index, tuple(node.index for node in memory[index])) for index in sorted(memory)))
        found = config.leaps.get(key)
        if found is None:
            found = self._leap(config, tuple(self.compatible(config, list(rows), memory)), memory, trigger)
            found.plain = found.plain and not recalls
            config.leaps[key] = found
        return found

    def _leap(self, config: Configuration, rows: tuple[Row, ...], memory: Memory, trigger: str) -> Leap:
        exited = {node for row in rows for node in self._exit_set(config, row, memory)}
        entered: set[Node] = set()
        for row in rows:
            domain = self._domain(row, memory)
            if domain is None:
                continue
            for target in row.targets:
                self._descend(target, entered, memory)
            for target in self._targets(row, memory):
                self._climb(target, domain, entered, memory)
        acts = tuple(act for row in rows for act in row.acts)
        return self.move(config, exited, entered, taken=tuple(row.place for row in rows), acts=acts, trigger=trigger)

    def start(self, memory: Memory) -> Leap:
        """The entry of the mission."""
        entered: set[Node] = set()
        for target in self.root.initial:
            self._descend(target, entered, memory)
        for target in self.root.initial:
            self._climb(target, self.root, entered, memory)
        return self.move(self.empty, set(), entered, taken=(), acts=(), trigger="")

    def flee(self, config: Configuration, target: Node, memory: Memory, trigger: str) -> Leap:
        """From wherever it is into a state, everything left."""
        entered: set[Node] = set()
        self._descend(target, entered, memory)
        self._climb(target, self.root, entered, memory)
        exited = {node for node in config.nodes if node.state is not None}
        return self.move(config, exited, entered, taken=(), acts=(), trigger=trigger)

    def reenter(self, config: Configuration, node: Node, memory: Memory, trigger: str = "") -> Leap:
        """What is inside a state is left, and its `initial` entered: the next round of an `each`."""
        entered: set[Node] = set()
        for target in node.initial:
            self._descend(target, entered, memory)
        for target in node.initial:
            self._climb(target, node, entered, memory)
        exited = {each for each in config.nodes if each.inside(node)}
        return self.move(config, exited, entered, taken=(), acts=(), trigger=trigger)

    def move(
        self, config: Configuration, exited: set[Node], entered: set[Node], *, taken: tuple[str, ...],
        acts: tuple[Act, ...], trigger: str,
    ) -> Leap:  # fmt: skip
        """A leap from what is left and entered: exit innermost first, the rows' acts, entry outermost first."""
        out = tuple(sorted(exited, key=lambda node: -node.index))
        into = tuple(sorted(entered, key=lambda node: node.index))
        nodes = (config.nodes - exited) | entered
        parents = {node.parent for node in nodes}
        atomic = [node for node in nodes if node not in parents and node.state is not None]
        target = self.configuration(atomic)
        entering = tuple(act for index, node in enumerate(into) for act in self._entering(config, exited, into, index))
        every = tuple(act for node in out for act in node.exit) + acts + entering
        move = Move(taken, tuple(node.name for node in out), tuple(node.name for node in into), trigger)
        leap = Leap(move, target, every)
        leap.exited, leap.entered = out, into
        leap.remember = tuple(self._remembered(config, out))
        quiet = not any(node.timed or node.activity or node.clocked or node.control for node in (*out, *into))
        ends = any(node.is_final or node.is_each for node in into)
        leap.plain = quiet and not ends and not leap.remember and not target.watchful and not self.invariants
        return leap

    def _entering(self, config: Configuration, exited: set[Node], into: tuple[Node, ...], index: int) -> Iterable[Act]:
        """The acts of entering one node; a final tells of its parent's end, and of a parallel state's with it."""
        node = into[index]
        if node.is_each:
            yield lambda chart: chart.enter_each(node)
        yield from node.entry
        if node.is_final and node.parent is not None:
            so_far = (config.nodes - exited) | set(into[: index + 1])
            outer = node.parent if node.parent.is_parallel else node.parent.parent
            complete = tuple(self.complete(outer, so_far))
            yield lambda chart: chart.reach_final(node, complete)

    def complete(self, region_of: Node | None, nodes: set[Node]) -> Iterable[Node]:
        """The parallel states that have all their regions in a final now, inner first."""
        while region_of is not None and region_of.is_parallel and _is_done(region_of, nodes):
            yield region_of
            region_of = region_of.parent

    def _remembered(self, config: Configuration, exited: Iterable[Node]) -> Iterable[tuple[int, tuple[Node, ...]]]:
        for node in exited:
            for history in node.history:
                assert isinstance(history.state, History)
                if history.state.history == "deep":
                    states = [each for each in config.atomic if each.inside(node)]
                else:
                    states = [each for each in config.nodes if each.parent is node]
                yield history.index, tuple(sorted(states, key=lambda each: each.index))

    def _descend(self, node: Node, entered: set[Node], memory: Memory) -> None:
        """A target and what is entered inside it by default (addDescendantStatesToEnter)."""
        if node.is_history:
            assert node.parent is not None
            targets = memory.get(node.index) or node.parent.initial
            for target in targets:
                self._descend(target, entered, memory)
            for target in targets:
                self._climb(target, node.parent, entered, memory)
            return
        entered.add(node)
        if node.is_parallel:
            for child in node.children:
                if not any(each is child or each.inside(child) for each in entered):
                    self._descend(child, entered, memory)
        elif node.is_compound and not node.is_each:
            for target in node.initial:
                self._descend(target, entered, memory)
            for target in node.initial:
                self._climb(target, node, entered, memory)

    def _climb(self, node: Node, domain: Node, entered: set[Node], memory: Memory) -> None:
        """What lies between a target and the domain (addAncestorStatesToEnter)."""
        for ancestor in node.ancestors:
            if ancestor is domain:
                break
            entered.add(ancestor)
            if ancestor.is_parallel:
                for child in ancestor.children:
                    if not any(each is child or each.inside(child) for each in entered):
                        self._descend(child, entered, memory)


def _is_done(node: Node, nodes: set[Node]) -> bool:
    """Whether a state has reached its end (SCXML: isInFinalState)."""
    if node.is_parallel:
        return all(_is_done(child, nodes) for child in node.children)
    if node.is_final:
        return node in nodes
    return any(child.is_final and child in nodes for child in node.children)
