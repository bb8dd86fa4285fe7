# SPDX-License-Identifier: Apache-2.0
"""Run to completion: which transitions a trigger fires, what taking them leaves and enters, until nothing is enabled.

Source: W3C SCXML (REC-scxml-20150901), appendix D, `mainEventLoop`, `selectTransitions`, `microstep`.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from typing import Any

from rai_missions.engine.activities.activity import Outcome
from rai_missions.engine.compiled.configuration import CompiledMove, Plan
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.compiled.states import CompiledState, CompiledTransition
from rai_missions.engine.semantics.completion import (
    check_invariants,
    complete_parallels,
    current_round,
    end,
    has_reported,
    is_current,
    set_item,
    settle_final,
    settle_nested,
)
from rai_missions.engine.semantics.hold import free, is_held
from rai_missions.engine.semantics.running import begin_starting, leave_activity, outcome_of, poll
from rai_missions.engine.semantics.timers import late_s, now_of, set_timer
from rai_missions.engine.semantics.waiting import event_of, hold_trigger, pause_event
from rai_missions.engine.state import RunState, StepDraft, Trigger
from rai_missions.guards.view import Test, Truth
from rai_missions.mission.mission import BUILT_IN_EVENTS

__all__ = ("MOST_MICROSTEPS", "check_stopped", "complete", "enabled", "make_move", "react")

MOST_MICROSTEPS = 10_000
"""Microsteps at one instant; a mission that wants more runs in circles."""
ACTING = ("running", "canceling")
"""The modes in which transitions are taken."""


def react(program: Program, state: RunState, trigger: Trigger) -> None:
    """A macrostep of its own: after a pause, if there is one; after the end, nothing."""
    if state.outcome is not None:
        return
    if state.mode == "paused":
        pause_event(program, state, event_of(state, trigger))
    elif state.mode in ACTING:
        complete(program, state, trigger)


def enabled(state: RunState, plan: Plan, looked: list[tuple[str, Truth]]) -> list[CompiledTransition]:
    """The first transition of each chain whose guard is true (SCXML: selectTransitions)."""
    transitions: dict[CompiledTransition, None] = {}
    for chain in plan:
        for transition in chain:
            test = transition.test
            if test is not None:
                value = test(state)
                looked.append((transition.place, value))
                if value is not True:
                    continue
            transitions[transition] = None
            break
    return [*transitions]


def complete(program: Program, state: RunState, trigger: Trigger | None, *, made: int = 0) -> None:
    """Take what is enabled until nothing is (SCXML: mainEventLoop), after so many microsteps that were made before."""
    draft, seen = state.draft, set[Any]()
    draft.macrosteps, draft.microsteps, draft.in_rounds = draft.macrosteps + 1, made, 0
    draft.round_bounds.clear()
    while draft.microsteps - draft.in_rounds < MOST_MICROSTEPS:
        draft.microsteps += 1
        if _is_over(program, state):
            return
        if trigger is not None:
            _answer(program, state, trigger)
            trigger = None
            continue
        config = state.config
        if config.held_guards or program.held_in_invariants:
            _note_held(program, state)
        waiting = config.eventless if not state.frozen else free(state, config.eventless)
        if waiting and (transitions := enabled(state, waiting, draft.looked)):
            taken = tuple([transition.place for transition in transitions])
            circle = (config.key, taken, len(draft.written), len(draft.internal))
            if circle in seen:
                return _end_circle(program, state)
            seen.add(circle)
            _take(program, state, transitions, "")
        elif draft.internal:
            trigger = draft.internal.popleft()
            seen.clear()
        elif draft.starting:
            begin_starting(program, state)
        elif poll(program, state):
            draft.microsteps -= 1  # what activities do ends by itself
        else:
            break
    else:
        return _end_circle(program, state)
    if state.settling:
        settle_nested(program, state)
        if draft.internal:
            return complete(program, state, None)
    check_invariants(program, state)


def _is_over(program: Program, state: RunState) -> bool:
    """Whether no transition is taken any more; a final that was reached is given the chance to count."""
    if state.outcome is not None or state.mode not in ACTING:
        return True
    if state.final is None:
        return False
    settle_final(program, state)
    return True


def _end_circle(program: Program, state: RunState) -> None:
    states = " → ".join(dict.fromkeys(name for move in state.draft.moves[-50:] for name in move.entered))
    end(program, state, "failed", f"a cycle without end: {states or 'internal events'}", cause="cycle")


# -- transitions ------------------------------------------------------------------------------------------------------


def _answer(program: Program, state: RunState, trigger: Trigger) -> None:
    """Find the transitions that a trigger fires, and take them."""
    source, config = trigger.source, state.config
    if trigger.name == "round" and source is not None and source.is_each:
        return hold_trigger(program, state, trigger) if is_held(state, source) else _next_round(program, state, source)
    state.event, option = trigger.data, False
    if trigger.transition is not None:
        plan: Plan = ((trigger.transition,),)
    elif source is None:
        found = config.plans.get(trigger.name)
        plan = found if found is not None else config.plan(trigger.name, declared=trigger.name in program.declared)
    else:
        option = trigger.name in source.options
        state.answer = trigger.data if option else state.answer
        plan = config.outcome_plan(
            source,
            trigger.name,
            option=option,
            climbs=trigger.climbs and trigger.name != "succeeded",
            is_late=trigger.is_late,
        )
    open_plan = plan if not state.frozen else free(state, plan)
    transitions = enabled(state, open_plan, state.draft.looked)
    if transitions:
        _take(program, state, transitions, trigger.name)
    elif state.frozen and open_plan != plan:
        hold_trigger(program, state, trigger)
    elif source is not None:
        _unanswered(program, state, trigger, source)
    elif trigger.transition is None and (trigger.name in BUILT_IN_EVENTS or state.draft.moves):
        state.draft.notes.append(f"no row took '{trigger.name}'")


def _unanswered(program: Program, state: RunState, trigger: Trigger, source: CompiledState) -> None:
    """An outcome that no transition handles: unless it is a success, it is the mission's failure."""
    if trigger.is_late:
        state.draft.notes.append(f"'{trigger.name}' of '{source.name}' came to nothing: the state had been left")
    elif trigger.name == "succeeded":
        if source.activity:
            state.draft.notes.append(f"no row took 'succeeded' of '{source.name}'")
    elif trigger.climbs and state.config.is_active(source):
        why = f"{source.name}: {trigger.name}" + (f" ({trigger.why})" if trigger.why else "")
        end(program, state, "failed", why)


