# SPDX-License-Identifier: Apache-2.0
"""What each kind of event does to a run.

Rule: an event has one receiver, found by its kind; whatever makes no sense now is refused, and changes nothing.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping

from rai_missions.engine.compiled.program import Program
from rai_missions.engine.semantics.blackboard import known, note_news
from rai_missions.engine.semantics.commands import receive_command
from rai_missions.engine.semantics.handover import receive_control
from rai_missions.engine.semantics.hold import is_awaited, is_for_held
from rai_missions.engine.semantics.macrostep import check_stopped, complete, react
from rai_missions.engine.semantics.reports import WATCHED, receive_answer, receive_report, watch_goal
from rai_missions.engine.semantics.running import poll
from rai_missions.engine.semantics.waiting import hold_event, pause_event, waiting_answers
from rai_missions.engine.state import RunState, Trigger, refuse
from rai_missions.errors import suggestion
from rai_missions.event import KINDS, Event, EventKind
from rai_missions.keys import Stamped, stale_at, type_error

__all__ = ("handle", "handle_before_start")

NOT_STARTED = "the mission has not been started"
"""Why an event before the start changes nothing."""
BEFORE_START = ("pause", "stop", "resume", "cancel", "kill", "take_up", "migrate")
"""The commands that make sense before the start."""
Receiver = Callable[[Program, RunState, Event], None]


def handle(program: Program, state: RunState, event: Event) -> None:
    """Let an event do what it does, now that the mission has begun."""
    state.draft.tree_rounds.clear()
    if receive := ALWAYS.get(event.kind):
        receive(program, state, event)
    elif state.outcome is not None:
        refuse(state, "ended", "the mission has ended")
    elif receive := UNTIL_END.get(event.kind):
        receive(program, state, event)
    elif state.final is not None and state.mode != "paused":
        refuse(state, "ended", f"the mission is ending in '{state.final.name}'")
    else:
        UNTIL_FINAL.get(event.kind, _refuse_kind)(program, state, event)


def handle_before_start(program: Program, state: RunState, event: Event) -> None:
    """Let an event do what it does before the start of the mission."""
    if event.kind == "write":
        _receive_early(program, state, event)
    elif event.kind == "control":
        receive_control(program, state, event)
    elif event.kind == "command" and event.name in BEFORE_START:
        receive_command(program, state, event)
    else:
        refuse(state, "not_started", NOT_STARTED)


def _pass(program: Program, state: RunState, event: Event) -> None:
    """Time has passed, or a goal reports on its way: what that does is done already."""


def _refuse_kind(program: Program, state: RunState, event: Event) -> None:
    refuse(state, "unknown", f"there is no event of kind '{event.kind}'{suggestion(event.kind, KINDS)}")


# -- the world outside ------------------------------------------------------------------------------------------------


def _receive_event(program: Program, state: RunState, event: Event) -> None:
    """Something that the mission declares; while paused it waits."""
    if event.kind == "event" and event.name not in program.declared:
        sentence = f"the mission declares no event '{event.name}'"
        refuse(state, "unknown", sentence + suggestion(event.name, program.declared))
    elif state.mode == "paused":
        pause_event(program, state, event)
    else:
        react(program, state, Trigger(event.name, event.data))


def _receive_answer(program: Program, state: RunState, event: Event) -> None:
    """A proposal, or the end of a behaviour; what has to wait for its question is the first answer to it alone."""
    number, is_held = event.number, is_for_held(program, state, event.number)
    if event.kind == "proposal" and (state.mode == "paused" or is_held) and _is_answered(state, number):
        refuse(state, "stale", f"stale: question {number} has an answer, which waits")
    elif event.kind == "proposal" and state.mode == "paused" and not is_awaited(program, state, number):
        refuse(state, "stale", f"stale: question {number} is no longer asked")
    elif state.mode == "paused":
        pause_event(program, state, event)
    elif is_held:
        hold_event(program, state, event)
    elif not receive_answer(program, state, event) and event.kind == "proposal":
        refuse(state, "stale", f"stale: question {event.number} is no longer asked")


def _is_answered(state: RunState, number: int) -> bool:
    """Whether an answer to a question waits for the end of a pause, or for the hand-back."""
    return any(each.number == number for each in waiting_answers(state))


def _receive_early(program: Program, state: RunState, event: Event) -> None:
    """A write before the start; a reading that is stale as it comes is no reason to begin."""
    name, board = event.name, state.board
    is_known = name in board and name not in state.outdated
    _write(program, state, event)
    if not is_known and name in board:
        is_fresh = state.at < stale_at(program.keys[name], board[name])
        state.outdated = state.outdated - {name} if is_fresh else state.outdated | {name}


def _write(program: Program, state: RunState, event: Event) -> None:
    name, draft = event.name, state.draft
    key = program.keys.get(name)
    value = event.data.get("value")
    stamp = min(float(event.data.get("stamp", event.at)), state.at)
    if key is None:
        refuse(state, "unknown", f"the mission has no key '{name}'{suggestion(name, program.keys)}")
        return
    if why := type_error(key, value):
        refuse(state, "unfit", f"'{name}' was not written: {why}")
        return
    entry = state.board.get(name)
    if entry is not None and entry.at > stamp:
        refuse(state, "unfit", f"'{name}' was not written: {entry.at - stamp:.3g} s older than what is known")
        return
    before = known(program, state, name) if program.has_trees else None
    state.board[name] = Stamped(value, stamp)
    draft.written.append((name, value))
    if name not in state.watched and "*" not in state.watched:
        return
    if program.has_trees:
        note_news(program, state, name, before)
    if state.mode == "paused":
        check_stopped(program, state)
    elif state.mode != "ready":
        poll(program, state)
        complete(program, state, None)


ALWAYS: Mapping[EventKind, Receiver] = {
    "tick": _pass,
    "feedback": _pass,
    "command": receive_command,
    "accepted": receive_report,
    "result": receive_report,
    **dict.fromkeys(WATCHED, watch_goal),
}
"""Kind → its receiver, after the end of the mission too."""
UNTIL_END: Mapping[EventKind, Receiver] = {"write": _write, "control": receive_control}
UNTIL_FINAL: Mapping[EventKind, Receiver] = {
    "event": _receive_event,
    "doubt": _receive_event,
    "proposal": _receive_answer,
    "behaviour": _receive_answer,
}
"""Kind → its receiver, unless the mission is ending already."""
