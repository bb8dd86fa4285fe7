# SPDX-License-Identifier: Apache-2.0
"""Transitions without an event that can follow one another for ever, within one instant.

Such a transition fires as soon as its guard holds. Three facts end a cycle: a guard that the states entered make false
(`in`, `elapsed_s`, `held`), a key that something on the way sets, and guards that name states of which one excludes
the other. Where none is there, the cycle is found.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable
from dataclasses import dataclass
from itertools import combinations
from typing import NamedTuple

from rai_missions.check.finding import Found
from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.reachability import domain_of, entered_with
from rai_missions.check.scc import knots
from rai_missions.guards import Guard
from rai_missions.guards.form import Atom, Form, Junction
from rai_missions.guards.implication import conjuncts, form, implies, never
from rai_missions.states import Final, Parallel
from rai_missions.states.effects import Effect, Set

__all__ = ("endless_cycles", "possible_cycles")

Truth = bool | None
CROWD = 100
"""Transitions that could come right after another and are looked at, at most."""
TRIES = 20
"""From so many transitions of a knot a way around is looked for."""


@dataclass(frozen=True, eq=False, slots=True)
class Jump:
    """A transition without an event, and what holds once it was taken."""

    transition: TransitionRef
    guard: Guard
    form: Form
    active: tuple[StateRef, ...]
    """What it enters, and what around that stays active; regions next to it do not count."""
    names: frozenset[str]
    """Of these."""
    ends: bool
    """The mission ends with it."""
    stays: StateRef | None
    """The innermost state around it that is not left; None for the mission."""
    leaves: frozenset[StateRef]
    writes: frozenset[str]
    """Keys set on the way."""
    reads: frozenset[str]
    needs: tuple[StateRef, ...]
    """States that its guard needs to be active."""


class Cycle(NamedTuple):
    """Jumps that follow one another, back to the first."""

    jumps: tuple[Jump, ...]
    certain: bool
    """While the guard of one is true, so are all."""


def endless_cycles(index: MissionIndex) -> Found:
    """Transitions without an event do not lead round in a circle while their guards stay true."""
    return _found(index, certain=True)


def possible_cycles(index: MissionIndex) -> Found:
    """Transitions without an event do not lead round in a circle where different guards happen to be true together."""
    return _found(index, certain=False)


def _found(index: MissionIndex, *, certain: bool) -> Found:
    for cycle in _cycles(index):
        if cycle.certain is certain:
            transitions = " → ".join(jump.transition.place for jump in (*cycle.jumps, cycle.jumps[0])[:12])
            what = (
                "this transition fires again at once, for ever"
                if len(cycle.jumps) == 1
                else f"these transitions follow one another for ever: {transitions}"
            )
            when = "" if certain else ", whenever their guards are true together"
            remedy = "wait for an event, set a key that the guard reads, or ask that the target is not active yet"
            yield cycle.jumps[0].transition.place, f"{what}{when}; {remedy}"


def _cycles(index: MissionIndex) -> list[Cycle]:
    """One cycle for each knot of transitions, in document order; worked out once."""
    found = index.remembered.get("cycles")
    if isinstance(found, list):
        return found
    cycles: list[Cycle] = []
    index.remembered["cycles"] = cycles
    jumps = [_jump(index, transition) for transition in index.transitions if transition.definition.eventless]
    left = frozenset[StateRef]().union(*(jump.leaves for jump in jumps))
    loops = {index for index, jump in enumerate(jumps) if not never(jump.form) and _endless((jump,), left)}
    cycles += [Cycle((jumps[index],), True) for index in sorted(loops)]
    follows = _followers([jump for index, jump in enumerate(jumps) if index not in loops and not never(jump.form)])
    for knot in knots(follows):
        cycle = _around(follows, knot, left) if len(knot) > 1 else None
        if cycle is not None:
            cycles.append(cycle)
    return cycles


def _jump(index: MissionIndex, transition: TransitionRef) -> Jump:
    guard = transition.definition.when
    assert guard is not None
    targets = transition.targets
    stays = domain_of(transition)
    active = tuple(sorted(entered_with(index, targets, stays), key=lambda spot: spot.index))
    written = _set_by(transition.definition.do)
    moved = [spot for spot in active if spot.inside(stays)] if targets else []
    left = [*transition.owner.upward()] if transition.owner is not None and targets else []
    written.update(*(_set_by(spot.state.entry) for spot in moved), *(_set_by(spot.state.exit) for spot in left))
    reads = frozenset(path.partition(".")[0] for each in guard.walk() for path in each.paths())
    ends = any(spot.parent is None and isinstance(spot.state, Final) for spot in active)
    names = frozenset(spot.name for spot in active)
    leaves = frozenset(spot for spot in left if spot.inside(stays))
    conditions = form(guard)
    named = [
        each.path for each in conjuncts(conditions) if isinstance(each, Atom) and each.kind == "in" and not each.op
    ]
    needs = tuple(index.found(named))
    return Jump(transition, guard, conditions, active, names, ends, stays, leaves, frozenset(written), reads, needs)


def _set_by(effects: Iterable[Effect]) -> set[str]:
    return {effect.set for effect in effects if isinstance(effect, Set)}


def _after(jump: Jump, guard: Guard, owner: StateRef | None) -> Truth:
    """The value of a guard by the configuration alone once a jump is made; None where facts decide."""
    if jump.ends:
        return False
    reenters = owner is not None and owner.inside(jump.stays) and bool(jump.transition.definition.to)
    return guard.after_jump(lambda name: _active(jump, name), restarted=reenters)


def _active(jump: Jump, name: str) -> Truth:
    if name in jump.names:
        return True
    return None if any(isinstance(spot.state, Parallel) for spot in jump.active) else False


def _followers(jumps: list[Jump]) -> dict[Jump, list[Jump]]:
    """Which jumps can be made right after which, by where they are and what is active."""
    owned: dict[StateRef | None, list[Jump]] = {}
    for jump in jumps:
        owned.setdefault(jump.transition.owner, []).append(jump)
    follows: dict[Jump, list[Jump]] = {}
    for jump in jumps:
        candidates = [other for owner in (*jump.active, None) for other in owned.get(owner, ())][:CROWD]
        follows[jump] = [
            other
            for other in candidates
            if other is not jump and _after(jump, other.guard, other.transition.owner) is not False
        ]
    return follows


def _endless(jumps: tuple[Jump, ...], left: frozenset[StateRef]) -> bool:
    """Whether nothing on the way round ends it; some states can be left without an event."""
    writes = frozenset[str]().union(*(jump.writes for jump in jumps))
    if any(jump.reads & writes for jump in jumps) or never(Junction("all", tuple(jump.form for jump in jumps))):
        return False
    needed = {spot.index: spot for jump in jumps for spot in jump.needs}.values()
    if any(_exclude(*pair) and not left.issuperset(pair) for pair in combinations(needed, 2)):
        return False
    pairs = zip(jumps, (*jumps[1:], jumps[0]), strict=True)
    return all(
        _reachable(one, other) and _after(one, other.guard, other.transition.owner) is not False for one, other in pairs
    )


def _exclude(one: StateRef, other: StateRef) -> bool:
    """Whether two states are never active together: neither is inside the other, nor are they in two regions."""
    if one.inside(other) or other.inside(one):
        return False
    around = next((spot for spot in one.upward() if other.inside(spot)), None)
    return around is None or not isinstance(around.state, Parallel)


def _reachable(one: Jump, other: Jump) -> bool:
    """Whether the owner of a transition is active once another was taken."""
    return other.transition.owner is None or other.transition.owner.name in one.names


def _around(follows: dict[Jump, list[Jump]], knot: list[Jump], left: frozenset[StateRef]) -> Cycle | None:
    """A way round that nothing ends: a certain one if there is one among those tried."""
    inside = set(knot)
    possible: Cycle | None = None
    for start in knot[:TRIES]:
        way = _shortest(follows, start, inside)
        if way and _endless(way, left):
            if any(all(implies(jump.form, other.form) for other in way) for jump in way[:TRIES]):
                return Cycle(way, True)
            possible = possible or Cycle(way, False)
    return possible


def _shortest(follows: dict[Jump, list[Jump]], start: Jump, inside: Collection[Jump]) -> tuple[Jump, ...]:
    """The shortest way from a jump back to itself within a knot."""
    before: dict[Jump, Jump | None] = {start: None}
    wave = [start]
    while wave:
        nearer, wave = wave, []
        for jump in nearer:
            for other in follows[jump]:
                if other is start:
                    return _traced(before, jump)
                if other in inside and other not in before:
                    before[other] = jump
                    wave.append(other)
    return ()


def _traced(before: dict[Jump, Jump | None], last: Jump) -> tuple[Jump, ...]:
    way: list[Jump] = []
    here: Jump | None = last
    while here is not None:
        way.append(here)
        here = before[here]
    return tuple(reversed(way))
