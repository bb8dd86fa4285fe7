# SPDX-License-Identifier: Apache-2.0
"""Which transitions can leave a state that runs nothing.

Rule: what holds for all states inside one owner is worked out once an owner, so that thousands of states take no longer
each than a few do.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Iterator

from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.reported_outcomes import reported
from rai_missions.states import Parallel
from rai_missions.states.transition import ANY_EVENT

__all__ = ("WaysOut",)


Lead = tuple[TransitionRef, StateRef | None]


class FreeTransitions:
    """The transitions of one owner that can fire while nothing runs, and lead somewhere.

    Args:
        index: The mission.
        owner: Whose they are; None: the mission's own.
        transitions: All of its transitions.
        in_parallel: Whether a parallel is between the states that are asked about and the owner, so that outcomes of
            its regions come.
    """

    def __init__(
        self, index: MissionIndex, owner: StateRef | None, transitions: Iterable[TransitionRef], *, in_parallel: bool
    ) -> None:
        self._index, self._rest = index, iter(transitions)
        self._outcomes = reported(index).possible_at(owner) if in_parallel else frozenset[str]()
        self._found: list[Lead] = []
        self._different: list[StateRef | None] = []
        """Up to two of the states that transitions lead to: at most one of them leads back to where it is."""

    @property
    def found(self) -> list[Lead]:
        """All of them, each with the one state that all its targets are; None where there are several."""
        for _ in self._look_on():
            pass
        return self._found

    def _look_on(self) -> Iterator[Lead]:
        """The ways out that were not looked at so far, found one by one as the caller needs them."""
        for transition in self._rest:
            if transition.definition.to and _can_fire(self._index, transition, self._outcomes):
                targets = {self._index.spot(name) for name in transition.definition.to}
                lead = (transition, targets.pop() if len(targets) == 1 else None)
                self._found.append(lead)
                if len(self._different) < 2 and lead[1] not in self._different:
                    self._different.append(lead[1])
                yield lead

    def free(self, spot: StateRef) -> bool:
        """Whether one of them leads away from a state."""
        return any(only is not spot for only in self._different) or any(only is not spot for _, only in self._look_on())

    def of(self, spot: StateRef) -> Iterator[TransitionRef]:
        """The transitions that lead away from a state, in order."""
        return (transition for transition, only in self.found if only is not spot)


class WaysOut:
    """Which transitions can leave the states that run nothing: those of the state, around it, and the mission's own.

    Args:
        index: The mission.
    """

    def __init__(self, index: MissionIndex) -> None:
        self._index = index
        self._known: dict[tuple[StateRef | None, bool], FreeTransitions] = {}
        self._hopeful: dict[bool, list[tuple[TransitionRef, StateRef | None]]] = {}

    def here(self, spot: StateRef) -> bool:
        """Whether a transition of the state or of one around it leaves it."""
        if not spot.children and any(self._leaves(spot, transition) for transition in spot.transitions):
            return True
        in_parallel = False
        for owner in spot.upward():
            in_parallel = in_parallel or isinstance(owner.state, Parallel)
            if owner.transitions and self._freeing(owner, in_parallel).free(spot):
                return True
        return False

    def _leaves(self, spot: StateRef, transition: TransitionRef) -> bool:
        """Whether a transition of a state that has none inside can fire there, and leads to one other."""
        is_led_away = len(transition.definition.to) == 1 and transition.targets != [spot]
        return is_led_away and _can_fire(self._index, transition, frozenset())

    def of_mission(self, spot: StateRef) -> bool:
        """Whether one of the mission's own transitions leaves it."""
        return self._freeing(None, _in_parallel(spot)).free(spot)

    def first_of_mission(self, spot: StateRef, most: int) -> list[TransitionRef]:
        """The first transitions of the mission itself that lead out of a state, so many at most."""
        return list(itertools.islice(self._freeing(None, _in_parallel(spot)).of(spot), most))

    def leads(self, spot: StateRef, leads_on: Callable[[TransitionRef], bool]) -> bool:
        """Whether one of the mission's own transitions that leave a state leads on.

        Two with different targets suffice for every state: at most one of them leads back to it.
        """
        in_parallel = _in_parallel(spot)
        if in_parallel not in self._hopeful:
            found: list[Lead] = []
            for transition, only in self._freeing(None, in_parallel).found:
                if (not found or found[0][1] is not only) and leads_on(transition):
                    found.append((transition, only))
                if len(found) == 2 or (found and found[0][1] is None):
                    break
            self._hopeful[in_parallel] = found
        return any(only is not spot for _, only in self._hopeful[in_parallel])

    def _freeing(self, owner: StateRef | None, in_parallel: bool) -> FreeTransitions:
        key = (owner, in_parallel)
        if key not in self._known:
            transitions = owner.transitions if owner is not None else _own_transitions(self._index)
            self._known[key] = FreeTransitions(self._index, owner, transitions, in_parallel=in_parallel)
        return self._known[key]


def _in_parallel(spot: StateRef) -> bool:
    return any(isinstance(here.state, Parallel) for here in spot.upward())


def _can_fire(index: MissionIndex, transition: TransitionRef, outcomes: frozenset[str]) -> bool:
    """Whether a transition can fire in a state that runs nothing, where these outcomes come from next to it."""
    definition = transition.definition
    if not definition.on:
        return True
    if any(word == ANY_EVENT or word in index.events or index.events.meant(word) for word in definition.on):
        return True
    if definition.of is not None:
        source = index.spot(definition.of)
        outcomes = reported(index).by(source) if source is not None else frozenset()
    return any(word in outcomes for word in definition.on)


def _own_transitions(index: MissionIndex) -> list[TransitionRef]:
    """The mission's own transitions, which are last."""
    return index.transitions[len(index.transitions) - len(index.mission.transitions) :]
