# SPDX-License-Identifier: Apache-2.0
"""What states run while they are active: started when control allows, informed, and ended when they are left."""

from __future__ import annotations

from collections.abc import Iterable
from collections.abc import Set as AbstractSet
from typing import Any

from rai_missions.engine.activities import goal_ledger
from rai_missions.engine.activities.activity import GOALS, NO_KEYS, Outcome, Turn, stopped, watches
from rai_missions.engine.activities.tree import TreeMachine, limit_of
from rai_missions.engine.activities.tree_rounds import Rounds
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.compiled.states import CompiledState
from rai_missions.engine.semantics.blackboard import write_key
from rai_missions.engine.semantics.hold import awake, holder_of, is_held, live
from rai_missions.engine.semantics.timers import begins_at, next_number
from rai_missions.engine.semantics.waiting import drop_reports
from rai_missions.engine.semantics.watched_names import RunningTree, WatchedNames
from rai_missions.engine.state import RunState, Trigger
from rai_missions.engine.step import CancelGoal, Handover
from rai_missions.event import Event

__all__ = (
    "Host",
    "begin",
    "begin_starting",
    "cancel_goals",
    "dispatch",
    "leave_activity",
    "outcome_of",
    "poll",
    "request_control",
    "resting",
    "stop_activity",
    "take_back",
    "take_turn",
    "unfinished",
    "watched",
)  # fmt: skip


class Host:
    """What activities may call (`ActivityHost`)."""

    __slots__ = ("_program", "view")

    def __init__(self, program: Program, state: RunState) -> None:
        self._program, self.view = program, state

    @property
    def begins_at(self) -> float:
        return begins_at(self.view)

    def next_number(self) -> int:
        return next_number(self.view)

    def open_goal(self, owner: str, action: str, cancel_s: float) -> int:
        number = next_number(self.view)
        self.view.goals[number] = goal_ledger.Goal(number, owner, action, cancel_s)
        return number

    def close_goal(self, number: int) -> None:
        state = self.view
        state.draft.goal_ended = state.goals.pop(number, None) is not None or state.draft.goal_ended

    def obstruction(self, action: str) -> goal_ledger.Obstruction:
        return goal_ledger.obstruction(self.view.goals, self._program.robot_facts, action)

    def write_key(self, key: str, value: Any, by: str = "") -> bool:
        return write_key(self._program, self.view, key, value, by)

    def rounds(self, owner: str, loops: int) -> Rounds:
        rounds = self.view.draft.tree_rounds
        if owner not in rounds:
            rounds[owner] = Rounds(loops)
        return rounds[owner]


def outcome_of(node: CompiledState, outcome: Outcome) -> Trigger:
    """The trigger by which a state reports an outcome."""
    return Trigger(outcome.name, outcome.data, node, why=outcome.why)


# -- started and left -------------------------------------------------------------------------------------------------


def begin_starting(program: Program, state: RunState) -> None:
    """Start the activities of the states that are still active; first those whose control is where it belongs."""
    draft = state.draft
    nodes, draft.starting = sorted(draft.starting, key=lambda node: node.index), []
    for node in nodes:
        if node not in state.config.atomic:  # left meanwhile, or an `each` in whose round another is active
            continue
        if state.frozen and is_held(state, node):
            state.held_starts = (*state.held_starts, node.name)
        elif node.control is not None and node.control != holder_of(program, state):
            request_control(state, node)
        else:
            begin(program, state, node)


def request_control(state: RunState, node: CompiledState) -> None:
    """Ask for the control that a state needs; it waits for its `handover_s`."""
    assert node.state is not None and node.control is not None
    state.asked, request = node.control, Handover(node.control)
    if request not in state.draft.effects:
        state.draft.effects.append(request)
    state.awaiting_control[node.name] = begins_at(state) + node.state.handover_s


def take_back(program: Program, state: RunState) -> None:
    """Ask for control where it is: what asked for it elsewhere was left before it came, and nothing else waits."""
    given_up = state.draft.given_up
    if given_up and state.outcome is None and (holder := holder_of(program, state)) not in ("operator", "nobody"):
        wanted = {program.graph.nodes[name].control for name in state.awaiting_control}
        if given_up - wanted - {holder}:
            state.asked = holder
            state.draft.effects.append(Handover(holder))


def begin(program: Program, state: RunState, node: CompiledState) -> None:
    """Start a state's activity."""
    machine = program.machine(node) if node.activity else None
    if machine is not None:
        host, before = Host(program, state), state.running.get(node.name)
        turn = machine.begin(host) if before is None else machine.begin_again(before, host)
        state.running[node.name] = turn.state
        take_turn(program, state, node.name, turn)


def stop_activity(program: Program, state: RunState, node: CompiledState) -> None:
    """End what a state runs, which begins again later; its machine may remember it until then."""
    machine = program.machines.get(node.name)
    turn = stopped(machine, state.running[node.name], Host(program, state)) if machine is not None else None
    if turn is None or turn.state is None:
        return leave_activity(program, state, node)
    state.running[node.name] = turn.state
    _emit(state, turn.effects)


