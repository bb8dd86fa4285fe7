# SPDX-License-Identifier: Apache-2.0
"""Transitions that never fire: an earlier one of the same state always comes first, or the guard cannot be true."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.outcomes import together
from rai_missions.guards.implication import ALWAYS, NEVER, Form, Junction, form, implies, never
from rai_missions.states.state import ANY_EVENT

__all__ = ("impossible_guards", "overlapping_transitions", "unwatched_holds")

Found = Iterator[tuple[str, str]]
NEAR = 64
"""So many earlier transitions of the same trigger are compared with; more of them make a long table, not a mistake."""
WATCHED = ("invariants", "check", "eternal_guard")
"""The fields whose guards are asked for how long something has held; next to the guards of transitions."""


def overlapping_transitions(survey: MissionIndex) -> Found:
    """No transition comes after one of the same state that fires whenever it would."""
    for _, transitions in itertools.groupby(survey.transitions, key=lambda transition: transition.owner):
        earlier: dict[tuple[str, str], list[tuple[TransitionRef, Form]]] = {}
        for transition in transitions:
            guard = form(transition.definition.when)
            words = _triggers(transition)
            if not never(guard):
                before = [_first(survey, earlier, word, guard) for word in words]
                if before and all(found is not None for found in before):
                    yield transition.place, _overlap(transition, [found for found in before if found is not None])
                elif transition.definition.after_s is not None and (
                    late := _late(earlier, transition.definition.after_s)
                ):
                    yield (
                        transition.place,
                        f"this transition never fires: {late.place} leaves the state before; swap their times",
                    )
            for word in words:
                earlier.setdefault(word, []).append((transition, guard))


def _triggers(transition: TransitionRef) -> list[tuple[str, str]]:
    """What can fire a transition: each word of `on` with the state that it is `of`, the time, or nothing."""
    definition = transition.definition
    if definition.after_s is not None:
        return [("after_s", str(definition.after_s))]
    return [(word, definition.of or "") for word in definition.on] or [("", "")]


def _first(
    survey: MissionIndex,
    earlier: dict[tuple[str, str], list[tuple[TransitionRef, Form]]],
    word: tuple[str, str],
    guard: Form,
) -> TransitionRef | None:
    """The earlier transition that fires whenever this guard is true and this trigger comes."""
    declared = word[0] in survey.mission.events
    transitions = earlier.get(word, []) + (earlier.get((ANY_EVENT, ""), []) if declared else [])
    for transition, other in (*transitions[:NEAR], *transitions[NEAR:][-NEAR:]):
        if other == ALWAYS or implies(guard, other):
            return transition
    return None


def _late(earlier: dict[tuple[str, str], list[tuple[TransitionRef, Form]]], after_s: float) -> TransitionRef | None:
    """A transition that has left the state by then, whatever is known."""
    for (word, _), transitions in earlier.items():
        for transition, guard in transitions[:NEAR] if word == "after_s" else ():
            sooner = transition.definition.after_s is not None and transition.definition.after_s < after_s
            if sooner and guard == ALWAYS and transition.definition.to and not transition.definition.internal:
                return transition
    return None


def _overlap(transition: TransitionRef, before: list[TransitionRef]) -> str:
    places = ", ".join(dict.fromkeys(found.place for found in before))
    when = "its guard holds" if transition.definition.when is not None else "its trigger comes"
    verb = "comes" if len({found.place for found in before}) == 1 else "come"
    return (
        f"this transition never fires: whenever {when}, {places} {verb} first; "
        "put the narrower transition first, or take one away"
    )


def impossible_guards(survey: MissionIndex) -> Found:
    """A guard can be true: it does not ask for two things that exclude each other."""
    for guard, place, role, scope in survey.guards:
        written = form(guard)
        if role == "invariants" or not never(_there(survey, written, scope.owner)):
            continue
        remedy = "keep one of the conditions that exclude each other, or fill the empty list"
        if not never(written) and scope.owner is not None:
            remedy = f"a state that it asks for is never active together with '{scope.owner.name}'; ask for another"
        yield place, f"this can never be true: {guard.words():.200}; {remedy}"


def unwatched_holds(survey: MissionIndex) -> Found:
    """`held` is in a transition, an invariant or a tree: it is watched there, and nowhere else."""
    for guard, place, role, scope in survey.guards:
        held = next((part for part in guard.walk() if part.held_s > 0), None)
        if held is not None and scope.transition is None and role not in WATCHED:
            yield (
                place,
                f"'held' is watched in transitions, invariants and trees, and is never true here: {held.words():.200}; "
                "ask here for what is so now, and wait for how long in a transition",
            )


def _there(survey: MissionIndex, this: Form, owner: StateRef | None) -> Form:
    """A guard where it is: `in` a state that is never active together with its owner is not true there."""
    if isinstance(this, Junction):
        return Junction(this.word, tuple(_there(survey, part, owner) for part in this.parts))
    spot = survey.by_name.get(this.path) if this.kind == "in" else None
    if spot is None or together(owner, spot):
        return this
    return ALWAYS if this.op else NEVER
