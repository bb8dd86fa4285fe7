# SPDX-License-Identifier: Apache-2.0
"""States and transitions of a mission, compiled: the place of each among the others, and its guard as a function."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple

from rai_missions.guards.guard import Guard
from rai_missions.guards.view import Instant, Site, Test, Truth
from rai_missions.keys import Key
from rai_missions.states.compound import Each, Parallel
from rai_missions.states.final import Final
from rai_missions.states.history import History
from rai_missions.states.state import State
from rai_missions.states.transition import Transition

__all__ = (
    "Act",
    "CompiledGuard",
    "CompiledState",
    "CompiledTransition",
    "Content",
    "Memory",
    "Write",
    "WriteAct",
    "Written",
)  # fmt: skip

Act = Callable[[Any, Any], None]
"""An effect compiled: does its work on the program and the state of the run that it is given."""
Written = tuple[tuple[str, Any], ...]
"""Keys and their new values, in order."""
Write = Callable[[Any], Written | None]
"""Writes a key of a run's blackboard and returns what a step notes; None where it has written nothing."""
Memory = Mapping[int, tuple["CompiledState", ...]]
"""Index of a history state → the states it leads back to."""


class WriteAct:
    """An act that writes one key and needs nothing of the step in hand, where its value is of the simplest sort.

    Args:
        write: Makes the act in that case; `CompiledMove.write` uses it alone.
        otherwise: Makes it in any other.
    """

    __slots__ = ("otherwise", "write")

    def __init__(self, write: Write, otherwise: Act) -> None:
        self.write, self.otherwise = write, otherwise

    def __call__(self, program: Any, run: Any) -> None:
        written = self.write(run)
        if written is not None:
            run.draft.written.extend(written)
        else:
            self.otherwise(program, run)


class Content(NamedTuple):
    """How a mission's executable content is compiled."""

    effect: Callable[[Any, str, str], Act]
    """Of an effect, the place where it is written and its state."""
    enter_each: Callable[[Any, Any], Act]
    """Of a state that goes through a list, as it is entered, and the history that leads back into it, if one does."""
    reach_final: Callable[[Any, tuple[Any, ...]], Act]
    """Of a final, as it is entered, and the parallel states that have all their regions in a final then."""
    site: Callable[[str, Mapping[str, Key], str], Site]
    """Where the guards of transitions, finals and invariants are compiled: `Site`, but in a proof."""


class CompiledGuard(NamedTuple):
    """A guard compiled, with what it depends on."""

    place: str
    guard: Guard
    test: Test
    reads: frozenset[str]
    """The keys that it looks at."""
    watched: frozenset[str]
    """What it is woken by, time excepted (`Site.watched`)."""
    instants: tuple[Instant, ...]
    held_guards: Mapping[str, Test]
    counts: Truth
    """Which of its values counts at its place; None where each does."""


class CompiledState:
    """A state with its place among the others."""

    __slots__ = (
        "activity", "ancestors", "chains", "children", "clocked", "control", "depth", "entry", "exit", "history",
        "index", "initial", "is_compound", "is_each", "is_final", "is_history", "is_parallel", "last", "name",
        "of_it", "options", "parent", "place", "requires", "state", "timed", "transitions", "watches",
    )  # fmt: skip

    def __init__(self, name: str, place: str, state: State | None, parent: CompiledState | None, index: int) -> None:
        self.name, self.place, self.state, self.parent, self.index = name, place, state, parent, index
        self.ancestors: tuple[CompiledState, ...] = () if parent is None else (parent, *parent.ancestors)
        """Innermost first, the mission itself (the root) last."""
        self.depth = len(self.ancestors)
        self.last = index
        """The index of the last state inside it."""
        self.children: list[CompiledState] = []
        self.transitions: list[CompiledTransition] = []
        self.of_it: list[CompiledTransition] = []
        """The transitions, wherever they are, that name it by `of`."""
        self.chains: dict[Any, tuple[CompiledTransition, ...]] = {}
        """An event, or None for no event → its transitions and its ancestors' that it may fire: see `chain_of`."""
        self.initial: tuple[CompiledState, ...] = ()
        """What entering it by default leads to; of a history where it leads without memory."""
        self.history: list[CompiledState] = []
        self.entry: tuple[Act, ...] = ()
        self.exit: tuple[Act, ...] = ()
        self.is_history, self.is_final = isinstance(state, History), isinstance(state, Final)
        self.is_parallel, self.is_each = isinstance(state, Parallel), isinstance(state, Each)
        self.is_compound = state is None or (bool(state.children()) and not self.is_parallel)
        self.control: str | None = (state.control if state else None) or (parent.control if parent else None)
        self.activity = bool(state and state.activity())
        self.timed = bool(state and state.timeout_s is not None)
        self.clocked = False
        self.watches = False
        """Some transition of it needs no event, or has a guard inside `held`."""
        self.requires: CompiledGuard | None = None
        self.options = frozenset(state.options if state else ())

    def inside(self, other: CompiledState) -> bool:
        """Whether it is a proper descendant of another (SCXML: isDescendant)."""
        return other.index < self.index <= other.last

    def __repr__(self) -> str:
        return f"<{self.name or 'mission'}>"


class CompiledTransition:
    """A transition with its targets as states, its guard as a function and its effects as acts on a run."""

    __slots__ = (
        "acts", "condition", "definition", "internal", "outcomes", "place", "source", "targets", "test", "uses_history",
    )  # fmt: skip

    def __init__(self, definition: Transition, place: str, source: CompiledState) -> None:
        self.definition, self.place, self.source = definition, place, source
        self.targets: tuple[CompiledState, ...] = ()
        self.acts: tuple[Act, ...] = ()
        self.condition: CompiledGuard | None = None
        self.test: Test | None = None
        self.internal = definition.internal
        self.uses_history = False
        """Where it leads depends on what is remembered."""
        self.outcomes: frozenset[str] = frozenset()
        """The words of `on` that are outcomes or options, not events."""