def leave_activity(program: Program, state: RunState, node: CompiledState) -> None:
    """End what a state runs."""
    activity = state.running.pop(node.name, None)
    machine = program.machines.get(node.name)
    if activity is not None and machine is not None:
        if state.held_events or state.paused_events:
            drop_reports(state, machine.awaits(activity))
        turn = machine.leave(activity, Host(program, state))
        _emit(state, turn.effects)
        state.draft.notes += turn.notes


# -- informed ---------------------------------------------------------------------------------------------------------


def take_turn(program: Program, state: RunState, name: str, turn: Turn) -> None:
    """Take over what a machine has made of something."""
    state.draft.touched, state.draft.watched_by_activities = True, None
    for key, value in turn.writes:
        write_key(program, state, key, value)
    _emit(state, turn.effects)
    state.draft.notes += turn.notes
    if turn.outcome is None and turn.state is not None:
        state.running[name] = turn.state
        return
    state.running.pop(name, None)
    if turn.outcome is None:
        return
    state.awaiting_control.pop(name, None)
    node = program.graph.nodes[name]
    state.timers.pop(("timeout", name), None)
    if turn.outcome.why and not node.options:
        state.draft.notes.append(f"{name} {turn.outcome.name}: {turn.outcome.why}")
    state.draft.internal.append(outcome_of(node, turn.outcome))


def _emit(state: RunState, effects: Iterable[Any]) -> None:
    for effect in effects:
        if isinstance(effect, CancelGoal):
            cancel_goals(state, (effect.number,))
        else:
            state.draft.effects.append(effect)


def cancel_goals(state: RunState, numbers: Iterable[int]) -> None:
    """End goals: a cancel is sent for each that was accepted, for the others once they are."""
    for number in tuple(numbers):
        state.draft.effects += goal_ledger.cancel(state.goals, number, begins_at(state))


ANY_KEY = frozenset({"*"})
"""Every key, among names that are watched."""


def poll(program: Program, state: RunState) -> bool:
    """Let those activities look whom a key, a state, a goal's end or the time concerns; whether one acted."""
    draft = state.draft
    if not (draft.due or draft.goal_ended or draft.presence_changes or draft.news or draft.polled < len(draft.written)):
        return False
    if state.outcome is not None or state.mode == "paused":
        return False
    changed = draft.presence_changes.union({GOALS} if draft.goal_ended else NO_KEYS)
    keys = frozenset(key for key, _ in draft.written[draft.polled :]).union(changed, draft.news)
    due, draft.due, draft.polled, draft.goal_ended = draft.due, NO_KEYS, len(draft.written), False
    news, draft.news, draft.presence_changes = draft.news, {}, set()
    unseen, draft.unseen = draft.unseen, NO_KEYS
    if not state.running or not (due or _concerns_some(program, state, keys)):
        return False
    has_acted = False
    for name, machine, activity in awake(program, state):
        if name not in due and not watches(machine, activity, keys):
            continue
        of_others = frozenset(changed | {key for key, by in news.items() if by != name})
        tick = Event("tick", state.at, {"keys": keys, "news": of_others, "unseen": name in unseen}, "tick")
        turn = machine.receive(activity, tick, Host(program, state))
        if turn is not None:
            take_turn(program, state, name, turn)
            has_acted = True
    return has_acted


def _concerns_some(program: Program, state: RunState, keys: frozenset[str]) -> bool:
    """Whether some activity may want to be notified of one of these; all are asked again once one has had its turn."""
    draft = state.draft
    if draft.watched_by_activities is None:
        draft.watched_by_activities = _watched_by_activities(program, state, NO_KEYS)
    return not draft.watched_by_activities.isdisjoint(keys | ANY_KEY)


def dispatch(program: Program, state: RunState, event: Event) -> bool:
    """Give an event to the activity that waits for it; whether one did."""
    for name, machine, activity in live(program, state):
        turn = machine.receive(activity, event, Host(program, state))
        if turn is not None:
            take_turn(program, state, name, turn)
            poll(program, state)
            return True
    return False


# -- what follows -----------------------------------------------------------------------------------------------------


def resting(program: Program, state: RunState) -> tuple[str, ...]:
    """The states whose trees rest at a limit."""
    found = state.running.items() if program.has_trees and state.running else ()
    return tuple(name for name, activity in found if limit_of(activity))


def unfinished(program: Program, state: RunState) -> frozenset[str]:
    """The states whose trees have rounds left that follow at this instant."""
    if not program.has_trees or not state.running:
        return NO_KEYS
    return frozenset(name for name, activity in state.running.items() if limit_of(activity) == "rounds")


def watched(program: Program, state: RunState) -> AbstractSet[str]:
    """What may change something now when it changes: keys, and states that an activity asks for."""
    found = state.config.reads | program.graph.invariant_reads
    if state.settling or state.final is not None:
        found |= ANY_KEY
    return _watched_by_activities(program, state, found)


def _watched_by_activities(program: Program, state: RunState, found: frozenset[str]) -> AbstractSet[str]:
    """The given names, and those that the running activities ask for."""
    trees = list[RunningTree]()
    for name, machine, activity in live(program, state) if state.running else ():
        if isinstance(machine, TreeMachine):
            trees.append((name, machine, activity))
        else:
            found |= machine.reads(activity)
    return WatchedNames(found, tuple(trees)) if trees else found
