# SPDX-License-Identifier: Apache-2.0
"""What some rules of `check` find, by their plain definitions: every state with every other, however long it takes."""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from typing import Any

from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.outcomes import FAILURES, handled, together
from rai_missions.check.reachability import Reach, _waiting
from rai_missions.check.reported_outcomes import reported
from rai_missions.guards.form import ALWAYS
from rai_missions.guards.implication import form, implies, never
from rai_missions.states import Final, History, Parallel
from rai_missions.states.transition import ANY_EVENT

__all__ = ("DEFINITIONS",)

Places = list[tuple[str, tuple[str, ...]]]
"""Places that are found, each with the places or names that its sentence names."""


def overlapping(index: MissionIndex, near: int) -> Places:
    found: Places = []
    for _, transitions in itertools.groupby(index.transitions, key=lambda each: each.owner):
        earlier: dict[tuple[str, str], list[tuple[TransitionRef, Any]]] = {}
        for each in transitions:
            guard, words = form(each.definition.when), _triggers(each)
            if not never(guard):
                before = [_first(index, earlier, word, guard, near) for word in words]
                late = _late(earlier, each.definition.after_s, near)
                if before and all(before):
                    found.append((each.place, tuple(dict.fromkeys(one.place for one in before if one))))
                elif late is not None:
                    found.append((each.place, (late.place,)))
            for word in words:
                earlier.setdefault(word, []).append((each, guard))
    return found


def _triggers(each: TransitionRef) -> list[tuple[str, str]]:
    if each.definition.after_s is not None:
        return [("after_s", str(each.definition.after_s))]
    return [(word, each.definition.of or "") for word in each.definition.on] or [("", "")]


def _first(index: MissionIndex, earlier: Any, word: tuple[str, str], guard: Any, near: int) -> TransitionRef | None:
    declared = word[0] in index.mission.events
    listed = earlier.get(word, []) + (earlier.get((ANY_EVENT, ""), []) if declared else [])
    for each, other in (*listed[:near], *listed[near:][-near:]):
        if other == ALWAYS or implies(guard, other):
            return each  # type: ignore[no-any-return]
    return None


def _late(earlier: Any, after_s: float | None, near: int) -> TransitionRef | None:
    for (word, _), listed in earlier.items():
        for each, guard in listed[:near] if word == "after_s" and after_s is not None else ():
            definition = each.definition
            sooner = definition.after_s is not None and definition.after_s < after_s
            if sooner and guard == ALWAYS and definition.to and not definition.internal:
                return each  # type: ignore[no-any-return]
    return None


def dead_ends(index: MissionIndex, near: int) -> Places:
    return [
        (spot.place, (spot.name,))
        for spot in _waiting(index)
        if not any(_frees(index, each, spot) for each in (*_here(spot), *_own(index)))
    ]


def waiting_rooms(index: MissionIndex, near: int) -> Places:
    success = {spot for spot in index.top if isinstance(spot.state, Final) and spot.state.final == "succeeded"}
    found: Places = []
    for spot in _waiting(index) if success else ():
        own = [each for each in _own(index) if _frees(index, each, spot)]
        if own and not any(_frees(index, each, spot) for each in _here(spot)):
            reaches = [Reach(index) for _ in own]
            for reach, each in zip(reaches, own, strict=True):
                reach.enter(index.found(each.definition.to))
            if not any(reach.active & success for reach in reaches):
                found.append((spot.place, (*(each.place for each in own[:4]), spot.name)))
    return found


def _here(spot: StateRef) -> list[TransitionRef]:
    return [each for here in spot.upward() for each in here.transitions]


def _own(index: MissionIndex) -> list[TransitionRef]:
    return [each for each in index.transitions if each.owner is None]


def _frees(index: MissionIndex, each: TransitionRef, spot: StateRef) -> bool:
    definition = each.definition
    if not definition.to or all(index.spot(name) is spot for name in definition.to):
        return False
    events = [word for word in definition.on if word == ANY_EVENT or index.events.meant(word)]
    return not definition.on or bool(events) or any(word in _coming(index, each, spot) for word in definition.on)


def _coming(index: MissionIndex, each: TransitionRef, spot: StateRef) -> frozenset[str]:
    if each.definition.of is not None:
        source = index.spot(each.definition.of)
        return reported(index).by(source) if source is not None else frozenset()
    between = [here for here in spot.upward() if each.owner is None or here is each.owner or here.inside(each.owner)]
    isolated = not any(isinstance(here.state, Parallel) for here in between)
    return frozenset() if isolated else reported(index).possible_at(each.owner)


def rival_actions(index: MissionIndex, near: int) -> Places:
    used = [(use, use.scope.owner) for use in index.uses if use.sort == "action"]
    places = {spot: use.named_at for use, spot in used if spot is not None and use.user is spot.state}
    found: Places = []
    for number, spot in enumerate(places):
        rivals = [each for each in places if each is not spot and together(spot, each)]
        if rivals and list(places).index(rivals[0]) > number and not any(map(_handles, (spot, *rivals))):
            found.append((places[spot], (spot.name, rivals[0].name)))
    return found


def _handles(spot: StateRef) -> bool:
    return any("rejected" in each.definition.on for each in _here(spot))


def lost_timers(index: MissionIndex, near: int) -> Places:
    def continues(one: TransitionRef) -> bool:
        others = [each for each in index.transitions if each.owner is one.owner and each is not one]
        bounded = one.owner is not None and one.owner.state.timeout_s is not None
        return bounded or any(
            (each.definition.after_s or 0.0) >= (one.definition.after_s or 0.0)
            for each in others
            if each.definition.after_s is not None
        )

    timed = [each for each in index.transitions if each.definition.after_s is not None]
    return [(f"{each.place}/when", ()) for each in timed if each.definition.when is not None and not continues(each)]


def unhandled_failures(index: MissionIndex, near: int) -> Places:
    return [(spot.place, words) for spot in index.spots if (words := tuple(_uncaught(index, spot)))]


def _uncaught(index: MissionIndex, spot: StateRef) -> Iterator[str]:
    for word in FAILURES:
        caught = any(
            word in each.definition.on and (each.definition.of or here.name) == here.name
            for here in spot.upward()
            for each in here.transitions
        )
        known = {(spot.name, word), ("", word)} & handled(index)
        if not isinstance(spot.state, Final | History) and word in spot.state.outcomes() and not caught and not known:
            yield word


DEFINITIONS = {
    "overlapping-transition": overlapping, "dead-end": dead_ends, "waiting-room": waiting_rooms,
    "rival-action": rival_actions, "lost-timer": lost_timers, "unhandled-failure": unhandled_failures,
}  # fmt: skip
"""By the name of the rule."""
