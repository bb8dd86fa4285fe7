# SPDX-License-Identifier: Apache-2.0
"""All that a run remembers, as values: to continue from there, in another process or in another mission.

Rule: which fields there are, and under which words, is read from `state.TABLE`.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from collections.abc import Set as AbstractSet
from typing import Any, NamedTuple

from rai_missions.engine.activities.goal_ledger import Goal
from rai_missions.engine.compiled.configuration import Configuration
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.state import TABLE, FieldKind, RunState, Timer, TimerKey

__all__ = ("Snapshot", "broken", "configuration", "control_of", "put_back", "snapshot")

Snapshot = Mapping[str, Any]
"""All that a run remembers, as values by the words of `state.TABLE`; `Chart.restore` continues from there."""


class Form(NamedTuple):
    """How what a field holds is written as values, and read."""

    write: Callable[[Program, Any], Any]
    read: Callable[[Program, Any], Any]


def _as_it_is(program: Program, value: Any) -> Any:
    return dict(value) if isinstance(value, dict) else value


def _as_known(program: Program, value: Any) -> Any:
    return frozenset(value) if isinstance(value, AbstractSet) else value


def _names(program: Program, config: Configuration) -> tuple[str, ...]:
    return tuple(node.name for node in config.atomic)


def _configuration(program: Program, names: Iterable[str]) -> Configuration:
    atomic = tuple(program.graph.nodes[name] for name in names)
    return program.graph.configuration(atomic) if atomic else program.graph.empty


def _memory_out(program: Program, memory: Mapping[int, Any]) -> dict[str, tuple[str, ...]]:
    return {program.graph.order[at].name: tuple(each.name for each in nodes) for at, nodes in memory.items()}


def _memory_in(program: Program, memory: Mapping[str, Iterable[str]]) -> dict[int, Any]:
    nodes = program.graph.nodes
    return {nodes[name].index: tuple(nodes[each] for each in held) for name, held in memory.items()}


FORMS: Mapping[FieldKind, Form] = {
    "configuration": Form(_names, _configuration),
    "memory": Form(_memory_out, _memory_in),
    "passing": Form(_as_known, _as_known),
    "state": Form(
        lambda program, node: node.name if node is not None else None,
        lambda program, name: program.graph.nodes[name] if name else None,
    ),
    "goals": Form(
        lambda program, goals: [list(goal) for goal in goals.values()],
        lambda program, goals: {goal.number: goal for goal in (Goal(*fields) for fields in goals)},
    ),
}
"""What a field holds → how it is written, where it is not a value as it is."""
PLAIN = Form(_as_it_is, _as_it_is)


def snapshot(program: Program, state: RunState) -> Snapshot:
    """All that the run remembers, as values that later steps do not change."""
    return {word: FORMS.get(kind, PLAIN).write(program, getattr(state, name)) for name, word, kind in TABLE}


def put_back(program: Program, state: RunState, saved: Snapshot) -> None:
    """Be where a snapshot was taken; what it does not hold stays as it is."""
    for name, word, kind in TABLE:
        if word in saved:
            setattr(state, name, FORMS.get(kind, PLAIN).read(program, saved[word]))
    for name in state.running:
        program.machine(program.graph.nodes[name])


def control_of(program: Program, key: TimerKey, timer: Timer) -> str:
    """Whose control the state of a timer needs in this mission."""
    kind, which = key
    if kind == "raise":
        return timer.control if timer.control in program.graph.controls else ""
    node = program.graph.nodes[which] if kind == "timeout" else program.graph.transitions[which].source
    return node.control or ""


def configuration(program: Program, targets: Iterable[str]) -> tuple[Configuration, list[str]]:
    """The configuration in which these states are active, and the pairs of states in it that exclude each other.

    Args:
        program: The mission.
        targets: Names of states; what is inside them is entered by default.
    """
    graph = program.graph
    entered = graph.around((graph.nodes[name] for name in targets), graph.root, {})
    rivals = [
        f"'{inside[0].name}' and '{inside[1].name}'"
        for node in (graph.root, *entered)
        if node.is_compound
        and not node.is_parallel
        and len(inside := [each for each in node.children if each in entered]) > 1
    ]
    parents = {node.parent for node in entered}
    return graph.configuration(node for node in entered if node not in parents), rivals


def broken(program: Program, state: RunState) -> Iterator[tuple[str, str]]:
    """The invariants that are false now: name, and its guard in words."""
    return ((name, each.guard.words()) for name, each in program.invariants if each.test(state) is False)
