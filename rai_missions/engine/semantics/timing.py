# SPDX-License-Identifier: Apache-2.0
"""Time: what was due until now happens at its own instant, and the next instant is known."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from heapq import heappop, heappush
from itertools import chain

from rai_missions.engine.activities import goal_ledger
from rai_missions.engine.activities.activity import NO_KEYS, Outcome
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.semantics.completion import end
from rai_missions.engine.semantics.hold import awake
from rai_missions.engine.semantics.macrostep import MOST_MICROSTEPS, check_stopped, complete, react
from rai_missions.engine.semantics.running import leave_activity, outcome_of, poll, resting, unfinished, watched
from rai_missions.engine.state import RunState, Timer, TimerKey, Trigger
from rai_missions.engine.step import CancelGoal
from rai_missions.guards.view import Instant

__all__ = ("catch_up", "look_ahead", "look_for_time", "next_instant", "pass_instant")


def catch_up(program: Program, state: RunState, at: float) -> None:
    """Let everything that was due until `at` happen, each at its own instant."""
    if at < state.wake:
        return
    same, moved, draft = 0, False, state.draft
    if rounds := unfinished(program, state):
        draft.due, moved = rounds, True
        pass_instant(program, state)
    while (due := next_instant(program, state)) <= at and same < MOST_MICROSTEPS:
        same, moved = same + 1 if due <= state.at else 0, True
        draft.due = unfinished(program, state).union(_woken(program, state, due))
        state.at = max(state.at, due)
        pass_instant(program, state)
    if same >= MOST_MICROSTEPS:
        _end_endless(program, state)
    if moved:
        state.watched = watched(program, state)  # what comes now finds what time has made of it


def _woken(program: Program, state: RunState, due: float) -> Iterable[str]:
    """The states whose activities asked for an instant not later than this."""
    for name, machine, activity in awake(program, state) if state.running else ():
        if machine.wake_at(activity, state) <= due:
            yield name


def _end_endless(program: Program, state: RunState) -> None:
    end(program, state, "failed", f"timers without end in {', '.join(sorted(state.active))}", cause="cycle")


def pass_instant(program: Program, state: RunState) -> None:
    """What time alone does now."""
    draft, now = state.draft, state.at
    draft.tree_rounds.clear()
    if state.mode == "paused":
        _give_up_goals(program, state)
        check_stopped(program, state)
        return
    if state.mode == "canceling" and now >= state.cancel_by:
        end(program, state, "canceled", "the cancel took longer than cancel_s")
    due, draft.due = draft.due, NO_KEYS  # the activities' turn comes after that of all timers
    for rung, key in enumerate(_ringing(state)):
        if rung == MOST_MICROSTEPS:
            return _end_endless(program, state)
        _ring(program, state, key, state.timers.pop(key))
    _reject_late_handovers(program, state)
    _give_up_goals(program, state)
    draft.due = due
    poll(program, state)
    complete(program, state, None)


def _reject_late_handovers(program: Program, state: RunState) -> None:
    """States that were not given control in time report that they were rejected."""
    now = state.at
    for name in [name for name, until in state.awaiting_control.items() if until <= now]:
        if state.awaiting_control.get(name, math.inf) > now:
            continue  # the one before led out of it, or into it again
        del state.awaiting_control[name]
        node = program.graph.nodes[name]
        state.draft.given_up.add(node.control)
        leave_activity(program, state, node)
        rejected = Outcome("rejected", why=f"{node.control} was not given control in time")
        react(program, state, outcome_of(node, rejected))


def _give_up_goals(program: Program, state: RunState) -> None:
    """Goals whose end was not confirmed in time are orphans from now on."""
    for goal in goal_ledger.give_up_overdue(state.goals, state.at) if state.goals else ():
        state.draft.goal_ended = True
        state.draft.notes.append(f"goal {goal.number} of '{goal.action}' never confirmed its end: orphaned")
        if goal.phase == "withdrawn":  # no acceptance may come any more: the server is asked to cancel all the same
            state.draft.effects.append(CancelGoal(goal.number, goal.action))
        react(program, state, Trigger("orphaned", {"action": goal.action, "number": goal.number}))


def _ringing(state: RunState) -> Iterator[TimerKey]:
    """The timers that are due, in their order; each that rings may set, drop and stop others, or end the mission."""
    waiting, known, frozen = list[tuple[float, int, TimerKey]](), -1, dict[str, float]()
    while state.outcome is None:
        if state.frozen != frozen:
            waiting, known, frozen = [], -1, {**state.frozen}
        for key, timer in reversed(state.timers.items()):  # `set_timer` lays a timer behind those that were set before
            if timer.order <= known:
                break
            if timer.due <= state.at and timer.control not in frozen:
                heappush(waiting, (timer.due, timer.order, key))
        known = state.order
        if not waiting:
            return
        due, order, key = heappop(waiting)
        if key in state.timers and state.timers[key][:2] == (due, order):
            yield key


def _ring(program: Program, state: RunState, key: TimerKey, timer: Timer) -> None:
    kind, which = key
    state.draft.touched = True
    if kind == "after":
        react(program, state, Trigger("after_s", {}, transition=program.graph.transitions[which]))
    elif kind == "timeout":
        node = program.graph.nodes[which]
        leave_activity(program, state, node)
        react(program, state, outcome_of(node, Outcome("timed_out", why=f"{timer.name} s have passed")))
    else:
        react(program, state, Trigger(timer.name, timer.data))


# -- what comes next --------------------------------------------------------------------------------------------------


def look_ahead(program: Program, state: RunState) -> None:
    """What the next event finds: whether it can take the short way, what it may change, what time alone does."""
    is_running = state.mode == "running" and state.final is None and state.outcome is None
    state.quick = is_running and not program.named and not state.frozen and not resting(program, state)
    state.watched = watched(program, state) if state.mode != "ended" else NO_KEYS
    look_for_time(program, state)


def look_for_time(program: Program, state: RunState) -> None:
    """When time alone does something: at once, where the rounds of a tree follow at this instant."""
    state.wake = state.at if unfinished(program, state) else next_instant(program, state)


def next_instant(program: Program, state: RunState) -> float:
    """The earliest instant at which time alone can change something."""
    soonest = goal_ledger.next_overdue(state.goals) if state.goals else math.inf
    if state.mode == "ended" or state.mode == "ready":
        return soonest if state.mode == "ended" else math.inf
    for _, condition in program.invariants:
        if condition.instants:
            soonest = _soonest(state, condition.instants, soonest)
    if state.mode == "paused":
        return soonest
    if state.cancel_by < soonest:
        soonest = state.cancel_by
    if state.timers or state.awaiting_control or state.settling:
        soonest = min(soonest, _deadline(program, state))
    if state.config.instants:
        soonest = _soonest(state, state.config.instants, soonest)
    if state.settling or state.final is not None:
        finals = {state.final, *(program.graph.nodes[name] for name in state.settling)}
        requires = [final.requires for final in finals if final is not None and final.requires is not None]
        soonest = _soonest(state, chain.from_iterable(each.instants for each in requires), soonest)
    for _, machine, activity in awake(program, state) if state.running else ():
        soonest = min(soonest, machine.wake_at(activity, state))
    return soonest


def _soonest(state: RunState, instants: Iterable[Instant], soonest: float) -> float:
    """The earliest of these that is yet to come, and of what is known already."""
    for instant in instants:
        if soonest > (due := instant(state)) > state.at:
            soonest = due
    return soonest


def _deadline(program: Program, state: RunState) -> float:
    """The next one of timers, handovers and finals, but for what is stopped."""
    soonest, frozen, nodes = math.inf, state.frozen, program.graph.nodes
    for timer in state.timers.values():
        if timer.due < soonest and not (frozen and timer.control in frozen):
            soonest = timer.due
    for until in state.awaiting_control.values():
        soonest = min(soonest, until)
    for name, until in state.settling.items():
        if until < soonest and (not frozen or state.final is not None or nodes[name].control not in frozen):
            soonest = until
    return soonest
