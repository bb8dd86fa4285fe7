# SPDX-License-Identifier: Apache-2.0
"""The short way: a step that does so little that its value is known without a draft.

Rule: it is taken from `Chart.send` where the last step has found it open (`RunState.quick`), and comes to the same as
`stepping.make_step`; what it cannot do it hands over before it has changed anything.
"""

from __future__ import annotations

from math import inf

from rai_missions.engine.activities.activity import NO_KEYS
from rai_missions.engine.activities.ticker import TickResult
from rai_missions.engine.activities.tree import acted
from rai_missions.engine.compiled.configuration import CompiledMove, Looked
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.compiled.states import Written
from rai_missions.engine.decision import with_verdicts
from rai_missions.engine.semantics.blackboard import is_other, value_at
from rai_missions.engine.semantics.macrostep import complete, enabled
from rai_missions.engine.semantics.running import Host, take_turn
from rai_missions.engine.semantics.stepping import close, make_step
from rai_missions.engine.semantics.timers import late_s
from rai_missions.engine.semantics.timing import next_instant
from rai_missions.engine.semantics.watched_names import RunningTree, WatchedNames
from rai_missions.engine.state import RunState, StepDraft
from rai_missions.engine.step import Effect, Move, Step
from rai_missions.event import Event
from rai_missions.given import check_event
from rai_missions.guards.view import Truth
from rai_missions.keys import Stamped, type_error

__all__ = ("BEFORE", "finish_move", "receive_event", "receive_reading", "short_step")

_new = tuple.__new__
BEFORE = -inf
"""Ahead of every time."""


def receive_reading(program: Program, state: RunState, event: Event) -> Step:
    """What a write does at which no one looks, or one tree alone."""
    name, at, data, _, _ = event
    watched, board = state.watched, state.board
    by_trees = watched if type(watched) is WatchedNames else None
    trees, names = (by_trees.trees, by_trees.names) if by_trees is not None else ((), watched)
    key, now, stamp = program.keys.get(name), at if at > state.at else state.at, data.get("stamp", at)
    if stamp.__class__ is not float or not BEFORE < stamp <= now:
        check_event(event, "a chart")
        stamp = min(float(stamp), now)
    if key is None or name in names or "*" in names:
        return make_step(program, state, event)
    given, entry = data.get("value"), board.get(name)
    if type_error(key, given) or (entry is not None and entry.at > stamp):
        return make_step(program, state, event)
    looking: RunningTree | None = None
    for each in trees:
        if each[1].watches(each[2], (name,)):
            if looking is not None or state.config.watchful or program.held_in_invariants:
                return make_step(program, state, event)
            looking = each
    state.at = now
    board[name] = made = _new(Stamped, (given, stamp))
    if looking is None or by_trees is None:
        return short_step(state, event, (), (), ((name, given),), quiet=True)
    if key.max_age_s is None and entry is not None:
        is_news = not (given is entry.value or given == entry.value)
    else:
        is_news = is_other(value_at(key, entry, now), key, made, now)
    return _looked_at(program, state, event, by_trees, looking, is_news=is_news)