def _take(program: Program, state: RunState, transitions: list[CompiledTransition], trigger: str) -> None:
    make_move(program, state, program.graph.move_of(state.config, tuple(transitions), state.memory, trigger))


def make_move(program: Program, state: RunState, move: CompiledMove) -> None:
    """Make one microstep."""
    if not program.surroundings.before_move(state, move):
        return _end_circle(program, state)
    if move.remember:
        _remember(state, move)
    for node in move.exited:
        _exit(program, state, node)
    if state.draft.internal or state.draft.starting or state.held_events:
        _outdate(state, move.exited)
    state.config = move.config
    state.draft.presence_changes |= move.shifts
    state.draft.moves.append(move.value)
    for act in move.acts:
        act(program, state)
    for node in move.entered:
        _enter(program, state, node)


def _remember(state: RunState, move: CompiledMove) -> None:
    """Note what histories lead back to, and where in their lists the states are that they lead back into."""
    state.memory.update(move.remember)
    for history, node in move.lists:
        state.lists[history.name, node.name] = current_round(state, node)


def _exit(program: Program, state: RunState, node: CompiledState) -> None:
    if node.timed:
        state.timers.pop(("timeout", node.name), None)
        for transition in node.transitions:
            state.timers.pop(("after", transition.place), None)
    if node.name in state.running:
        leave_activity(program, state, node)
    _forget_waiting(state, node)
    if node.clocked:
        state.entered.pop(node.name, None)
    if state.true_since:
        for transition in node.transitions:
            for memory in transition.condition.held_guards if transition.condition else ():
                state.true_since.pop(memory, None)
    if node.is_final and node.parent is not None and node.parent.is_each:
        _resume_last_round(state, node.parent)


def _resume_last_round(state: RunState, each: CompiledState) -> None:
    """Where a list stays active and the final of its last round is left, what follows is about the last item again."""
    items, index = state.rounds[each.name]
    if items and index == len(items):
        state.rounds[each.name] = items, index - 1


def _outdate(state: RunState, exited: tuple[CompiledState, ...]) -> None:
    """What states that are left have reported, and no transition has answered, is late; they begin nothing more."""
    draft, left = state.draft, {node.name for node in exited}
    draft.starting = [node for node in draft.starting if node.name not in left]
    state.held_events = tuple(
        each for each in state.held_events if each.kind != "outcome" or each.data["state"] not in left
    )
    for _ in range(len(draft.internal)):
        trigger = draft.internal.popleft()
        source = trigger.source
        if source is None or source.name not in left:
            draft.internal.append(trigger)
        elif not (trigger.name == "round" and source.is_each):  # a round that is left does not begin again
            draft.internal.append(trigger._replace(is_late=True))


