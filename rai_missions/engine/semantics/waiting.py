# SPDX-License-Identifier: Apache-2.0
"""Events that wait: for the end of a pause, or until the operator gives control back."""

from __future__ import annotations

from collections.abc import Container, Iterable

from rai_missions.engine.activities import goal_ledger
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.state import RunState, Trigger
from rai_missions.event import Event

__all__ = (
    "drop_reports", "event_of", "hold_event", "hold_trigger", "pause_event", "report", "trigger_of",
    "waiting_answers",
)  # fmt: skip


def hold_event(program: Program, state: RunState, event: Event) -> None:
    """Have an event wait for the hand-back."""
    if not program.surroundings.waits(state, event, state.held_events):
        return
    state.held_events = (*state.held_events, event)
    state.draft.touched = state.draft.is_kept = True
    what = f"the outcome '{event.name}' of '{event.data['state']}'" if event.kind == "outcome" else f"'{event.name}'"
    state.draft.notes.append(f"{what} waits until the operator gives control back")


def hold_trigger(program: Program, state: RunState, trigger: Trigger) -> None:
    """Have a trigger wait for the hand-back: only transitions of held states name it."""
    hold_event(program, state, event_of(state, trigger))


def pause_event(program: Program, state: RunState, event: Event) -> None:
    """Have an event wait until the run is resumed."""
    if program.surroundings.waits(state, event, state.paused_events):
        state.paused_events = (*state.paused_events, event)
        state.draft.touched = state.draft.is_kept = True


def waiting_answers(state: RunState) -> tuple[Event, ...]:
    """The answers that wait for the end of a pause, or for the hand-back: of each question one at most."""
    return tuple(each for each in (*state.paused_events, *state.held_events) if each.kind == "proposal")


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
        state: The state of the run.
        numbers: Of the starts and questions that nothing waits for any more; None for all that there are.
    """
    state.held_events, state.paused_events = (
        _without(state, each, numbers) for each in (state.held_events, state.paused_events)
    )


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
