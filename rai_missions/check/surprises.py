# SPDX-License-Identifier: Apache-2.0
"""What is allowed and does something else than an author may expect."""

from __future__ import annotations

from collections.abc import Iterator

from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.outcomes import together

__all__ = ("lost_timers", "rival_actions")

Found = Iterator[tuple[str, str]]


def lost_timers(survey: MissionIndex) -> Found:
    """A transition with `after_s` and `when` fires at one instant or never; give another one for the other case."""
    for transition in survey.transitions:
        after_s, guard = transition.definition.after_s, transition.definition.when
        if after_s is not None and guard is not None and not _continues(survey, transition):
            wait = f'"when": {{"all": [{{"elapsed_s": {after_s:g}}}, …]}}'
            yield (
                f"{transition.place}/when",
                f"where this is not true after {after_s:g} s, the transition is lost until the state is entered again; "
                f"write {wait} to wait for it, or add one without 'when'",
            )


def _continues(survey: MissionIndex, transition: TransitionRef) -> bool:
    """Whether a later instant decides what happens where the guard was not true."""
    transitions = (
        transition.owner.transitions
        if transition.owner is not None
        else [each for each in survey.transitions if each.owner is None]
    )
    assert transition.definition.after_s is not None
    after_s = transition.definition.after_s
    bounded = transition.owner is not None and transition.owner.state.timeout_s is not None
    return bounded or any(
        each is not transition and each.definition.after_s is not None and each.definition.after_s >= after_s
        for each in transitions
    )


def rival_actions(survey: MissionIndex) -> Found:
    """Of two actions in regions of one parallel, one handles `rejected`: they may need the same of the robot."""
    used = ((use, use.scope.owner) for use in survey.uses if use.sort == "action")
    places = {spot: use.named_at for use, spot in used if spot is not None and use.user is spot.state}
    spots = list(places)
    for index, spot in enumerate(spots):
        rivals = [each for each in spots if each is not spot and together(spot, each)]
        if rivals and not any(_handles(each) for each in (spot, *rivals)) and spots.index(rivals[0]) > index:
            yield (
                places[spot],
                f"'{spot.name}' and '{rivals[0].name}' may run at one time, and unless the profile's 'uses' keep them "
                "apart, the second waits for the end of the first and is 'rejected' where that is never confirmed; "
                "handle 'rejected' in one of them",
            )


def _handles(spot: StateRef) -> bool:
    return any("rejected" in transition.definition.on for here in spot.upward() for transition in here.transitions)
