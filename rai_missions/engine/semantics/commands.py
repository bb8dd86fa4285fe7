# SPDX-License-Identifier: Apache-2.0
"""Pause, stop, resume, cancel and e-stop: what a person may do to any mission, drawn in none; and resumed runs.

The e-stop is the command `kill` of events and of Python; for people it has that one word everywhere.

Rule: in which mode a command makes sense is read from `modes`, and nowhere else.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rai_missions.engine.activities.tree import is_settling, questions_in
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.modes import refusal
from rai_missions.engine.semantics.blackboard import known, note_news
from rai_missions.engine.semantics.completion import end, kill
from rai_missions.engine.semantics.handover import ask_back, interrupt
from rai_missions.engine.semantics.hold import awake, held_controls, holder_of, is_held, run_at, runs
from rai_missions.engine.semantics.macrostep import check_stopped, complete, make_move
from rai_missions.engine.semantics.reports import handle_late
from rai_missions.engine.semantics.running import poll
from rai_missions.engine.semantics.stopped_time import shift
from rai_missions.engine.semantics.timers import late_s
from rai_missions.engine.semantics.timing import look_ahead
from rai_missions.engine.semantics.waiting import drop_reports
from rai_missions.engine.snapshot import control_of, put_back
from rai_missions.engine.snapshot_json import unpacked
from rai_missions.engine.state import RunState, refuse
from rai_missions.engine.step import Move
from rai_missions.errors import suggestion
from rai_missions.event import Event
from rai_missions.keys import Stamped, type_error

__all__ = ("receive_command", "resync")

COMMANDS = ("pause", "stop", "resume", "cancel", "kill")
"""What a person may order."""


def receive_command(program: Program, state: RunState, event: Event) -> None:
    """Obey a command, or refuse it with the reason."""
    by = str(event.data.get("by", "")) or "command"
    if event.name == "take_up":
        _continue(program, state)
    elif event.name == "migrate" and state.mode == "ready":
        _migrate(program, state, event.data)
    elif event.name not in COMMANDS and state.outcome is None:
        refuse(state, "unknown", f"no command '{event.name}'{suggestion(event.name, COMMANDS)}")
    elif why := refusal(state.shown_mode, event.name):
        refuse(state, "mode" if state.outcome is None else "ended", why)
    elif event.name == "kill":
        kill(program, state, f"e-stop by {by}")
    elif event.name == "cancel":
        _cancel(program, state, by)
    elif state.mode == "ready":
        _hold_back(state, is_back=event.name != "resume")
    elif event.name == "pause":
        _pause(program, state)
    elif event.name == "stop":
        _stop(program, state)
    else:
        _resume(program, state)


def _cancel(program: Program, state: RunState, by: str) -> None:
    drop_reports(state, None)
    if state.mode == "paused":
        shift(program, state, state.at - state.paused_at)
    state.paused_starts = state.held_starts = ()
    state.mode, state.why = "canceling", f"canceled by {by}"
    state.cancel_by = state.at + program.mission.cancel_s
    if program.mission.on_cancel is None or not state.config.atomic:
        return end(program, state, "canceled", state.why)
    state.final = None
    target = program.graph.nodes[program.mission.on_cancel]
    make_move(program, state, program.graph.move_to(state.config, target, state.memory, "cancel"))
    complete(program, state, None)


def _hold_back(state: RunState, *, is_back: bool) -> None:
    """Pause before the start, where nothing moves yet: the mission does not begin until that is taken back."""
    state.paused_at = state.paused_at if state.held_back else state.at
    state.held_back = is_back
    state.draft.notes.append("paused before the start" if is_back else "resumed")


def _pause(program: Program, state: RunState) -> None:
    state.mode, state.paused_at = "paused", state.at
    nodes = program.graph.nodes
    state.paused_starts = tuple(name for name in list(state.running) if interrupt(program, state, nodes[name]))
    state.draft.notes.append("paused")


def _stop(program: Program, state: RunState) -> None:
    """Pause, if it is not paused, and end the goals that a pause would keep; each starts again as after a pause."""
    if state.mode != "paused":
        _pause(program, state)
    nodes = program.graph.nodes
    ended = [name for name in list(state.running) if interrupt(program, state, nodes[name], keeps=False)]
    held = [name for name in ended if is_held(state, nodes[name])]
    state.paused_starts += tuple(name for name in ended if name not in held)
    state.held_starts += tuple(held)
    state.draft.notes.append("stopped")


def _resume(program: Program, state: RunState) -> None:
    nodes, draft = program.graph.nodes, state.draft
    shift(program, state, state.at - state.paused_at)
    state.mode, draft.goal_ended = "running", True
    draft.notes.append("resumed")
    draft.starting += [nodes[name] for name in state.paused_starts]
    for name in [name for name in state.awaiting_control if nodes[name].control == holder_of(program, state)]:
        del state.awaiting_control[name]
        draft.starting += [] if runs(program, state, name) else [nodes[name]]
    events, state.paused_events, state.paused_starts = state.paused_events, (), ()
    draft.due |= frozenset(state.running)  # each may have read what has changed since
    draft.unseen |= draft.due
    ask_back(program, state)
    complete(program, state, None)
    for event in events:
        handle_late(program, state, event)


# -- another process, another mission ---------------------------------------------------------------------------------


def resync(program: Program, state: RunState, event: Event) -> None:
    """Let another process continue: what the robot reported to the one before is forgotten if it can grow stale.

    This comes before time continues: nothing is stale that was received again.
    """
    state.present = float(event.data.get("present", max(event.at, state.at)))
    keys, board, received = program.keys, state.board, event.data.get("heard", {})
    robot = [name for name, key in keys.items() if key.source == "robot"] if program.has_trees else []
    before = {name: known(program, state, name) for name in robot}
    for name in [name for name in board if keys[name].must_recur]:
        del board[name]
    for name, (value, at) in received.items():
        if name in keys and not type_error(keys[name], value):
            board[name] = Stamped(value, float(at))
            state.draft.written.append((name, value))
    for name, value in before.items():
        note_news(program, state, name, value)
    look_ahead(program, state)


def _continue(program: Program, state: RunState) -> None:
    state.draft.touched = True  # what the robot has reported since was noted before
    if state.mode == "paused":
        _begin_new(program, state)
        check_stopped(program, state)
    elif state.mode != "ready" and state.outcome is None:
        _ask_again(program, state)
        _begin_new(program, state)
        state.draft.due = state.draft.unseen = frozenset(state.running)  # what was read may not be known any more
        poll(program, state)
        complete(program, state, None)


def _ask_again(program: Program, state: RunState) -> None:
    """Give what another process asks for once more its time.

    A handover has all of it; a question, and what waits for facts to confirm a result, has what was left of it.
    """
    nodes, by_s = program.graph.nodes, late_s(state)
    for name, machine, activity in awake(program, state) if by_s else ():
        if any(questions_in(activity)) or is_settling(activity):
            state.running[name] = machine.shift(activity, by_s)
    for name in state.settling:
        state.settling[name] += 0.0 if is_held(state, nodes[name]) else by_s
    for name, until in state.awaiting_control.items():
        node = nodes[name]
        if node.state is not None and until < math.inf and not is_held(state, node):
            state.awaiting_control[name] = max(until, state.at + node.state.handover_s)


def _begin_new(program: Program, state: RunState) -> None:
    """Begin what a migration has brought: `entry` where nothing was before, and what runs there."""
    begins, state.migrated_starts, draft = state.migrated_starts, (), state.draft
    for name, is_new in begins:
        node = program.graph.nodes[name]
        for act in node.entry if is_new else ():
            act(program, state)
        if (node.activity or node.control) and node in state.config.atomic:
            draft.starting.append(node)
    if state.mode == "paused":
        state.paused_starts += tuple(node.name for node in draft.starting)
        draft.starting = []


def _migrate(program: Program, state: RunState, data: Mapping[str, Any]) -> None:
    """Be where a run of another mission was; what is new begins when the run is resumed."""
    graph = program.graph
    put_back(program, state, unpacked(data["stands"]))
    state.frozen = dict.fromkeys(held_controls(program, state), run_at(state))
    state.timers = {key: timer._replace(control=control_of(program, key, timer)) for key, timer in state.timers.items()}
    clocked = {name for name, node in (*graph.nodes.items(), ("", graph.root)) if node.clocked}
    state.entered = {name: at for name, at in state.entered.items() if name in clocked}
    state.migrated_starts = tuple(data["begins"])
    state.draft.effects += unpacked(data["under_way"])
    state.draft.notes += data["notes"]
    nodes = sorted(state.config.nodes, key=lambda node: node.index)
    state.draft.moves.append(Move((), (), tuple(node.name for node in nodes if node.state is not None), "migrate"))
