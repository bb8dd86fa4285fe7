# SPDX-License-Identifier: Apache-2.0
"""Rows that never fire: an earlier one of the same state always comes first, or the guard cannot be true."""

from __future__ import annotations

import itertools
from collections.abc import Iterator

from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.outcomes import together
from rai_missions.guards.implication import ALWAYS, NEVER, Form, Junction, form, implies, never
from rai_missions.states.state import ANY_EVENT

__all__ = ("impossible_guards", "overlapping_rows", "unwatched_holds")

Found = Iterator[tuple[str, str]]
NEAR = 64
"""So many earlier rows of the same trigger are compared with; more of them make a long table, not a mistake."""
WATCHED = ("invariants", "check", "eternal_guard")
"""The fields whose guards are asked for how long something has held; next to the guards of rows."""


def overlapping_rows(survey: MissionIndex) -> Found:
    """No row comes after one of the same state that fires whenever it would."""
    for _, rows in itertools.groupby(survey.rows, key=lambda row: row.owner):
        earlier: dict[tuple[str, str], list[tuple[TransitionRef, Form]]] = {}
        for row in rows:
            guard = form(row.transition.when)
            words = _triggers(row)
            if not never(guard):
                before = [_first(survey, earlier, word, guard) for word in words]
                if before and all(found is not None for found in before):
                    yield row.place, _overlap(row, [found for found in before if found is not None])
                elif row.transition.after_s is not None and (late := _late(earlier, row.transition.after_s)):
                    yield (
                        row.place,
                        f"this row never fires: {late.place} leaves the state before; swap their times",
                    )
            for word in words:
                earlier.setdefault(word, []).append((row, guard))


def _triggers(row: TransitionRef) -> list[tuple[str, str]]:
    """What can fire a row: each word of `on` with the state that it is `of`, the time, or nothing."""
    transition = row.transition
    if transition.after_s is not None:
        return [("after_s", str(transition.after_s))]
    return [(word, transition.of or "") for word in transition.on] or [("", "")]


def _first(
    survey: MissionIndex,
    earlier: dict[tuple[str, str], list[tuple[TransitionRef, Form]]],
    word: tuple[str, str],
    guard: Form,
) -> TransitionRef | None:
    """The earlier row that fires whenever this guard is true and this trigger comes."""
    declared = word[0] in survey.mission.events
    rows = earlier.get(word, []) + (earlier.get((ANY_EVENT, ""), []) if declared else [])
    for row, other in (*rows[:NEAR], *rows[NEAR:][-NEAR:]):
        if other == ALWAYS or implies(guard, other):
            return row
    return None


def _late(earlier: dict[tuple[str, str], list[tuple[TransitionRef, Form]]], after_s: float) -> TransitionRef | None:
    """A row that has left the state by then, whatever is known."""
    for (word, _), rows in earlier.items():
        for row, guard in rows[:NEAR] if word == "after_s" else ():
            sooner = row.transition.after_s is not None and row.transition.after_s < after_s
            if sooner and guard == ALWAYS and row.transition.to and not row.transition.internal:
                return row
    return None


def _overlap(row: TransitionRef, before: list[TransitionRef]) -> str:
    places = ", ".join(dict.fromkeys(found.place for found in before))
    when = "its guard holds" if row.transition.when is not None else "its trigger comes"
    verb = "comes" if len({found.place for found in before}) == 1 else "come"
    return f"this row never fires: whenever {when}, {places} {verb} first; put the narrower row first, or take one away"


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
    """`held` is in a row, an invariant or a tree: it is watched there, and nowhere else."""
    for guard, place, role, scope in survey.guards:
        held = next((part for part in guard.walk() if part.held_s > 0), None)
        if held is not None and scope.row is None and role not in WATCHED:
            yield (
                place,
                f"'held' is watched in rows, invariants and trees, and is never true here: {held.words():.200}; "
                "ask here for what is so now, and wait for how long in a row",
            )


def _there(survey: MissionIndex, this: Form, owner: StateRef | None) -> Form:
    """A guard where it is: `in` a state that is never active together with its owner is not true there."""
    if isinstance(this, Junction):
        return Junction(this.word, tuple(_there(survey, part, owner) for part in this.parts))
    spot = survey.by_name.get(this.path) if this.kind == "in" else None
    if spot is None or together(owner, spot):
        return this
    return ALWAYS if this.op else NEVER
