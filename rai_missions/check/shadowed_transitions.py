# SPDX-License-Identifier: Apache-2.0
"""Transitions that never fire: an earlier one of the same state always comes first, or the guard cannot be true."""

from __future__ import annotations

import itertools
from bisect import bisect_left, bisect_right
from collections.abc import Container, Iterator, Sequence
from typing import NamedTuple

from rai_missions.check.finding import Found
from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.outcomes import together
from rai_missions.guards.form import ALWAYS, NEVER, Form, Junction
from rai_missions.guards.implication import form, implies, never, roots
from rai_missions.states.transition import ANY_EVENT

__all__ = ("impossible_guards", "overlapping_transitions", "unwatched_holds")

NEAR = 64
"""Earlier transitions of the same trigger that one is compared with; more of them make a table, not a mistake."""
WATCHED = ("invariants", "check", "eternal_guard")
"""The fields whose guards are asked for how long something has held; next to the guards of transitions."""


def overlapping_transitions(index: MissionIndex) -> Found:
    """No transition comes after one of the same state that fires whenever it would."""
    for _, group in itertools.groupby(index.transitions, key=lambda transition: transition.owner):
        transitions = [*group]
        if len(transitions) == 1 or _all_differ(transitions):
            continue
        earlier, leaving = Earlier(index.mission.events), TimedExits()
        for transition in transitions:
            when = transition.definition.when
            guard, after_s, words = form(when), transition.definition.after_s, _triggers(transition)
            guarded = GuardedTransition(transition, guard, roots(guard) if when is not None else None)
            if when is None or not never(guard):
                before = [earlier.first(word, guarded) for word in words]
                if before and all(found is not None for found in before):
                    yield transition.place, _overlap(transition, [found for found in before if found is not None])
                elif after_s is not None and (late := leaving.before(after_s)):
                    yield (
                        transition.place,
                        f"this transition never fires: {late.place} leaves the state before; swap their times",
                    )
            for word in words:
                position = earlier.add(word, guarded)
                if after_s is not None and position < NEAR:
                    leaving.add(guarded, after_s)


class GuardedTransition(NamedTuple):
    """A transition with its guard in normal form, and what that is about."""

    transition: TransitionRef
    guard: Form
    about: frozenset[str] | None

    def may_follow_from(self, other: GuardedTransition) -> bool:
        """Whether the guards have something in common; where they have not, neither follows from the other."""
        return self.about is None or other.about is None or not self.about.isdisjoint(other.about)


class Earlier:
    """The transitions of a state up to one of them, by what can fire them.

    Args:
        events: The declared events, which `*` means.
    """

    def __init__(self, events: Container[str]) -> None:
        self._events = events
        self._by_word: dict[tuple[str, str], list[GuardedTransition]] = {}

    def add(self, word: tuple[str, str], guarded: GuardedTransition) -> int:
        """Add one; returns how many have the same trigger before it."""
        same = self._by_word.setdefault(word, [])
        same.append(guarded)
        return len(same) - 1

    def first(self, word: tuple[str, str], guarded: GuardedTransition) -> TransitionRef | None:
        """The earlier transition that fires whenever this guard is true and this trigger comes."""
        declared = word[0] in self._events
        same, any_event = self._by_word.get(word, []), self._by_word.get((ANY_EVENT, ""), []) if declared else []
        for other in _near(same, any_event) if same or any_event else ():
            if other.may_follow_from(guarded) and (other.guard == ALWAYS or implies(guarded.guard, other.guard)):
                return other.transition
        return None


def _near(one: Sequence[GuardedTransition], other: Sequence[GuardedTransition]) -> Iterator[GuardedTransition]:
    """The first and the last of two lists, one after the other."""
    count = len(one) + len(other)
    for index in (*range(min(NEAR, count)), *range(max(NEAR, count - NEAR), count)):
        yield one[index] if index < len(one) else other[index - len(one)]


class TimedExits:
    """The transitions that leave a state at some time, whatever is known.

    Kept are the times at which a transition leaves that comes before all those that leave sooner: the sooner, the later
    in the order in which their times were first written.
    """

    def __init__(self) -> None:
        self._order: dict[float, int] = {}
        self._times: list[float] = []
        self._first: list[tuple[int, TransitionRef]] = []

    def add(self, guarded: GuardedTransition, after_s: float) -> None:
        """Add one that fires at a time, if it is sure to leave then."""
        order, definition = self._order.setdefault(after_s, len(self._order)), guarded.transition.definition
        if guarded.guard != ALWAYS or not definition.to or definition.internal:
            return
        at = bisect_right(self._times, after_s)
        if at and self._first[at - 1][0] <= order:
            return
        end = at
        while end < len(self._first) and self._first[end][0] > order:
            end += 1
        self._times[at:end], self._first[at:end] = [after_s], [(order, guarded.transition)]

    def before(self, after_s: float) -> TransitionRef | None:
        """The first of those that have left the state by then."""
        at = bisect_left(self._times, after_s)
        return self._first[at - 1][1] if at else None


def _triggers(transition: TransitionRef) -> list[tuple[str, str]]:
    """What can fire a transition: each word of `on` with the state that it is `of`, the time, or nothing."""
    definition = transition.definition
    if definition.after_s is not None:
        return [("after_s", str(definition.after_s))]
    return [(word, definition.of or "") for word in definition.on] or [("", "")]


def _all_differ(transitions: Sequence[TransitionRef]) -> bool:
    """Whether each has triggers of its own, events or outcomes, so that none can come first where another would."""
    words: list[str] = []
    for definition in (each.definition for each in transitions):
        if definition.after_s is not None or not definition.on:
            return False
        words += definition.on
    return len(set(words)) == len(words) and ANY_EVENT not in words


def _overlap(transition: TransitionRef, before: list[TransitionRef]) -> str:
    places = ", ".join(dict.fromkeys(found.place for found in before))
    when = "its guard holds" if transition.definition.when is not None else "its trigger comes"
    verb = "comes" if len({found.place for found in before}) == 1 else "come"
    return (
        f"this transition never fires: whenever {when}, {places} {verb} first; "
        "put the narrower transition first, or take one away"
    )


def impossible_guards(index: MissionIndex) -> Found:
    """A guard can be true: it does not ask for two things that exclude each other."""
    for guard, place, role, scope in index.guards:
        written = form(guard)
        if role == "invariants" or not never(_there(index, written, scope.owner)):
            continue
        remedy = "keep one of the conditions that exclude each other, or fill the empty list"
        if not never(written) and scope.owner is not None:
            remedy = f"a state that it asks for is never active together with '{scope.owner.name}'; ask for another"
        yield place, f"this can never be true: {guard.words():.200}; {remedy}"


def unwatched_holds(index: MissionIndex) -> Found:
    """`held` is in a transition, an invariant or a tree: it is watched there, and nowhere else."""
    for guard, place, role, scope in index.guards:
        held = next((part for part in guard.walk() if part.held_s > 0), None)
        if held is not None and scope.transition is None and role not in WATCHED:
            yield (
                place,
                f"'held' is watched in transitions, invariants and trees, and is never true here: {held.words():.200}; "
                "ask here for what is so now, and wait for how long in a transition",
            )


def _there(index: MissionIndex, this: Form, owner: StateRef | None) -> Form:
    """A guard where it is: `in` a state that is never active together with its owner is not true there."""
    if isinstance(this, Junction):
        return Junction(this.word, tuple(_there(index, part, owner) for part in this.parts))
    spot = index.by_name.get(this.path) if this.kind == "in" else None
    if spot is None or together(owner, spot):
        return this
    return ALWAYS if this.op else NEVER
