# SPDX-License-Identifier: Apache-2.0
"""The states of the other mission that are active there, and what they were called.

Rule: a state that is active and has changed, or is no more, must be named by the map; nothing is guessed.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

from rai_missions.engine import Chart
from rai_missions.errors import Fault
from rai_missions.replay.migrate.names import Naming
from rai_missions.states.compound import Each, Parallel
from rai_missions.states.final import Final
from rai_missions.states.history import History

__all__ = ("ReachedStates", "reached_states")

TOP = 2
"""Slashes in the pointer of a state that is in no other."""


class ReachedStates(NamedTuple):
    """The active states of the other mission."""

    atomic: tuple[str, ...]
    """The innermost, in document order."""
    origins: Mapping[str, str]
    """Active state → what it was called when it became active; one that is not there is new."""
    active: tuple[str, ...]
    """All, outer before inner."""


def reached_states(
    naming: Naming, was: Mapping[str, Any], active: frozenset[str], chart: Chart
) -> tuple[ReachedStates, list[Fault]]:
    """Find the states in which a run continues.

    Args:
        naming: What everything is called.
        was: The snapshot of the run's chart.
        active: The names of all states that were active.
        chart: One of the other mission, for its graph.
    """
    faults = [fault for name in naming.states_then if name in active for fault in _gone(naming, name)]
    targets = {new: old for old in was["atomic"] if (new := naming.state(old)) is not None}
    faults += [fault for new, old in targets.items() for fault in _unfit(naming, old, new)]
    if not targets and not faults:
        faults.append(Fault("/states", "none of the active states has a place in the mission now; name one for each"))
    if faults:
        return ReachedStates((), {}, ()), faults
    found, rivals = chart.configuration(targets)
    clash = [Fault("/states", f"{pair} would be active together, and cannot be; name one of them") for pair in rivals]
    origins = {new: old for old in naming.states_then if old in active and (new := naming.state(old)) in found.active}
    order = tuple(name for name in naming.states_now if name in found.active)
    reached = ReachedStates(tuple(node.name for node in found.atomic), origins, order)
    faults = [*clash, *_unreached(naming, reached, active), *_inside_lists(naming, reached, active)]
    return reached, [*faults, *_completed(naming, origins, reached, active)]


def _gone(naming: Naming, name: str) -> Iterator[Fault]:
    """An active state that must be named and is not."""
    if name in naming.map.states:
        return
    if name not in naming.states_now:
        sentence = f"'{name}' is active, and the mission now has no state of that name; name what has become of it"
        yield Fault("/states", f'{sentence}: "{name}": "…", or null if nothing has')
    elif words := naming.changed(name, name):
        changed = ", ".join(f"'{word}'" for word in words if word) or "its kind"
        sentence = f"'{name}' is active and has changed ({changed}); if it still means the same, name it"
        yield Fault("/states", f'{sentence}: "{name}": "{name}"')


def _unfit(naming: Naming, old: str, new: str) -> Iterator[Fault]:
    """A state that a run cannot be put into."""
    place = f"/states/{old}"
    (then, was), (here, now) = naming.states_then[old], naming.states_now[new]
    is_deep = [place.count("/") > TOP for place in (then, here)]
    if isinstance(now, History):
        yield Fault(place, f"'{new}' is a history, which is never active; name the state that it leads to")
    elif isinstance(now, Final) and (not isinstance(was, Final) or was.final != now.final or is_deep[0] != is_deep[1]):
        yield Fault(place, f"'{new}' is a final: a map ends no run; name a state from which a transition leads there")
    elif isinstance(now, Each) and not isinstance(was, Each):  # one that was empty has nothing active inside it
        yield Fault(place, f"'{new}' goes through a list; name a state inside it")


def _unreached(naming: Naming, found: ReachedStates, was_active: frozenset[str]) -> Iterator[Fault]:
    """What the map names and the innermost states do not lead to."""
    for old, new in naming.map.states.items():
        if old in was_active and new in naming.states_now and new not in found.active:
            sentence = f"'{new}' would not be active, for what was active inside '{old}' is not inside '{new}' now"
            yield Fault(f"/states/{old}", f"{sentence}; name that too, or leave '{old}' out")


def _inside_lists(naming: Naming, found: ReachedStates, was_active: frozenset[str]) -> Iterator[Fault]:
    """A list, and how far in it the run has come is not known."""
    for name in found.active:
        state, old = naming.states_now[name][1], found.origins.get(name)
        was = naming.states_then[old][1] if old is not None else None
        if not isinstance(state, Each):
            continue
        if not isinstance(was, Each):
            sentence = f"'{name}' goes through a list, and no active state shows how far in it the run has come"
            yield Fault("/states", f"{sentence}; name one that did so, or a state outside")
        elif was.children().keys() & was_active and not state.children().keys() & set(found.active):
            sentence = f"'{name}' goes through a list, and nothing inside it would be active"
            yield Fault("/states", f"{sentence}; name a state inside it, or one outside")


def _completed(
    naming: Naming, origins: Mapping[str, str], found: ReachedStates, was_active: frozenset[str]
) -> Iterator[Fault]:
    """A parallel state that the map alone would bring to its end."""
    for name in found.active:
        state = naming.states_now[name][1]
        if not isinstance(state, Parallel) or not _has_ended(state, frozenset(found.active)):
            continue
        old = naming.states_then[origins[name]][1] if name in origins else None
        if not (isinstance(old, Parallel) and _has_ended(old, was_active)):
            sentence = f"all regions of '{name}' would have ended, which no map brings about"
            yield Fault("/states", f"{sentence}; name a state in one of them that has not")


def _has_ended(state: Parallel, active: frozenset[str]) -> bool:
    return all(
        isinstance(region, Final) or any(isinstance(each, Final) and name in active for name, each in inside.items())
        for region, inside in ((region, region.children()) for region in state.children().values())
    )
