# SPDX-License-Identifier: Apache-2.0
"""What is allowed and does something else than an author may expect."""

from __future__ import annotations

import itertools
from bisect import bisect_left, bisect_right
from collections.abc import Iterable

from rai_missions.check.finding import Found
from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.reachability import entered_with
from rai_missions.check.scc import knots
from rai_missions.guards import Elapsed, Guard
from rai_missions.states import Parallel

__all__ = ("hasty_retries", "lost_timers", "rival_actions")


def lost_timers(index: MissionIndex) -> Found:
    """A transition with `after_s` and `when` fires at one instant or never; give another one for the other case."""
    timed = [each for each in index.transitions if each.definition.after_s is not None]
    latest = _latest(timed)
    for transition in timed:
        after_s, guard = transition.definition.after_s, transition.definition.when
        if after_s is not None and guard is not None and not _continues(transition, latest):
            wait = f'"when": {{"all": [{{"elapsed_s": {after_s:g}}}, …]}}'
            yield (
                f"{transition.place}/when",
                f"where this is not true after {after_s:g} s, the transition is lost until the state is entered again; "
                f"write {wait} to wait for it, or add one without 'when'",
            )


def _latest(timed: Iterable[TransitionRef]) -> dict[StateRef | None, list[float]]:
    """The two latest instants at which transitions of a state, or of the mission, fire."""
    found: dict[StateRef | None, list[float]] = {}
    for transition in timed:
        assert transition.definition.after_s is not None
        instants = [*found.get(transition.owner, ()), transition.definition.after_s]
        found[transition.owner] = sorted(instants, reverse=True)[:2]
    return found


def _continues(transition: TransitionRef, latest: dict[StateRef | None, list[float]]) -> bool:
    """Whether a later instant decides what happens where the guard was not true: one of another transition."""
    after_s, owner = transition.definition.after_s, transition.owner
    assert after_s is not None
    bounded = owner is not None and owner.state.timeout_s is not None
    return bounded or sum(instant >= after_s for instant in latest[owner]) > 1


def hasty_retries(index: MissionIndex) -> Found:
    """What is `rejected` is begun again at once, perhaps by an answer of rules, as long as its server is away."""
    taken = {spot: found for spot in index.spots if (found := _taken_at_once(index, spot))}
    ways = {each.place: each for found in taken.values() for each in found}
    leads: dict[StateRef | str, list[StateRef | str]] = {spot: [each.place for each in taken[spot]] for spot in taken}
    leads.update({place: [*(entered_with(index, way.targets, None) & taken.keys())] for place, way in ways.items()})
    for knot in knots(leads):
        spots = [each for each in knot if isinstance(each, StateRef)]
        ruled = [spot.name for spot in spots if not spot.state.reports_robot]
        by = f" by an answer of rules to '{ruled[0]}'" if ruled else ""
        places = set(knot)
        for spot in (each for each in spots if each.state.reports_robot):
            (retry,) = taken[spot]
            if retry.place in places:
                places.discard(retry.place)
                yield (
                    f"{retry.place}/to",
                    f"while no server is there, '{spot.name}' is rejected and entered again without a pause{by}; "
                    f'lead to a state that waits, {{"after_s": 5, "to": "{retry.definition.to[0]}"}}',
                )


def _taken_at_once(index: MissionIndex, spot: StateRef) -> list[TransitionRef]:
    """The transitions that are taken as soon as it is entered, where no server is there and rules answer."""
    found: list[TransitionRef] = []
    for outcome in _at_once(index, spot):
        around = (each for here in spot.upward() for each in here.transitions if outcome in each.definition.on)
        taken = next((each for each in around if each.definition.of in (None, spot.name)), None)
        if taken is not None and taken.definition.when is None and taken.targets:
            found.append(taken)
    return found


def _at_once(index: MissionIndex, spot: StateRef) -> Iterable[str]:
    """The outcomes of a state that take no time, and that no counter and no waiting of the mission ends."""
    if spot.state.reports_robot:
        return ("rejected",)
    asked = spot.state.question()
    if asked is None or "rules" not in asked.ask:
        return ()
    return (name for name, option in asked.options.items() if option.when is None or _is_of_robot(index, option.when))


def _is_of_robot(index: MissionIndex, guard: Guard) -> bool:
    """Whether it reads what the robot reports, and nothing else."""
    keys = [index.mission.blackboard.get(path.partition(".")[0]) for each in guard.walk() for path in each.paths()]
    return all(key is not None and key.source == "robot" for key in keys) and not any(
        isinstance(each, Elapsed) for each in guard.walk()
    )


def rival_actions(index: MissionIndex) -> Found:
    """Two actions in regions of one parallel may need the same of the robot, and only one handles `rejected`."""
    used = ((use, use.scope.owner) for use in index.uses if use.sort == "action")
    places = {spot: use.named_at for use, spot in used if spot is not None and use.user is spot.state}
    if not places:
        return
    acting = ActionStates(index, sorted(places, key=lambda spot: spot.index))
    for spot in acting.spots:
        rivals = acting.rivals(spot)
        first = next((acting.spots[start] for start, end in rivals if start < end), None)
        if first is None or first.index < spot.index or acting.handles(spot) or acting.is_handled(rivals):
            continue
        yield (
            places[spot],
            f"'{spot.name}' and '{first.name}' may run at one time, and unless the profile's 'uses' keep them "
            "apart, the second waits for the end of the first and is 'rejected' where that is never confirmed; "
            "handle 'rejected' in one of them",
        )


class ActionStates:
    """The states with an action, in document order, and which of them may run next to one.

    Args:
        index: The mission.
        spots: Those states; what is inside a state is a span of them.
    """

    def __init__(self, index: MissionIndex, spots: list[StateRef]) -> None:
        self.spots = spots
        self._indices = [spot.index for spot in spots]
        self._handled: list[bool] = []
        for spot in index.spots:
            around = spot.parent is not None and self._handled[spot.parent.index]
            self._handled.append(around or any("rejected" in each.definition.on for each in spot.transitions))
        self._count = [0, *itertools.accumulate(self._handled[index] for index in self._indices)]

    def handles(self, spot: StateRef) -> bool:
        """Whether it, or a state around it, handles `rejected`."""
        return self._handled[spot.index]

    def is_handled(self, spans: list[tuple[int, int]]) -> bool:
        """Whether one of the states in some spans handles it."""
        return any(self._count[end] > self._count[start] for start, end in spans)

    def rivals(self, spot: StateRef) -> list[tuple[int, int]]:
        """The spans of those that may be active together with a state, in document order.

        They are inside it, around it, and in the other regions of every parallel around it.
        """
        start, end = self._span(spot)
        found = [(start + 1, end)]
        for inner, outer in itertools.pairwise(spot.upward()):
            (start, end), (first, last) = self._span(inner), self._span(outer)
            if isinstance(outer.state, Parallel):
                found += [(first, start), (end, last)]
            elif self.spots[first : first + 1] == [outer]:
                found.append((first, first + 1))
        return sorted(found)

    def _span(self, spot: StateRef) -> tuple[int, int]:
        """Which of the states with an action are it and inside it."""
        return bisect_left(self._indices, spot.index), bisect_right(self._indices, spot.last)
