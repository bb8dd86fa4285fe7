# SPDX-License-Identifier: Apache-2.0
"""What may be where: initials, lists of targets, history, finals, transitions into themselves."""

from __future__ import annotations

from collections.abc import Sequence

from rai_missions.check.finding import Found
from rai_missions.check.index import MissionIndex, StateRef, TransitionRef
from rai_missions.check.pointers import listed_names
from rai_missions.states import Compound, Each, Final, History, Parallel

__all__ = (
    "crossing_transitions",
    "history_defaults",
    "initial_outside",
    "misplaced_states",
    "misused_internal",
    "target_lists",
    "words_in_vain",
)


def initial_outside(index: MissionIndex) -> Found:
    """`initial` names a state inside the one that it is in; a history of the same has a default."""
    for spot in index.spots:
        for place, name in listed_names(f"{spot.place}/initial", spot.state.starts()):
            target = index.by_name.get(name)
            if target is None:
                continue
            if not target.inside(spot):
                inside = ", ".join(child.name for child in spot.children[:8])
                yield place, f"'{name}' is not inside '{spot.name}'; inside it are: {inside}"
            elif isinstance(target.state, History) and target.parent is spot and not target.state.default:
                yield place, _leads_back(name)
    for place, name in listed_names("/initial", index.mission.initial):
        target = index.by_name.get(name)
        if target is not None and isinstance(target.state, History) and target.parent is None:
            yield place, _leads_back(name)


def _leads_back(name: str) -> str:
    remedy = 'name a state instead, or give it a default: "transitions": [{"to": …}]'
    return f"the history '{name}' leads to this 'initial' where there is no memory; {remedy}"


def history_defaults(index: MissionIndex) -> Found:
    """A history's default is a state inside its parent, of a shallow one a child, and no history."""
    for spot in index.spots:
        if not isinstance(spot.state, History) or spot.parent is None:
            continue
        for target in index.found(spot.state.default):
            place, parent = f"{spot.place}/transitions/0/to", spot.parent
            if not target.inside(parent):
                yield (
                    place,
                    f"'{target.name}' is not inside '{parent.name}'; '{spot.name}' leads back there, name one in it",
                )
            elif isinstance(target.state, History):
                yield place, f"'{target.name}' is a history too; name the state to which it is to lead without memory"
            elif spot.state.history == "shallow" and target.parent is not parent:
                child = next(each for each in target.upward() if each.parent is parent)
                remedy = f"name '{child.name}', or make it deep"
                yield place, f"a shallow history leads to a child of '{parent.name}', not to '{target.name}'; {remedy}"


def target_lists(index: MissionIndex) -> Found:
    """A list of targets names one state in each of several regions of one parallel."""
    lists = [("/initial", index.mission.initial)]
    initials = ((spot.place, spot.state.starts()) for spot in index.spots)
    lists += [(f"{place}/initial", names) for place, names in initials if len(names) > 1]
    lists += [(f"{each.place}/to", each.definition.to) for each in index.transitions if len(each.definition.to) > 1]
    for place, names in lists:
        targets = [index.by_name.get(name) for name in names]
        if sentence := _clash([target for target in targets if target is not None]):
            yield place, sentence


def _clash(targets: Sequence[StateRef]) -> str:
    """Why targets cannot be entered together; empty if they can."""
    via: dict[StateRef | None, StateRef] = {}
    for target in targets:
        below = target
        for above in (*tuple(target.upward())[1:], None):
            other = via.setdefault(above, below)
            if other is not below and not (above is not None and isinstance(above.state, Parallel)):
                where = "at the top of the mission" if above is None else f"inside '{above.name}'"
                names = f"'{other.name}' and '{below.name}'"
                return f"{names} are never active together {where}; name states in different regions of one parallel"
            if above is None:
                break
            below = above
    for number, target in enumerate(targets):
        if target in targets[:number]:
            return f"'{target.name}' is named twice; name one state a region"
        if target in via:
            return f"'{via[target].name}' is inside '{target.name}', and the list enters both; name one state a region"
    return ""


def misplaced_states(index: MissionIndex) -> Found:
    """A history is in a compound state, a final not next to regions, and neither has a timeout or control."""
    for spot in index.spots:
        state, parent = spot.state, spot.parent
        if not isinstance(state, Final | History):
            continue
        is_region = parent is not None and isinstance(parent.state, Parallel)
        where = f"among the regions of '{parent.name}'" if parent is not None else "at the top, which is never left"
        if isinstance(state, History):
            kind, why, words = "history", "it is never active itself", ["entry", "exit"]
            if is_region or parent is None:
                remedy = "put it into the compound state that it is to remember"
                yield spot.place, f"the history '{spot.name}' is {where}; {remedy}"
        else:
            kind, why, words = "final", "it ends its parent", ["transitions"]
            if is_region:
                yield spot.place, f"the final '{spot.name}' is {where}; put it into a region"
        for word in ("timeout_s", "control", *words):
            if getattr(state, word):
                yield f"{spot.place}/{word}", f"a {kind} state has no '{word}', for {why}; take it away"


def misused_internal(index: MissionIndex) -> Found:
    """`internal` leads from a compound state to a state inside it."""
    for transition in index.transitions:
        if not transition.definition.internal:
            continue
        place, owner = f"{transition.place}/internal", transition.owner
        if owner is None or not isinstance(owner.state, Compound | Each):
            name = "the mission's own transition" if owner is None else f"'{owner.name}'"
            yield place, f"'internal' is for transitions of a compound state, which {name} is not; take it away"
            continue
        for target in transition.targets:
            if target is owner:
                yield (
                    place,
                    f"a transition to '{owner.name}' itself leaves and enters it; "
                    "lead inside it, or take 'internal' away",
                )
            elif not target.inside(owner):
                yield (
                    place,
                    f"'{target.name}' is not inside '{owner.name}', so the transition leaves it; take 'internal' away",
                )


def crossing_transitions(index: MissionIndex) -> Found:
    """A transition that leads from one region into another restarts the whole parallel."""
    if not any(isinstance(spot.state, Parallel) for spot in index.spots):
        return
    for transition in index.transitions:
        for target in transition.targets:
            parallel = _crossed(transition, target)
            if parallel is not None and len(transition.definition.to) == 1:
                yield (
                    f"{transition.place}/to",
                    f"'{target.name}' is in another region of '{parallel.name}', so all its regions are left and "
                    "entered again; raise an event that a transition there waits for, or lead out of the parallel",
                )


def _crossed(transition: TransitionRef, target: StateRef) -> StateRef | None:
    """The parallel between whose regions a transition leads."""
    if transition.owner is None:
        return None
    meeting = next((here for here in transition.owner.upward() if target.inside(here) or target is here), None)
    inner = meeting is not None and meeting is not transition.owner and meeting is not target
    return meeting if meeting is not None and inner and isinstance(meeting.state, Parallel) else None


def words_in_vain(index: MissionIndex) -> Found:
    """`in` asks for a state that can be active."""
    for place, part, _ in index.parts:
        for name in part.states():
            spot = index.by_name.get(name)
            if spot is not None and isinstance(spot.state, History):
                remedy = f"'{spot.parent.name}'" if spot.parent is not None else "a state that it leads to"
                yield f"{place}/in", f"'{name}' is a history, which is never active itself; ask for {remedy}"
