# SPDX-License-Identifier: Apache-2.0
"""Outcomes and options that nothing handles, and transitions that wait for an outcome that never comes."""

from __future__ import annotations

import json
from collections.abc import Sequence
from functools import cache

from rai_missions.check.finding import Found
from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.pointers import pointer
from rai_missions.check.reported_outcomes import ENDS, OutcomeReports, reported
from rai_missions.states import Compound, Final, History, Parallel
from rai_missions.states.state import OUTCOMES
from rai_missions.states.transition import ANY_EVENT

__all__ = (
    "deaf_transitions", "handled", "together", "unhandled_failures", "unhandled_options", "unhandled_success",
    "unused_wildcards",
)  # fmt: skip

FAILURES = ("failed", "timed_out", "rejected", "unverified", "unclear", "refused")
"""The outcomes that a state may have which end the mission where nothing handles them."""


def handled(index: MissionIndex) -> set[tuple[str, str]]:
    """Each (state, word) that a transition of the state, or one that names it by `of`, waits for."""
    found = index.remembered.get("handled")
    if not isinstance(found, set):
        found = {
            (source, word)
            for transition in index.transitions
            for source in (transition.definition.of or (transition.owner.name if transition.owner else ""),)
            for word in transition.definition.on
        }
        index.remembered["handled"] = found
    return found


def unhandled_options(index: MissionIndex) -> Found:
    """Every option of a decision has a transition of its own decision."""
    for spot in index.spots:
        asked = spot.state.question() if spot.options else None
        for name in spot.options:
            if (spot.name, name) not in handled(index) and name not in OUTCOMES:
                what = f"the fallback '{name}'" if asked and name == asked.fallback else f"option '{name}'"
                place = pointer(spot.place, "decision", "options", name)
                yield place, f'nothing handles {what}; add a transition {{"on": "{name}", "to": …}} to \'{spot.name}\''


def unhandled_success(index: MissionIndex) -> Found:
    """The `succeeded` of an activity, and of a compound state with a final, is handled by a transition of its own."""
    ends = reported(index)
    for spot in index.spots:
        if "succeeded" not in ends.by(spot) or _is_region(spot):
            continue
        if (spot.name, "succeeded") not in handled(index):
            yield (
                spot.place,
                f"nothing handles 'succeeded' of '{spot.name}', and it would stay there; "
                'add a transition {"on": "succeeded", "to": …} to it, or one without \'to\' if it is to stay',
            )


def unhandled_failures(index: MissionIndex) -> Found:
    """A failure of a state (`FAILURES`) is handled, by its state or around it.

    The outcome of a nested final is left out, since its author wrote it. So is a handover of control that is not
    acknowledged, which is `rejected` as well: another holder has the robot then, and the mission's end is expected.
    """
    caught_by = cache(_caught_by)
    for spot in index.spots:
        own = spot.state.outcomes()
        if not own or isinstance(spot.state, Final | History):
            continue
        around = frozenset[str]().union(*map(caught_by, spot.upward()))
        words = [word for word in FAILURES if word in own and word not in around]
        if words := [word for word in words if handled(index).isdisjoint([("", word), (spot.name, word)])]:
            remedy = f'{{"on": {json.dumps(words[0] if len(words) == 1 else words)}, "to": …}}'
            yield (
                spot.place,
                f"{_joined(words)} of '{spot.name}' would end the mission as failed, for nothing handles "
                f"{'it' if len(words) == 1 else 'them'}; add a transition {remedy} to it, or to a state around it",
            )


def _caught_by(spot: StateRef) -> frozenset[str]:
    """What the transitions of a state wait for of its own outcomes, and of those inside it."""
    mine = (each.definition for each in spot.transitions if each.definition.of in (None, spot.name))
    return frozenset([word for definition in mine for word in definition.on])


def _is_region(spot: StateRef) -> bool:
    """What its end means is its parallel's affair."""
    return spot.parent is not None and isinstance(spot.parent.state, Parallel) and bool(spot.children)


def deaf_transitions(index: MissionIndex) -> Found:
    """An outcome that a transition waits for can be reported while the transition's state is active."""
    ends, outcomes = reported(index), frozenset(OUTCOMES) - index.mission.events.keys()
    for transition in index.transitions:
        source = index.by_name.get(transition.definition.of) if transition.definition.of is not None else None
        if transition.definition.of is not None and source is None:
            continue  # it is unknown, and that is reported
        words = [word for word in transition.definition.on if word in outcomes]
        if source is not None and not together(transition.owner, source):
            assert transition.owner is not None
            yield (
                f"{transition.place}/of",
                f"'{source.name}' is never active together with '{transition.owner.name}', "
                "so this transition never fires; move it",
            )
            continue
        if not words:
            continue
        possible = ends.by(source) if source is not None else ends.possible_at(transition.owner)
        whose = source or transition.owner
        if whose is not None and whose.state.reports_robot:
            words = [
                word for word in words if word != "timed_out"
            ]  # without a timeout: reported, and the transition is right
        if vain := [word for word in words if word not in possible]:
            yield f"{transition.place}/on", _vain(transition, source, vain, ends)


def _vain(transition: TransitionRef, source: StateRef | None, vain: Sequence[str], ends: OutcomeReports) -> str:
    whose = source or transition.owner
    possible = ends.by(source) if source is not None else ends.possible_at(transition.owner)
    who = f"'{whose.name}'" if whose is not None else "no state of the mission"
    verb = "never reports" if whose is not None else "reports"
    can = ", ".join(word for word in OUTCOMES if word in possible)
    hint = f"it can report: {can}" if can else "it reports nothing"
    if "succeeded" in vain and (endless := _endless(whose, ends)):
        which = f"{_joined(endless)} {'has' if len(endless) == 1 else 'have'} no final, so it never ends"
        hint = f'{which}; add one there, such as {{"done": {{"final": "succeeded"}}}}'
    if "unverified" in vain and whose is not None and "achieved" in type(whose.state).model_fields:
        hint += "; 'unverified' needs an 'achieved'"
    if "timed_out" in vain and whose is not None:
        hint += "; 'timed_out' needs a 'timeout_s'"
    return f"{who} {verb} {' or '.join(repr(word) for word in vain)}; {hint}"


def _endless(spot: StateRef | None, ends: OutcomeReports) -> list[str]:
    """What has no final and so keeps a state from its end: regions of a parallel, or a compound state itself."""
    if spot is None or ends.by(spot) & ENDS or not isinstance(spot.state, Parallel | Compound):
        return []
    parts = spot.children if isinstance(spot.state, Parallel) else [spot]
    return [each.name for each in parts if not isinstance(each.state, Final | History) and not ends.by(each) & ENDS]


def _joined(names: Sequence[str]) -> str:
    """`'a', 'b' and 'c'`."""
    *most, last = (f"'{name}'" for name in names)
    return f"{', '.join(most)} and {last}" if most else last


def together(one: StateRef | None, other: StateRef) -> bool:
    """Whether two states can be active at the same time."""
    if one is None or one is other or one.inside(other) or other.inside(one):
        return True
    meeting = next((here for here in one.upward() if other.inside(here)), None)
    return meeting is not None and isinstance(meeting.state, Parallel)


def unused_wildcards(index: MissionIndex) -> Found:
    """`*` is any declared event, so at least one is declared."""
    if not index.mission.events:
        for transition in index.transitions:
            if ANY_EVENT in transition.definition.on:
                yield (
                    f"{transition.place}/on",
                    "'*' is any declared event, and the mission declares none; declare it under /events",
                )
