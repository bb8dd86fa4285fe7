# SPDX-License-Identifier: Apache-2.0
"""Transitions that protect, and what becomes of them when the key they rest on goes stale.

Unknown fires no transition. So one that is to react to a danger sleeps when the sensor does, unless another asks for
that.
"""

from __future__ import annotations

from collections.abc import Iterator

from rai_missions.check.finding import Found
from rai_missions.check.index import GuardUse, MissionIndex, StateRef, TransitionRef
from rai_missions.guards import Guard
from rai_missions.states import Final

__all__ = ("blind_transitions",)


def blind_transitions(index: MissionIndex) -> Found:
    """A transition or invariant that protects comes with one that reacts when its key becomes stale."""
    watched: dict[str, set[StateRef | None]] = {}
    for ruled in index.guards:
        if ruled.scope.transition is not None or ruled.role == "invariants":
            for key in ruled.guard.noticed():
                watched.setdefault(key, set()).add(ruled.scope.owner)
    for ruled in index.guards:
        depth = _protects(index, ruled)
        for key in dict.fromkeys(_aging(index, ruled.guard)) if depth else ():
            owners = watched.get(key, set())
            if not (owners if depth == "within" else owners & {None, *_upward(ruled.scope.owner)}):
                yield (
                    ruled.place,
                    f"this protects only while '{key}' is received: when it goes stale this is unknown, and no one "
                    f'handles that; join {{"not": {{"fresh": "{key}"}}}} to it with "any", '
                    "or write a transition for it",
                )


def _upward(spot: StateRef | None) -> Iterator[StateRef]:
    return spot.upward() if spot is not None else iter(())


def _protects(index: MissionIndex, ruled: GuardUse) -> str:
    """How a guard protects: `outside` (of what it ends), `within` an activity that it interrupts, or not at all."""
    transition = ruled.scope.transition
    if ruled.role == "invariants":
        return "within"
    if transition is None or not transition.definition.eventless:
        return ""
    if transition.owner is None or transition.owner.children or _gives_up(index, transition):
        return "outside"
    return "within" if transition.owner.state.activity() else ""


def _gives_up(index: MissionIndex, transition: TransitionRef) -> bool:
    """Whether a transition leads to an end that is no success, or hands control to someone else."""
    before = transition.owner.control if transition.owner is not None else None
    for target in transition.targets:
        if isinstance(target.state, Final) and target.state.final != "succeeded":
            return True
        if target.control is not None and before is not None and target.control != before:
            return True
    return False


def _aging(index: MissionIndex, guard: Guard) -> Iterator[str]:
    """The robot keys that can go stale and that a comparison in the guard rests on."""
    for name in guard.fading():
        key = index.mission.blackboard.get(name)
        if key is not None and key.must_recur:
            yield name
