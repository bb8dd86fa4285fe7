# SPDX-License-Identifier: Apache-2.0
"""Time that was stopped is given back: what waits for an instant waits as much longer."""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Mapping
from typing import Any

from rai_missions.engine.compiled.program import Program
from rai_missions.engine.semantics.hold import run_at
from rai_missions.engine.state import TABLE, FieldKind, RunState

__all__ = ("give_time_back", "shift")

Controls = Container[str | None]


def give_time_back(program: Program, state: RunState, controls: Iterable[str]) -> None:
    """Give the states that need one of these controls, and are held, the time that they had left."""
    for control in sorted(controls):
        shift(program, state, run_at(state) - state.frozen[control], (control,))


def shift(program: Program, state: RunState, by_s: float, controls: Controls | None = None) -> None:
    """Move what waits for time, by how long that was stopped.

    Args:
        program: The mission.
        state: The state of the run.
        by_s: For how long.
        controls: Only for the states that need one of these; for all there is without them, holds included.
    """
    for name, move in MOVED if by_s else ():
        if value := getattr(state, name):
            setattr(state, name, move(program, value, by_s, controls))


def _concerns(controls: Controls | None, control: str | None) -> bool:
    return controls is None or control in controls


def _instants(program: Program, value: Mapping[str, float], by_s: float, controls: Controls | None) -> Any:
    """Instants by state."""
    of = {name: program.graph.nodes[name].control if name else None for name in value}
    return {name: at + by_s if _concerns(controls, of[name]) else at for name, at in value.items()}


def _since(program: Program, value: Mapping[str, float], by_s: float, controls: Controls | None) -> Any:
    of, always = program.graph.held_owners, program.held_in_invariants  # invariants are looked at in a pause, too
    return {
        each: at + by_s if each not in always and _concerns(controls, of[each].control) else at
        for each, at in value.items()
    }


def _timers(program: Program, value: Mapping[Any, Any], by_s: float, controls: Controls | None) -> Any:
    return {
        key: timer._replace(due=timer.due + by_s) if _concerns(controls, timer.control or None) else timer
        for key, timer in value.items()
    }


def _activities(program: Program, value: Mapping[str, Any], by_s: float, controls: Controls | None) -> Any:
    def moved(name: str, activity: Any) -> Any:
        machine = program.machines[name]
        is_concerned = machine is not None and _concerns(controls, program.graph.nodes[name].control)
        return machine.shift(activity, by_s) if machine is not None and is_concerned else activity

    return {name: moved(name, activity) for name, activity in value.items()}


def _controls(program: Program, value: Mapping[str, float], by_s: float, controls: Controls | None) -> Any:
    return {control: at + by_s if controls is None else at for control, at in value.items()}


SHIFTS: Mapping[FieldKind, Callable[[Program, Any, float, Controls | None], Any]] = {
    "ages": _instants,
    "deadlines": _instants,
    "settling": _instants,
    "since": _since,
    "timers": _timers,
    "activities": _activities,
    "controls": _controls,
}
"""What a field holds → how it is moved."""
MOVED = tuple((each.name, SHIFTS[each.kind]) for each in TABLE if each.kind in SHIFTS)
"""The fields that are moved, and how."""
