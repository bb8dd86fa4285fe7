# SPDX-License-Identifier: Apache-2.0
"""One step, from its event to its value: what is due comes first, then the event, to completion.

Rule: a step is closed here and, where it does so little that it takes the short way, in `Chart.send`.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.compiled.program import Named, Program
from rai_missions.engine.compiled.states import Act, CompiledState, Content
from rai_missions.engine.compiled.surroundings import Surroundings
from rai_missions.engine.decision import stale_verdict, with_verdicts
from rai_missions.engine.robot_facts import RobotFacts
from rai_missions.engine.semantics.actions import act_of
from rai_missions.engine.semantics.blackboard import ask_named
from rai_missions.engine.semantics.commands import resync
from rai_missions.engine.semantics.completion import enter_each, reach_final
from rai_missions.engine.semantics.events import handle, handle_before_start
from rai_missions.engine.semantics.hold import held_controls
from rai_missions.engine.semantics.macrostep import complete, make_move
from rai_missions.engine.semantics.running import resting, take_back
from rai_missions.engine.semantics.timing import catch_up, look_ahead, look_for_time
from rai_missions.engine.state import RunState, StepDraft
from rai_missions.engine.step import Step
from rai_missions.event import Event
from rai_missions.guards.view import Truth
from rai_missions.keys import Stamped
from rai_missions.mission.garbage import few_collections
from rai_missions.mission.mission import Mission

__all__ = ("begin_run", "close", "compiled", "fresh", "make_step")


@few_collections()
def compiled(
    mission: Mission,
    ticker: Trees | None = None,
    *,
    robot_facts: RobotFacts | None = None,
    named: Named | None = None,
    surroundings: Surroundings | None = None,
) -> Program:
    """A mission, ready to run.

    Raises:
        UsageError: As `Program` does.
    """
    keys, has_trees = mission.blackboard, any(state.root() is not None for _, _, state in mission.walk())

    def reaching(node: CompiledState, complete: tuple[CompiledState, ...]) -> Act:
        return lambda program, state: reach_final(program, state, node, complete)

    content = Content(
        lambda effect, place, state: act_of(effect, place, state, keys, has_trees=has_trees),
        lambda node, history: lambda program, state: enter_each(program, state, node, history),
        reaching,
        (surroundings if surroundings is not None else Surroundings()).site,
    )
    return Program(
        mission, content, ticker, has_trees=has_trees, robot_facts=robot_facts, named=named, surroundings=surroundings
    )


def fresh(program: Program) -> RunState:
    """What a run remembers before it has begun."""

    def ask(state: RunState, name: str, arguments: Mapping[str, Any]) -> Truth:
        return ask_named(program, state, name, arguments)

    known = {name: Stamped(key.initial, 0.0) for name, key in program.keys.items() if key.initial is not None}
    return RunState(board=known, config=program.graph.empty, ask=ask)


def begin_run(program: Program, state: RunState, at: float) -> None:
    """Enter the mission; the step is not closed yet."""
    board, keys = state.board, program.keys
    state.at = max(at, state.at)
    for name, (value, since) in [*board.items()]:
        key = keys[name]
        if key.initial is not None and key.source != "robot" and since < state.at:
            board[name] = Stamped(value, state.at)
    state.mode, state.held_since = "running", state.at
    state.frozen = dict.fromkeys(held_controls(program, state), state.at)
    make_move(program, state, program.graph.start(state.memory))
    complete(program, state, None)


def make_step(program: Program, state: RunState, event: Event) -> Step:
    """Let an event happen: everything due before it first, then it, to completion.

    Args:
        program: The mission.
        state: Its run.
        event: One that `check_event` finds no fault in.
    """
    at = max(event.at, state.at)
    if event.kind == "command" and event.name == "take_up":
        resync(program, state, event)
    if state.mode == "ready":
        state.at = at
        handle_before_start(program, state, event)
    else:
        catch_up(program, state, at)
        state.at = at
        handle(program, state, event)
    return close(program, state, event)


def close(program: Program, state: RunState, event: Event) -> Step:
    """The value of the step in hand; the next one begins with an empty draft."""
    draft = state.draft
    if draft.given_up:
        take_back(program, state)
    changed = bool(draft.moves or draft.effects or draft.notes or draft.touched)
    is_fact = event.kind in ("write", "tick")
    if not changed and not draft.refused and is_fact and state.mode == "running":
        look_for_time(program, state)
    else:
        look_ahead(program, state)
    is_over = state.outcome is not None and state.mode == "ended"
    why = state.why if is_over and (draft.ended or not draft.refused) else draft.refused
    notes, verdicts = with_verdicts(draft.notes) if draft.notes else ((), ())
    if draft.refused and event.kind == "proposal":
        verdicts = (*verdicts, stale_verdict(event, draft.refused))
    state.quiet = is_fact and not (
        changed or (draft.looked and any(place.startswith("named:") for place, _ in draft.looked))
    )
    state.draft = StepDraft()
    state.seq += 1
    made: Step = tuple.__new__(
        Step,
        (  # the fields in their order: naming them takes a microsecond of ten
            state.seq,
            state.at,
            event,
            tuple(draft.moves),
            tuple(draft.looked),
            tuple(draft.written),
            state.outcome,
            state.wake_at,
            tuple(draft.effects),
            why,
            notes,
            resting(program, state),
            state.shown_mode,
            state.holder,
            verdicts,
            draft.refusal,
            draft.is_kept,
        ),
    )
    return made
