# SPDX-License-Identifier: Apache-2.0
"""How things end: rounds of a list, finals, parallel states, the mission; and what must never be false."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from typing import Any

from rai_missions.engine.activities import goal_ledger
from rai_missions.engine.activities.activity import Outcome
from rai_missions.engine.compiled.program import Program
from rai_missions.engine.compiled.states import CompiledGuard, CompiledState
from rai_missions.engine.semantics.blackboard import write_key
from rai_missions.engine.semantics.hold import is_held
from rai_missions.engine.semantics.running import cancel_goals, leave_activity, outcome_of
from rai_missions.engine.semantics.timers import begins_at, late_s, now_of
from rai_missions.engine.semantics.waiting import drop_reports
from rai_missions.engine.state import RunState, Trigger
from rai_missions.engine.step import Cause
from rai_missions.guards.view import Operand, Site
from rai_missions.keys import stale_at, type_error
from rai_missions.states.compound import Each
from rai_missions.states.final import Final, FinalOutcome, worst

__all__ = (
    "check_invariants", "complete_parallels", "current_round", "end", "enter_each", "has_reported", "is_current",
    "kill", "reach_final", "set_item", "settle_final", "settle_nested",
)  # fmt: skip


def has_reported(state: RunState, node: CompiledState) -> bool:
    """Whether a state that was not left since has an outcome that is yet to be answered in this step."""
    return any(trigger.source is node and not trigger.is_late for trigger in state.draft.internal)


# -- lists ------------------------------------------------------------------------------------------------------------


def enter_each(program: Program, state: RunState, node: CompiledState, history: CompiledState | None) -> None:
    """Copy the list of an `each`; its first item is current from here on.

    A history that leads back into it leads back to the items and the item that were current when it was left.
    """
    assert isinstance(node.state, Each)
    was = state.lists.get((history.name, node.name)) if history is not None else None
    if was is not None and was[0]:
        state.rounds[node.name] = items, index = was
        set_item(program, state, node, items[index])
        return
    value = Operand(node.state.each, Site(node.place, program.keys)).read(state)
    state.rounds[node.name] = (tuple(value) if isinstance(value, list | tuple) else (), 0)
    if not isinstance(value, list | tuple):
        why = f"the list {node.state.each} is unknown"
        state.draft.internal.append(outcome_of(node, Outcome("failed", why=why)))
    elif value:
        set_item(program, state, node, value[0])


def current_round(state: RunState, node: CompiledState) -> tuple[tuple[Any, ...], int]:
    """The items of an `each`, and which of them its active states are about: that of a final is not over yet."""
    items, index = state.rounds[node.name]
    finals = (final for final in _reached(state, node) if final.name not in state.settling)
    return items, index - any(_counted(state, final) == "succeeded" for final in finals)


def is_current(state: RunState, node: CompiledState, item: Any) -> bool:
    """Whether the key of an `each` has this very item."""
    assert isinstance(node.state, Each)
    entry = state.board.get(node.state.item)
    return entry is not None and entry.value is item


def set_item(program: Program, state: RunState, node: CompiledState, item: Any) -> bool:
    """Make an item the current one. One that does not fit its key ends the `each`: its round would use another."""
    assert isinstance(node.state, Each)
    key = program.keys.get(node.state.item)
    why = type_error(key, item) if key is not None else "the mission has no such key"
    if why and not has_reported(state, node):
        state.draft.internal.append(
            outcome_of(node, Outcome("failed", why=f"an item cannot be '{node.state.item}': {why}"))
        )
    if not why:
        write_key(program, state, node.state.item, item)
    return not why


# -- finals -----------------------------------------------------------------------------------------------------------


def reach_final(program: Program, state: RunState, node: CompiledState, complete: tuple[CompiledState, ...]) -> None:
    """A final was entered: at the top it ends the mission, else its parent, and parallel states with it."""
    parent = node.parent
    assert parent is not None and isinstance(node.state, Final)
    if parent.state is None:
        state.final = node
        return
    state.unmet.pop(node.name, None)
    if node.requires is not None and node.requires.test(state) is not True:
        within_s = late_s(state) + _settle_s(program, node.state)
        if within_s > 0:
            state.settling[node.name] = now_of(state, node.control) + within_s
            return
        _finish_unmet(program, state, node, complete)
        return
    _finish(state, node, node.state.final, complete)


def _finish_unmet(program: Program, state: RunState, node: CompiledState, complete: tuple[CompiledState, ...]) -> None:
    """The `requires` of a final did not become true in time."""
    assert node.requires is not None
    state.unmet[node.name] = math.inf
    _finish(state, node, "unverified", complete, why=_falls_short(program, state, node.requires))


def _finish(
    state: RunState, final: CompiledState, outcome: str, complete: tuple[CompiledState, ...], why: str = ""
) -> None:
    internal, parent = state.draft.internal, final.parent
    assert parent is not None
    if parent.is_parallel:  # the final is a region
        complete_parallels(state, complete)
        return
    if parent.is_each and outcome == "succeeded" and parent.name in state.rounds:
        items, index = state.rounds[parent.name]
        state.rounds[parent.name] = (items, index + 1)
        if index + 1 < len(items):
            internal.append(Trigger("round", {}, parent))
            return
    in_region = parent.parent is not None and parent.parent.is_parallel
    if not (parent.is_each and has_reported(state, parent)):
        internal.append(outcome_of(parent, Outcome(outcome, why=why))._replace(climbs=not in_region))
    complete_parallels(state, complete)


def complete_parallels(state: RunState, complete: Iterable[CompiledState]) -> None:
    """Parallel states whose regions have all ended report the worst of their outcomes, the inner first.

    Args:
        state: The state of the run.
        complete: Those that may have, as far as the active states show.
    """
    for parallel in complete:
        if not all(_has_ended(state, region) for region in parallel.children):
            return
        if has_reported(state, parallel):
            continue
        outer = parallel.parent is not None and parallel.parent.is_parallel
        done = outcome_of(parallel, Outcome(worst([_counted(state, final) for final in _finals(state, parallel)])))
        state.draft.internal.append(done._replace(climbs=not outer))


def _has_ended(state: RunState, region: CompiledState) -> bool:
    """Whether a region has come to its end: a final that waits for its `requires` is none, nor one of a round."""
    if region.is_parallel:
        return all(_has_ended(state, child) for child in region.children)
    reached = list(_reached(state, region))
    if any(final.name in state.settling for final in reached):
        return False
    if region.is_each and all(_counted(state, final) == "succeeded" for final in reached):
        if region.name not in state.rounds:
            return False
        items, index = state.rounds[region.name]
        return index >= len(items)
    return bool(reached)


def _reached(state: RunState, region: CompiledState) -> Iterator[CompiledState]:
    """The final of a region that is active, or the region where it is one."""
    return (each for each in (region, *region.children) if each.is_final and state.config.is_active(each))


def _finals(state: RunState, parallel: CompiledState) -> Iterator[CompiledState]:
    """The active finals of the regions of a parallel state, and of those that are in it."""
    for region in parallel.children:
        yield from _finals(state, region) if region.is_parallel else _reached(state, region)


def _counted(state: RunState, final: CompiledState) -> str:
    """The outcome that a final has brought."""
    assert isinstance(final.state, Final)
    return "unverified" if final.name in state.unmet else final.state.final


def settle_final(program: Program, state: RunState) -> None:
    """A top-level final is reached: it counts once its `requires` is true, unless that takes too long."""
    check_invariants(program, state)
    node = state.final
    if node is None or state.outcome is not None:
        return
    assert isinstance(node.state, Final)
    requires = node.requires
    if requires is None:
        return end(program, state, node.state.final, f"'{node.name}' was reached")
    value = requires.test(state)
    state.draft.looked.append((requires.place, value))
    until = state.settling.setdefault(node.name, begins_at(state) + _settle_s(program, node.state))
    if value is True:
        end(program, state, node.state.final, f"'{node.name}' was reached, and {requires.guard.words()}")
    elif state.at >= until:
        end(program, state, "failed", f"'{node.name}' was reached, but {_falls_short(program, state, requires)}")


def settle_nested(program: Program, state: RunState) -> None:
    """Finals inside other states whose `requires` was not true when they were entered."""
    for name, until in list(state.settling.items()):
        node = program.graph.nodes[name]
        if state.frozen and is_held(state, node):
            continue
        assert node.parent is not None and node.requires is not None and isinstance(node.state, Final)
        outer = node.parent if node.parent.is_parallel else node.parent.parent
        complete = tuple(program.graph.complete(outer, state.config.is_active))
        is_met = node.requires.test(state) is True
        if not is_met and state.at < until:
            continue
        del state.settling[name]
        state.draft.touched = True  # a region that has ended waits for the others without a move
        if is_met:
            _finish(state, node, node.state.final, complete)
        else:
            _finish_unmet(program, state, node, complete)


def _settle_s(program: Program, final: Final) -> float:
    """How long the facts may take to agree with its `requires`."""
    return program.mission.settle_s if final.settle_s is None else final.settle_s


def _falls_short(program: Program, state: RunState, condition: CompiledGuard) -> str:
    value = condition.test(state)
    ages = [age for key in sorted(condition.reads) if (age := _age(program, state, key))]
    unknown = f" ({', '.join(ages)})" if ages and value is None else ""
    return f"'{condition.guard.words()}' is {'false' if value is False else 'unknown'}{unknown}"


def _age(program: Program, state: RunState, key: str) -> str:
    entry = state.board.get(key)
    if entry is None:
        return f"{key} was never heard"
    is_stale = state.at >= stale_at(program.keys.get(key), entry)
    return f"{key} is {state.at - entry.at:.1f} s old" if is_stale else ""


# -- the mission ------------------------------------------------------------------------------------------------------


def check_invariants(program: Program, state: RunState) -> None:
    """End the mission where an invariant is false; note those that have become unknown."""
    if state.outcome is not None or not program.invariants:
        return
    unknown, draft = set(), state.draft
    for name, condition in program.invariants:
        value = condition.test(state)
        if value is False:
            draft.looked.append((condition.place, value))
            state.false_invariant = name
            return kill(program, state, f"invariant '{name}' is false: {condition.guard.words()}", cause="invariant")
        if value is None:
            unknown.add(name)
    if unknown != state.unknown:
        draft.notes += [f"invariant '{name}' is unknown" for name in sorted(unknown - state.unknown)]
        draft.touched, state.unknown = True, frozenset(unknown)


def kill(program: Program, state: RunState, why: str, *, cause: Cause = "") -> None:
    """Stop at once: every goal is canceled, and no one has control."""
    state.draft.effects += goal_ledger.stop_all(state.goals, begins_at(state))
    state.holder, state.taken = "nobody", False
    end(program, state, "aborted", why, killed=True, cause=cause)


def end(
    program: Program, state: RunState, outcome: FinalOutcome, why: str, *, killed: bool = False, cause: Cause = ""
) -> None:
    """The mission is over: everything that runs is ended, and the active states do what they do when left.

    Args:
        program: The mission.
        state: The state of the run.
        outcome: How it ended.
        why: The rule that decided it.
        killed: By an e-stop or an invariant: no `exit` is done, and a cancel under way makes no difference.
        cause: What it was, where no rule of the mission ended it; a cancel under way ends as a cancel all the same.
    """
    if state.outcome is not None:
        return
    if state.mode == "canceling" and not killed:
        outcome, why, cause = "canceled", state.why, ""
    state.outcome, state.why, state.cause = outcome, why, cause
    state.draft.ended = state.draft.touched = True
    drop_reports(state, None)
    for name in list(state.running):
        leave_activity(program, state, program.graph.nodes[name])
    for node in () if killed else sorted(state.config.nodes, key=lambda node: -node.index):
        for act in node.exit:
            act(program, state)
    cancel_goals(state, state.goals)
    state.timers.clear()
    state.awaiting_control.clear()
    state.settling.clear()
    state.unmet.clear()
    state.draft.internal.clear()
    state.draft.starting, state.held_starts, state.frozen, state.asked = [], (), {}, ""
    state.mode = "ended"
