# SPDX-License-Identifier: Apache-2.0
"""Two missions brought to the same names: what of the one is what of the other, and which transition is which.

Rule: what is taken for a rename is compared all the same, so a wrong guess hides nothing.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import NamedTuple

from rai_missions.mission.mission import Mission
from rai_missions.mission.renaming import Names, matched, renamed
from rai_missions.states import State, Transition
from visualize.build import parents_of
from visualize.diff.similarity import ComparedMissions, alike_keys, alike_options, alike_states

__all__ = ("NameChange", "aligned", "paired")


class NameChange(NamedTuple):
    """Something that is the same but for its name."""

    sort: str
    """`state`, `key`, `event` or `option`."""
    old: str
    new: str
    score: float
    """How alike they are, from 0 to 1; 1 is the same in all but names."""
    where: str = ""
    """For an option the state that asks, as the new mission calls it."""


def aligned(old: Mission, new: Mission) -> tuple[Mission, tuple[NameChange, ...]]:
    """The old mission under the names of the new one, and what was renamed for it."""
    found: list[NameChange] = []
    for sort, of in (("key", "blackboard"), ("event", "events")):
        for (was, now), score in alike_keys(old, new, of).items():
            found.append(NameChange(sort, was, now, score))
    keys, events = ({each.old: each.new for each in found if each.sort == sort} for sort in ("key", "event"))
    if found:
        old = renamed(old, Names.by(keys=keys, events=events))
    known = ComparedMissions(old, new, parents_of(old), parents_of(new))
    states = alike_states(known)
    found += [NameChange("state", was, now, score) for (was, now), score in states.items()]
    if states:
        old = renamed(old, Names.by(states=dict(states.keys())))
    options: dict[str, dict[str, str]] = {}
    now_there = {name: state for _, name, state in new.walk()}
    for _, name, state in old.walk():
        other = now_there.get(name)
        if state.options and other is not None:
            options[name] = alike_options(state, other)
            found += [NameChange("option", was, now, 1.0, name) for was, now in options[name].items()]
    if any(options.values()):
        old = old.model_copy(update={"states": _with_options(old.states, options)})
    return old, tuple(found)


def _with_options(states: Mapping[str, State], options: Mapping[str, Mapping[str, str]]) -> dict[str, State]:
    return {
        name: state.with_options(options[name])
        if options.get(name)
        else state.with_children(_with_options(state.children(), options))
        for name, state in states.items()
    }


def paired(old: Sequence[Transition], new: Sequence[Transition]) -> list[tuple[int | None, int | None]]:
    """Which transition became which: the same first, then those that differ least; (old, None) went, (None, new) came.

    In the order of the new transitions, with those that are gone at the end.
    """
    left, right = dict(enumerate(old)), dict(enumerate(new))
    pairs: dict[int, int] = {}
    for same in (
        lambda one, other: one == other,
        lambda one, other: (one.on, one.of, one.after_s, one.to) == (other.on, other.of, other.after_s, other.to),
        lambda one, other: (one.on, one.of) == (other.on, other.of) and one.eventless == other.eventless,
        lambda one, other: bool(set(one.on) & set(other.on)) and one.to == other.to,
        lambda one, other: one.to == other.to and one.when == other.when,
    ):
        for here, there in matched(left, right, same).items():
            pairs[here] = there
            del left[there], right[here]
    found: list[tuple[int | None, int | None]] = [(pairs.get(index), index) for index in range(len(new))]
    return found + [(index, None) for index in left]