def _forget_waiting(state: RunState, node: CompiledState) -> None:
    """What a state that is left waited for makes no difference any more."""
    name = node.name
    if state.awaiting_control.pop(name, math.inf) < math.inf:
        state.draft.given_up.add(node.control)
    state.settling.pop(name, None)
    state.unmet.pop(name, None)
    if state.held_starts:
        state.held_starts = tuple(each for each in state.held_starts if each != name)
    if node.is_each and state.rounds.pop(name, None) is not None:
        state.draft.round_bounds[name] = math.inf


def _enter(program: Program, state: RunState, node: CompiledState) -> None:
    """Become active; a plain move (`CompiledMove.plain`) of the short way in `Chart.send` does without this."""
    if node.control is not None:
        program.surroundings.before_entry(state, node)
    if node.clocked:
        state.entered[node.name] = now_of(state, node.control)
    if node.timed:
        _set_timers(state, node)
    if (node.activity or node.control) and node in state.config.atomic:
        state.draft.starting.append(node)
    if node.is_each and node in state.config.atomic:
        _next_round(program, state, node, is_entry=True)
    elif node.is_each and not state.rounds[node.name][0]:
        _end_list(program, state, node)


def _set_timers(state: RunState, node: CompiledState) -> None:
    """Start what a state, or the mission, waits for from its entry on."""
    if node.state is not None and node.state.timeout_s is not None:
        limit_s = node.state.timeout_s
        set_timer(state, ("timeout", node.name), late_s(state) + limit_s, f"{limit_s:g}", None, node.control)
    for transition in node.transitions:
        if transition.definition.after_s is not None:
            set_timer(state, ("after", transition.place), transition.definition.after_s, "after_s", None, node.control)


def _next_round(program: Program, state: RunState, node: CompiledState, *, is_entry: bool = False) -> None:
    """Make the next item of a list the current one; after the last one the `each` succeeds.

    On entry the item is current already, unless an effect of that entry has written its key.
    """
    program.surroundings.before_round(state, node)
    _pass_round(program, state.draft, node)
    items, index = state.rounds[node.name]
    if index < len(items):
        if (is_entry and is_current(state, node, items[index])) or set_item(program, state, node, items[index]):
            make_move(program, state, program.graph.reenter(state.config, node, state.memory))
    else:
        _end_list(program, state, node)


def _end_list(program: Program, state: RunState, node: CompiledState) -> None:
    """A list has no further item: its `each` succeeds, unless it has reported something else."""
    if not has_reported(state, node):
        state.draft.internal.append(outcome_of(node, Outcome("succeeded")))
        complete_parallels(state, tuple(program.graph.complete(node.parent, state.config.is_active)))


def _pass_round(program: Program, draft: StepDraft, node: CompiledState) -> None:
    """Let the limits of a step count for each round of a list alone: it has an end, however long.

    They do for one visit to the list in a macrostep, so that a cycle of transitions round a list ends.
    """
    made = draft.microsteps - draft.in_rounds
    began = draft.round_bounds.setdefault(node.name, made)
    if made > began:
        draft.in_rounds += int(made - began)
        for owner in [each for each in draft.tree_rounds if program.graph.nodes[each].inside(node)]:
            del draft.tree_rounds[owner]


def check_stopped(program: Program, state: RunState) -> None:
    """Check the invariants in a pause; their guards inside `held` have no time that stops."""
    _note_true(state, program.held_in_invariants)
    check_invariants(program, state)


def _note_held(program: Program, state: RunState) -> None:
    """Remember since when the guards inside `held` have been true; those of held states wait for the hand-back."""
    guards, owners = state.config.held_guards, program.graph.held_owners
    if state.frozen:
        guards = {memory: test for memory, test in guards.items() if owners[memory].control not in state.frozen}
    _note_true(state, guards)
    _note_true(state, program.held_in_invariants)


def _note_true(state: RunState, guards: Mapping[str, Test]) -> None:
    for memory, test in guards.items():
        is_true = test(state) is True
        if is_true is not (memory in state.true_since):
            state.draft.touched = True
            if is_true:
                state.true_since[memory] = state.at
            else:
                del state.true_since[memory]
