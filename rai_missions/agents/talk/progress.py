# SPDX-License-Identifier: Apache-2.0
"""How far a run is: counts that the active states, or the mission's success, compare with a goal; lists worked through.

Rule: only what the mission itself compares is a progress; nothing is estimated.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from rai_missions.conversation import KeyView, ProgressView
from rai_missions.guards import Compare
from rai_missions.guards.guard import Guard
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import is_number
from rai_missions.states.compound import Each
from rai_missions.states.state import State

__all__ = ("progress",)


def progress(
    mission: Mission, active: frozenset[str], keys: Mapping[str, KeyView], rounds: Mapping[str, tuple[int, int]]
) -> Iterator[ProgressView]:
    """How far the active states are, then how far the mission is from its only success; each key once.

    Args:
        mission: The mission.
        active: Its active states.
        keys: What is known now, and what is not.
        rounds: As `Chart.rounds`.
    """
    seen: set[str] = set()
    current = [(name, state) for _, name, state in mission.walk() if name in active]
    successes = [(name, state) for name, state in mission.states.items() if _is_success(state)]
    for name, state in (*current, *(successes if len(successes) == 1 else ())):
        for found in _of(state, mission, keys, rounds.get(name)):
            if found.of not in seen:
                seen.add(found.of)
                yield found


def _is_success(state: State) -> bool:
    return getattr(state, "final", None) == "succeeded"


def _of(
    state: State, mission: Mission, keys: Mapping[str, KeyView], round_: tuple[int, int] | None
) -> Iterator[ProgressView]:
    if isinstance(state, Each) and round_ is not None:
        over, total = round_
        about = mission.blackboard[state.each].about if state.each in mission.blackboard else ""
        yield ProgressView(state.each, over, total, about)
    for guard in (getattr(state, "achieved", None), getattr(state, "requires", None)):
        yield from _counted(guard, keys)


def _counted(guard: Guard | None, keys: Mapping[str, KeyView]) -> Iterator[ProgressView]:
    """`{"key": "alleys_driven", ">=": {"key": "alleys"}}`: so many of so many."""
    for each in getattr(guard, "all", ()) if guard is not None else ():
        yield from _counted(each, keys)
    if not isinstance(guard, Compare) or guard.op != ">=":
        return
    done, total = _number(keys, guard.key), _number(keys, guard.other) if guard.other else guard.operand
    key = keys.get(guard.key)
    if key is None or key.type != "integer" or not isinstance(total, int | float) or total <= 0:
        return
    yield ProgressView(guard.key, None if done is None else min(done, float(total)), float(total), key.about)


def _number(keys: Mapping[str, KeyView], path: str) -> float | None:
    """What a guard sees of a count: nothing, where it is stale."""
    key = keys.get(path)
    return float(key.value) if key is not None and key.is_fresh and is_number(key.value) else None