def _looked_at(
    program: Program, state: RunState, event: Event, watched: WatchedNames, tree: RunningTree, *, is_news: bool
) -> Step:
    """The end of a step in which one tree looks at what was written, as `running.poll` and `complete` would let it."""
    name, machine, activity = tree
    key, written = event.name, (event.name, event.data["value"])
    ticked: TickResult | None = None
    if is_news and machine.is_for_tree(activity, key):
        ticked = machine.look(activity, key, state, late_s(state))
        if not acted(ticked):
            rests = machine.rest(activity, ticked, state)
            if rests is not activity:
                state.running[name] = rests
                state.watched = watched.with_tree((name, machine, rests))
                if rests.wake != activity.wake:
                    state.wake = next_instant(program, state)
            return short_step(state, event, (), (), (written,), quiet=rests is activity)
    draft, host = state.draft, Host(program, state)
    draft.written.append(written)
    draft.polled = 1
    if ticked is not None:
        turn = machine.follow(activity, ticked, host)
    else:
        keys = frozenset((key,))
        news = keys if is_news else NO_KEYS
        tick = Event("tick", state.at, {"keys": keys, "news": news, "unseen": False}, "tick")
        turn = machine.receive(activity, tick, host)
    if turn is not None:
        take_turn(program, state, name, turn)
        does_more = draft.internal or draft.notes or draft.news or draft.goal_ended or len(draft.written) > 1
        if does_more or turn.state.limit:
            complete(program, state, None)
            return close(program, state, event)
        state.watched = watched.with_tree((name, machine, turn.state))
    state.wake = next_instant(program, state)
    effects = tuple(draft.effects)
    draft.effects, draft.touched, draft.polled = [], False, 0
    draft.written.clear()
    draft.tree_rounds.clear()
    return short_step(state, event, (), (), (written,), effects, quiet=turn is None)


def receive_event(program: Program, state: RunState, event: Event) -> Step:
    """What an event does that has not yet done it in this configuration; if it does little, it is remembered."""
    name, at, data, _, _ = event
    if name not in program.declared:  # one that the engine raises has a plan, too
        return make_step(program, state, event)
    if at > state.at:
        state.at = at
    config = state.config
    plan = config.plans.get(name)
    if plan is None:
        plan = config.plan(name, declared=True)
    state.event = data
    looked: list[tuple[str, Truth]] = []
    transitions = enabled(state, plan, looked)
    if not transitions:
        return short_step(state, event, (), tuple(looked))
    move = config.moves.get((tuple(transitions), name))
    if move is None or not move.plain:
        return make_step(program, state, event)
    first = plan[0][0]
    if all(chain[0].test is None for chain in plan):
        config.direct[name] = (None, (), move)
    elif len(plan) == len(plan[0]) == 1:
        config.direct[name] = (first.test, ((first.place, True),), move)
    return finish_move(program, state, event, move, tuple(looked))


def finish_move(program: Program, state: RunState, event: Event, move: CompiledMove, looked: Looked) -> Step:
    """The end of a step that makes a move; its time and its payload are the run's already."""
    if not state.watched.isdisjoint(move.shifts):
        return make_step(program, state, event)
    state.config = move.config
    if not move.acts:
        return short_step(state, event, move.values, looked)
    draft, timers = state.draft, (state.order, len(state.timers))
    for act in move.acts:
        act(program, state)
    written = draft.written
    if draft.internal or (written and state.watched):
        draft.moves.append(move.value)
        draft.looked += looked
        draft.presence_changes |= move.shifts
        complete(program, state, None, made=1)
        return close(program, state, event)
    if (state.order, len(state.timers)) != timers:
        state.wake = next_instant(program, state)
    if draft.effects or draft.notes or draft.news:
        notes = with_verdicts(draft.notes)[0] if draft.notes else ()
        state.draft = StepDraft()
        return short_step(state, event, move.values, looked, tuple(written), tuple(draft.effects), notes)
    made = short_step(state, event, move.values, looked, tuple(written))
    written.clear()
    return made


def short_step(
    state: RunState,
    event: Event,
    moves: tuple[Move, ...],
    looked: Looked,
    written: Written = (),
    effects: tuple[Effect, ...] = (),
    notes: tuple[str, ...] = (),
    *,
    quiet: bool = False,
) -> Step:
    """The value of such a step; without moves no transition fired."""
    state.seq = seq = state.seq + 1
    state.quiet = quiet
    wake = state.wake
    return _new(
        Step,
        (
            seq,
            state.at,
            event,
            moves,
            looked,
            written,
            None,
            None if wake == inf else wake,
            effects,
            "",
            notes,
            (),
            "running",
            state.holder,
            (),
            "",
            False,
        ),
    )
