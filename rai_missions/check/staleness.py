# SPDX-License-Identifier: Apache-2.0
"""Rows that protect, and what becomes of them when the key they rest on goes stale.

Unknown fires no row. So a row that is to react to a danger sleeps when the sensor does, unless some row asks for that.
"""

from __future__ import annotations

from collections.abc import Iterator

from rai_missions.check.index import GuardUse, MissionIndex, StateRef, TransitionRef
from rai_missions.guards import Guard
from rai_missions.states import Final

__all__ = ("blind_rows",)

Found = Iterator[tuple[str, str]]


def blind_rows(survey: MissionIndex) -> Found:
    """A row or invariant that protects has, next to it or further out, one that reacts when its key goes stale."""
    watched: dict[str, set[StateRef | None]] = {}
    for ruled in survey.guards:
        if ruled.scope.row is not None or ruled.role == "invariants":
            for key in ruled.guard.noticed():
                watched.setdefault(key, set()).add(ruled.scope.owner)
    for ruled in survey.guards:
        depth = _protects(survey, ruled)
        for key in dict.fromkeys(_aging(survey, ruled.guard)) if depth else ():
            owners = watched.get(key, set())
            if not (owners if depth == "within" else owners & {None, *_upward(ruled.scope.owner)}):
                yield (
                    ruled.place,
                    f"this protects only while '{key}' is received: when it goes stale this is unknown, and no one "
                    f'handles that; join {{"not": {{"fresh": "{key}"}}}} to it with "any", or write a row for it',
                )


def _upward(spot: StateRef | None) -> Iterator[StateRef]:
    return spot.upward() if spot is not None else iter(())


def _protects(survey: MissionIndex, ruled: GuardUse) -> str:
    """How a guard protects: `outside` (of what it ends), `within` an activity that it interrupts, or not at all."""
    row = ruled.scope.row
    if ruled.role == "invariants":
        return "within"
    if row is None or not row.transition.eventless:
        return ""
    if row.owner is None or row.owner.children or _gives_up(survey, row):
        return "outside"
    return "within" if row.owner.state.activity() else ""


def _gives_up(survey: MissionIndex, row: TransitionRef) -> bool:
    """Whether a row leads to an end that is no success, or hands control to someone else."""
    before = _control(row.owner)
    for target in survey.found(row.transition.to):
        if isinstance(target.state, Final) and target.state.final != "succeeded":
            return True
        after = _control(target)
        if after is not None and before is not None and after != before:
            return True
    return False


def _control(spot: StateRef | None) -> str | None:
    return next((here.state.control for here in _upward(spot) if here.state.control is not None), None)


def _aging(survey: MissionIndex, guard: Guard) -> Iterator[str]:
    """The robot keys that can go stale and that a comparison in the guard rests on."""
    for name in guard.fading():
        key = survey.mission.blackboard.get(name)
        if key is not None and key.source == "robot" and key.max_age_s is not None:
            yield name
