# SPDX-License-Identifier: Apache-2.0
"""What waits while the operator keeps control: a state is held whose innermost `control` is not with its holder.

Rule: held follows from who has control alone. Timers, transitions, activities and events ask here, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from rai_missions.engine.activities.activity import Machine
from rai_missions.engine.compiled.configuration import Plan
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.compiled.states import CompiledState
from rai_missions.engine.state import RunState
from rai_missions.states.control import Holder

__all__ = (
    "awake", "free", "held_by", "held_controls", "holder_of", "is_awaited", "is_for_held", "is_held", "live",
    "run_at", "runs",
)  # fmt: skip


def holder_of(program: Program, state: RunState) -> Holder:
    """Who has control."""
    return state.holder if state.holder is not None else program.surroundings.holder(state)


def held_by(state: RunState) -> str:
    """`operator`, who has taken control, or `nobody`; empty while the mission is not held."""
    if state.mode in ("ready", "ended") or state.holder is None:
        return ""
    return state.holder if state.holder == "nobody" or (state.holder == "operator" and state.taken) else ""


def held_controls(program: Program, state: RunState) -> frozenset[str]:
    """The controls in the mission whose states are held as long as control is where it is."""
    by = held_by(state)
    return program.graph.controls - {by} if by else frozenset()


def is_held(state: RunState, node: CompiledState) -> bool:
    """Whether a state waits until the operator gives control back."""
    return node.control in state.frozen


def run_at(state: RunState) -> float:
    """Now, or when the run was paused."""
    return state.paused_at if state.mode == "paused" else state.at


def free(state: RunState, plan: Plan) -> Plan:
    """A plan without the transitions of held states."""
    if not state.frozen:
        return plan
    chains = (tuple(transition for transition in chain if not is_held(state, transition.source)) for chain in plan)
    return tuple(chain for chain in chains if chain)


def runs(program: Program, state: RunState, name: str) -> bool:
    """Whether a state runs something, which is not remembered alone until it begins again."""
    machine = program.machines.get(name)
    return name in state.running and not (isinstance(machine, Machine) and machine.is_stopped(state.running[name]))


ABSENT: Any = object()
"""In the place of an activity that was left meanwhile."""


def live(program: Program, state: RunState) -> Iterator[tuple[str, Machine, Any]]:
    """The activities that run, each with its machine and state; one that is left meanwhile is passed over.

    From any thread: what is left or entered meanwhile by a step may be missed, and nothing fails.
    """
    running = state.running
    for name in tuple(running):
        machine, activity = program.machines[name], running.get(name, ABSENT)
        if activity is not ABSENT and machine is not None:
            yield name, machine, activity


def awake(program: Program, state: RunState) -> Iterator[tuple[str, Machine, Any]]:
    """The activities that run in states that are not held, each with its machine and state."""
    if not state.frozen:
        return live(program, state)
    nodes = program.graph.nodes
    return (each for each in live(program, state) if not is_held(state, nodes[each[0]]))


def is_awaited(program: Program, state: RunState, number: int) -> bool:
    """Whether what runs waits for what comes under this number."""
    return any(number in machine.awaits(activity) for _, machine, activity in live(program, state))


def is_for_held(program: Program, state: RunState, number: int) -> bool:
    """Whether what runs in a held state waits for what comes under this number."""
    return bool(state.frozen) and any(
        number in machine.awaits(activity)
        for name, machine, activity in live(program, state)
        if is_held(state, program.graph.nodes[name])
    )
