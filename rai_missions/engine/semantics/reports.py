# SPDX-License-Identifier: Apache-2.0
"""What servers, services, answerers and behaviours report, and to which activity it belongs."""

from __future__ import annotations

from collections.abc import Mapping

from rai_missions.engine.activities.call import replies_to
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.decision import VerdictNote, stale_verdict
from rai_missions.engine.semantics.actions import failed_call
from rai_missions.engine.semantics.hold import is_awaited, is_for_held
from rai_missions.engine.semantics.macrostep import complete, react
from rai_missions.engine.semantics.running import dispatch, poll
from rai_missions.engine.semantics.waiting import hold_event, pause_event, report, trigger_of
from rai_missions.engine.state import RunState, refuse
from rai_missions.event import Event, EventKind

__all__ = ("WATCHED", "handle_late", "receive_answer", "receive_report", "watch_goal")

WATCHED: Mapping[EventKind, str] = {
    "refused": "its server refuses to cancel it",
    "lost": "its server is gone",
    "contested": "more than one server has it",
    "stray": "it is executing although its end was reported; it is canceled",
    "over": "it is executing nowhere any more",
    "overdue": "it is not waited for any longer",
}
"""Kind of event about a goal outside its course → what is noted where its server gives no words."""


def receive_answer(program: Program, state: RunState, event: Event) -> bool:
    """Give an event to the activity that waits for it, and take what that enables; whether one waited."""
    if not dispatch(program, state, event):
        return False
    complete(program, state, None)
    return True


def receive_report(program: Program, state: RunState, event: Event) -> None:
    """An action's server or a service has reported."""
    number, draft = event.number, state.draft
    is_known = number in state.goals
    if state.mode == "paused" and is_awaited(program, state, number):
        return pause_event(program, state, event)
    if is_for_held(program, state, number):
        return hold_event(program, state, event)
    report(state, event)
    if number in state.calls and event.kind == "result":
        service = state.calls.pop(number)
        if event.name != "succeeded":
            word = event.name if event.name in replies_to(None) else "failed"
            react(program, state, failed_call(state, service, str(event.data.get("why", word))))
        return
    if state.outcome is not None or not receive_answer(program, state, event):
        if not is_known:
            refuse(state, "stale", f"stale: nothing that was started as {number} is running")
            return
        if event.kind == "result":
            draft.notes.append(f"goal {number} has ended: {event.name}")
        _settle(program, state, is_due=poll(program, state))


def watch_goal(program: Program, state: RunState, event: Event) -> None:
    """What a goal's servers do outside its course: refuse a cancel, be two, execute it after its end, stop it."""
    why = str(event.data.get("why", "")) or WATCHED[event.kind]
    if event.number not in state.goals and event.kind != "stray":
        refuse(state, "stale", f"stale: nothing that was started as {event.number} is running")
        return
    state.draft.notes.append(f"goal {event.number} of '{event.name}': {why}")
    report(state, event)
    poll(program, state)
    _settle(program, state)


def _settle(program: Program, state: RunState, *, is_due: bool = False) -> None:
    if (is_due or state.draft.internal) and state.outcome is None:
        complete(program, state, None)


def handle_late(program: Program, state: RunState, event: Event) -> None:
    """What has waited for the hand-back, or the end of a pause, happens now, unless what it is for is held."""
    if state.outcome is not None:
        return
    if event.number and is_for_held(program, state, event.number):
        state.held_events = (*state.held_events, event)
    elif event.kind in ("proposal", "behaviour"):
        if not receive_answer(program, state, event) and event.kind == "proposal":
            why = f"stale: question {event.number} is no longer asked"
            state.draft.notes.append(VerdictNote(stale_verdict(event, why), why))
    elif event.number:
        receive_report(program, state, event)
    elif (trigger := trigger_of(program, state, event)) is not None:
        react(program, state, trigger)
