# SPDX-License-Identifier: Apache-2.0
"""Who holds control: what happens as it changes hands, as the operator takes it, and as the operator gives it back."""

from __future__ import annotations

import math
from collections.abc import Container

from rai_missions.engine.compiled.program import Program
from rai_missions.engine.compiled.states import CompiledState
from rai_missions.engine.semantics.hold import held_by, held_controls, holder_of, is_held, run_at, runs
from rai_missions.engine.semantics.macrostep import complete
from rai_missions.engine.semantics.reports import handle_late
from rai_missions.engine.semantics.running import begin, request_control, stop_activity
from rai_missions.engine.semantics.stopped_time import give_time_back
from rai_missions.engine.state import RunState, refuse
from rai_missions.engine.step import Handover, control_note
from rai_missions.errors import suggestion
from rai_missions.event import Event, is_taken
from rai_missions.states.control import HOLDERS

__all__ = ("ask_back", "interrupt", "is_kept", "receive_control", "settle_holds")


def receive_control(program: Program, state: RunState, event: Event) -> None:
    """Control is with a holder from now on: what waited for it starts, what needs another waits."""
    holder = next((each for each in HOLDERS if each == event.name), None)
    if holder is None:
        refuse(state, "unknown", f"nobody called '{event.name}' can hold control{suggestion(event.name, HOLDERS)}")
        return
    before = held_by(state)
    state.taken = is_taken(event, holder=state.holder or "", taken=state.taken, asked=state.asked)
    state.holder, state.asked = holder, "" if state.asked == event.name else state.asked
    state.draft.notes.append(control_note(event.name))
    if state.mode == "ready":
        return
    if held_by(state) != before:
        state.held_since = state.at
    _change_hands(program, state)


def _change_hands(program: Program, state: RunState) -> None:
    nodes, held, was = program.graph.nodes, held_controls(program, state), frozenset(state.frozen)
    freed = was - held
    for name in [name for name in state.running if _is_lost(program, state, nodes[name], held | freed)]:
        stop_activity(program, state, nodes[name])
        state.awaiting_control[name] = math.inf
        state.draft.notes.append(f"{name} waits until control is with {nodes[name].control} again")
    if freed:
        _thaw(program, state, freed)
    if held - was:
        _freeze(program, state, held - was)
    if state.mode == "paused":
        return
    for name in sorted(state.awaiting_control, key=lambda each: nodes[each].index):
        if nodes[name].control == state.holder:
            _get_control(program, state, name)
    complete(program, state, None)
    if freed:
        kept, state.held_events = state.held_events, ()
        for event in kept:
            handle_late(program, state, event)


def _is_lost(program: Program, state: RunState, node: CompiledState, waiting: Container[str]) -> bool:
    """What runs there has lost control, and neither waits for the hand-back nor continues by it."""
    is_elsewhere = node.control is not None and node.control != state.holder and node.control not in waiting
    return is_elsewhere and runs(program, state, node.name)


def _get_control(program: Program, state: RunState, name: str) -> None:
    """What waits for control has it."""
    if state.awaiting_control.pop(name, None) is not None and not runs(program, state, name):
        begin(program, state, program.graph.nodes[name])


# -- taken, and given back --------------------------------------------------------------------------------------------


def _freeze(program: Program, state: RunState, controls: frozenset[str]) -> None:
    """The states that need one of these are held from now on."""
    nodes, draft = program.graph.nodes, state.draft
    # What was asked for in this step, before control was taken, would reach the robot afterwards, and take it away.
    unasked = [each for each in draft.effects if isinstance(each, Handover) and each.to in controls]
    if unasked:
        draft.effects = [each for each in draft.effects if each not in unasked]
        state.asked = ""
    state.frozen = {**state.frozen, **dict.fromkeys(controls, run_at(state))}
    waiting = {name for name in state.awaiting_control if nodes[name].control in controls}
    waiting |= {node.name for node in state.config.atomic if node.control in controls and not node.activity}
    for name in list(state.running):
        if nodes[name].control in controls and interrupt(program, state, nodes[name]):
            waiting.add(name)
    for name in waiting:
        state.awaiting_control.pop(name, None)
    waiting -= set(state.paused_starts)
    state.draft.notes += [f"{name} waits until control is given back" for name in sorted(waiting)]
    state.held_starts = tuple(sorted({*state.held_starts, *waiting}, key=lambda name: nodes[name].index))


def is_kept(program: Program, node: CompiledState) -> bool:
    """Whether a profile lists under `keep` what a state does: a pause and a handover leave it as it is."""
    return getattr(node.state, "action", None) in program.robot_facts.keep


def interrupt(program: Program, state: RunState, node: CompiledState, *, keeps: bool = True) -> bool:
    """End what may move the robot, and is to start again later.

    Args:
        program: The mission, compiled.
        state: The run.
        node: What is running.
        keeps: What a profile lists under `keep` continues.
    """
    if node.state is None or not node.state.yields or (keeps and is_kept(program, node)):
        return False
    if not runs(program, state, node.name):
        return False
    stop_activity(program, state, node)
    return True


def _thaw(program: Program, state: RunState, controls: frozenset[str]) -> None:
    """The states that need one of these are held no more: they have the time that they had left."""
    nodes = program.graph.nodes
    give_time_back(program, state, controls)
    state.frozen = {control: since for control, since in state.frozen.items() if control not in controls}
    free = tuple(name for name in state.held_starts if nodes[name].control in controls)
    state.held_starts = tuple(name for name in state.held_starts if name not in free)
    if state.mode == "paused":
        state.paused_starts += free
        state.paused_events, state.held_events = (*state.held_events, *state.paused_events), ()
        return
    state.draft.starting += [nodes[name] for name in free]
    state.draft.due |= {name for name in state.running if nodes[name].control in controls}
    state.draft.unseen |= state.draft.due
    ask_back(program, state)


def settle_holds(program: Program, state: RunState) -> None:
    """Give what is held, now, the time that it had left: what begins from here on counts from the same instant."""
    give_time_back(program, state, state.frozen)
    state.frozen = dict.fromkeys(state.frozen, run_at(state))


def ask_back(program: Program, state: RunState) -> None:
    """Ask for the control that what continues to run had."""
    names = [name for name in state.running if name not in state.awaiting_control and runs(program, state, name)]
    for node in [program.graph.nodes[name] for name in names]:
        if node.control is not None and node.control != holder_of(program, state) and not is_held(state, node):
            request_control(state, node)
