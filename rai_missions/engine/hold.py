# SPDX-License-Identifier: Apache-2.0
"""What waits while the operator keeps control: a state is held whose innermost `control` is not with its holder.

Rule: held follows from who has control alone. Timers, transitions, activities and events ask here, and nowhere else.
"""

from __future__ import annotations

from collections.abc import Callable, Container, Iterable, Iterator, Mapping
from typing import Any

from rai_missions.engine.activities import goal_ledger
from rai_missions.engine.activities.activity import Machine
from rai_missions.engine.nodes import CompiledTransition, Node
from rai_missions.engine.program import Program
from rai_missions.engine.state import TABLE, Holds, RunState, Trigger
from rai_missions.event import Event
from rai_missions.states.control import Holder

__all__ = (
    "awake", "drop_reports", "event_of", "free", "give_time_back", "held_by", "held_controls",
    "holder_of", "is_awaited", "is_for_held", "is_held", "keep", "keep_trigger", "live", "run_at", "shift",
    "trigger_of", "wait_out_pause", "waiting_answers",
)  # fmt: skip

Plan = tuple[tuple[CompiledTransition, ...], ...]
Controls = Container[str | None]


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


def is_held(state: RunState, node: Node) -> bool:
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
    """Those of them whose state is not held."""
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


# -- what came meanwhile ----------------------------------------------------------------------------------------------


def keep(program: Program, state: RunState, event: Event) -> None:
    """Have an event wait for the hand-back."""
    if not program.surroundings.waits(state, event, state.kept):
        return
    state.kept = (*state.kept, event)
    state.draft.touched = state.draft.is_kept = True
    what = f"the outcome '{event.name}' of '{event.data['state']}'" if event.kind == "outcome" else f"'{event.name}'"
    state.draft.notes.append(f"{what} waits until the operator gives control back")


def keep_trigger(program: Program, state: RunState, trigger: Trigger) -> None:
    """The same for what only the transitions of held states name, wherever it came from."""
    keep(program, state, event_of(state, trigger))


def wait_out_pause(program: Program, state: RunState, event: Event) -> None:
    """Have an event wait until the run is resumed."""
    if program.surroundings.waits(state, event, state.queue):
        state.queue = (*state.queue, event)
        state.draft.touched = state.draft.is_kept = True


def waiting_answers(state: RunState) -> tuple[Event, ...]:
    """The answers that wait for the end of a pause, or for the hand-back: of each question one at most."""
    return tuple(each for each in (*state.queue, *state.kept) if each.kind == "proposal")


def event_of(state: RunState, trigger: Trigger) -> Event:
    """What a trigger waits as; `trigger_of` undoes it."""
    name, data, source = trigger.name, trigger.data, trigger.source
    if source is None:
        return Event(name, state.at, data)
    given = {"state": source.name, "climbs": trigger.climbs, "why": trigger.why, "data": dict(data)}
    return Event(name, state.at, given, "outcome")


def trigger_of(program: Program, state: RunState, event: Event) -> Trigger | None:
    """The trigger that was kept as this event; None where the state that reported it was left meanwhile."""
    if event.kind != "outcome":
        return Trigger(event.name, event.data)
    node, data = program.graph.nodes[event.data["state"]], event.data
    is_active = node in state.config.nodes
    return Trigger(event.name, data["data"], node, data["climbs"], data["why"]) if is_active else None


def drop_reports(state: RunState, numbers: Container[int] | None) -> None:
    """Take out of what waits all that is reported of what was left; the ledger of goals has it now.

    Args:
        state: Of the run.
        numbers: Of the starts and questions that nothing waits for any more; None for all that there are.
    """
    state.kept, state.queue = (_without(state, each, numbers) for each in (state.kept, state.queue))


def _without(state: RunState, events: Iterable[Event], numbers: Container[int] | None) -> tuple[Event, ...]:
    left = []
    for event in events:
        if not event.number or (numbers is not None and event.number not in numbers):
            left.append(event)
        elif event.kind in ("accepted", "result"):
            report(state, event)
    return tuple(left) if numbers is not None else ()


def report(state: RunState, event: Event) -> None:
    """Enter what was reported of a goal in the ledger."""
    found = goal_ledger.report(state.goals, event)
    state.draft.effects += found.cancels
    state.draft.goal_ended = state.draft.goal_ended or found.is_end


# -- time -------------------------------------------------------------------------------------------------------------


def give_time_back(program: Program, state: RunState, controls: Iterable[str]) -> None:
    """Give the states that need one of these controls, and are held, the time that they had left."""
    for control in sorted(controls):
        shift(program, state, run_at(state) - state.frozen[control], (control,))


def shift(program: Program, state: RunState, by_s: float, controls: Controls | None = None) -> None:
    """Move what waits for time, by how long that was stopped.

    Args:
        program: The mission.
        state: Of the run.
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
    of, always = program.graph.keepers, program.always_held  # invariants are looked at in a pause, too
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


SHIFTS: Mapping[Holds, Callable[[Program, Any, float, Controls | None], Any]] = {
    "ages": _instants,
    "deadlines": _instants,
    "settling": _instants,
    "since": _since,
    "timers": _timers,
    "activities": _activities,
    "controls": _controls,
}
"""What a field holds → how it is moved."""
MOVED = tuple((each.name, SHIFTS[each.holds]) for each in TABLE if each.holds in SHIFTS)
"""The fields that are moved, and how."""
