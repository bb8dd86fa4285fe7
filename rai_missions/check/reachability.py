# SPDX-License-Identifier: Apache-2.0
"""States that nothing leads to, and states that nothing can leave."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

from rai_missions.check.finding import Found
from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.scc import knots
from rai_missions.check.ways_out import WaysOut
from rai_missions.states import Final, History, Parallel

__all__ = ("dead_ends", "domain_of", "entered_with", "unreachable_states", "waiting_rooms")


class Reach:
    """What can be active at some time, as far as the transitions' targets state: guards and triggers do not count."""

    def __init__(self, index: MissionIndex) -> None:
        self.index = index
        self.active: set[StateRef] = set()
        self._descended: set[tuple[StateRef, StateRef | None]] = set()
        self._side_by_side: set[StateRef] = set()
        """Regions that were entered as those that no target is in."""

    def enter(self, targets: Iterable[StateRef], stays: StateRef | None = None, *, follow: bool = True) -> None:
        """Mark what entering the targets makes active, then (to `follow`) what the transitions there lead to.

        Args:
            targets: Where something leads.
            stays: The innermost state that is not entered, since it stays active; None: the mission itself.
            follow: Whether the transitions of what is entered are followed.
        """
        todo = [(target, stays) for target in targets]
        while todo:
            spot, stays = todo.pop()
            for here in spot.upward():
                if here is stays:
                    break
                if here not in self.active:
                    self.active.add(here)
                    for transition in here.transitions if follow else ():
                        todo += [(target, domain_of(transition)) for target in transition.targets]
                todo += [(region, here.parent) for region in self._other_regions(here, stays)]
            is_history = isinstance(spot.state, History)
            descent = spot, stays if is_history else None
            if (spot.children or is_history) and descent not in self._descended:
                self._descended.add(descent)
                todo += [(each, stays if is_history else spot) for each in default_entry(self.index, spot)]

    def _other_regions(self, here: StateRef, stays: StateRef | None) -> list[StateRef]:
        """The other regions of a parallel state that is entered with one of its regions, unless they were."""
        parent = here.parent
        if parent is None or parent is stays or not isinstance(parent.state, Parallel):
            return []
        found = [region for region in parent.children if region is not here and region not in self._side_by_side]
        self._side_by_side.update(found)
        return found


def domain_of(transition: TransitionRef) -> StateRef | None:
    """The innermost compound state around owner and targets (SCXML: the transition's domain); None: the mission."""
    owner, targets = transition.owner, transition.targets
    if owner is None:
        return None
    if not targets or (transition.definition.internal and all(target.inside(owner) for target in targets)):
        return owner
    for here in owner.upward():
        if (
            here is not owner
            and not isinstance(here.state, Parallel)
            and all(target.inside(here) for target in targets)
        ):
            return here
    return None


def default_entry(index: MissionIndex, spot: StateRef) -> list[StateRef]:
    """The states that entering one leads into by itself."""
    if isinstance(spot.state, History):
        return index.found(spot.state.default) or ([spot.parent] if spot.parent is not None else [])
    if isinstance(spot.state, Parallel):
        return [child for child in spot.children if not isinstance(child.state, History)]
    named = index.found(spot.state.starts())
    found = [
        each
        for each in named
        if each.inside(spot)
        and not (isinstance(each.state, History) and each.parent is spot and not each.state.default)
    ]
    return found or spot.children  # an initial that is wrong is one fault, not one a child


def entered_with(index: MissionIndex, targets: Iterable[StateRef], stays: StateRef | None) -> set[StateRef]:
    """What entering the targets makes active inside a state that stays so, history without memory; that state too."""
    reach = Reach(index)
    reach.active.update(stays.upward() if stays is not None else ())
    reach.enter(targets, stays, follow=False)
    return reach.active


def reached(index: MissionIndex) -> set[StateRef]:
    """The states that can be active; worked out once."""
    found = index.remembered.get("reached")
    if not isinstance(found, set):
        mission, reach = index.mission, Reach(index)
        reach.enter(index.found(mission.initial) or index.top)
        for transition in mission.transitions:
            reach.enter(index.found(transition.to))
        reach.enter(index.found((mission.on_cancel,) if mission.on_cancel is not None else ()))
        found = index.remembered["reached"] = reach.active
    return found


def unreachable_states(index: MissionIndex) -> Found:
    """Every state is entered: by a transition, an `initial`, a history, as a region, or by `on_cancel`."""
    active = reached(index)
    lost = {
        spot: index.spots[spot.index : spot.last + 1]
        for spot in index.spots
        if spot not in active and (spot.parent is None or spot.parent in active) and _own_fault(index, spot)
    }
    follows = {spot: [each for each in _targets(index, inside, spot) if each in lost] for spot, inside in lost.items()}
    parts = knots(follows)
    part_of = {spot: part[0] for part in parts for spot in part}
    led = {part_of[each] for spot, after in follows.items() for each in after if part_of[each] is not part_of[spot]}
    for part in parts:
        if part[0] not in led:
            name = part[0].name
            yield (
                part[0].place,
                f'nothing leads to \'{name}\'; add a transition with "to": "{name}", or take the state away',
            )


def _own_fault(index: MissionIndex, spot: StateRef) -> bool:
    """Whether no other finding explains why it is not reached."""
    homeless = spot.parent is None or isinstance(spot.parent.state, Parallel)
    return index.by_name[spot.name] is spot and not (homeless and isinstance(spot.state, History))


def _targets(index: MissionIndex, inside: list[StateRef], whole: StateRef) -> Iterator[StateRef]:
    """Where transitions inside a state lead to, and what that is inside of, as far as it is outside the state."""
    for target in index.found(
        name for spot in inside for transition in spot.transitions for name in transition.definition.to
    ):
        yield from (here for here in target.upward() if here is not whole and not here.inside(whole))


def dead_ends(index: MissionIndex) -> Found:
    """A state that only waits has a transition, here or further out, that can fire and leaves it."""
    ways = WaysOut(index)
    for spot in _waiting(index):
        if not ways.here(spot) and not ways.of_mission(spot):
            yield (
                spot.place,
                f"nothing can leave '{spot.name}': it is not final, runs nothing, "
                "and no transition that can fire leads out of it; add a transition, or make it final",
            )


def waiting_rooms(index: MissionIndex) -> Found:
    """A state that only waits is left by more than those transitions of the mission that give up."""
    success = {spot for spot in index.top if isinstance(spot.state, Final) and spot.state.final == "succeeded"}
    ways = WaysOut(index)
    hopeful: dict[tuple[str, ...], bool] = {}

    def leads_on(transition: TransitionRef) -> bool:
        targets = tuple(transition.definition.to)
        if targets not in hopeful:
            reach = Reach(index)
            reach.enter(index.found(targets))
            hopeful[targets] = bool(reach.active & success)
        return hopeful[targets]

    for spot in _waiting(index) if success else ():
        if ways.here(spot) or ways.leads(spot, leads_on):
            continue
        if transitions := ways.first_of_mission(spot, 4):
            places = ", ".join(transition.place for transition in transitions)
            remedy = "add a transition of its own, or make it final"
            yield spot.place, f"only {places} can leave '{spot.name}', and gives the mission up; {remedy}"


def _waiting(index: MissionIndex) -> Iterator[StateRef]:
    """The reachable states that run nothing and are left by transitions alone."""
    active, timed = reached(index), set[StateRef | None]()
    for spot in index.spots:
        if spot.state.timeout_s is not None or spot.parent in timed:
            timed.add(spot)
        elif spot in active and not (spot.children or isinstance(spot.state, Final | History) or spot.state.activity()):
            yield spot
