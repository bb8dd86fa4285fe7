# SPDX-License-Identifier: Apache-2.0
"""Two missions brought to the same names: which state of the one is which of the other, and which row which row.

Rule: a state is renamed where its definition is the same but for names, it stands in the same place, and no other fits.
"""

from __future__ import annotations

import json
from collections import defaultdict
from collections.abc import Mapping, Sequence
from typing import Any

from rai_missions.mission import Mission
from rai_missions.states.state import State, Transition

__all__ = ("paired", "parents", "renamed", "with_names")

DATA = ("goal", "request", "message", "value", "with", "data", "parameters", "result")
"""The words under which nothing names a state."""


def parents(mission: Mission) -> dict[str, str]:
    """State → the state around it; empty at the top."""
    found = dict.fromkeys(mission.states, "")
    for _, name, state in mission.walk():
        found |= dict.fromkeys(state.children(), name)
    return found


def renamed(old: Mission, new: Mission) -> dict[str, str]:
    """Old name → new name, for the states that are called otherwise now."""
    before, after = parents(old), parents(new)
    gone, come = before.keys() - after.keys(), after.keys() - before.keys()
    names: dict[str, str] = {}
    while True:
        hidden = gone | come
        left = _by_definition(
            old, gone - names.keys(), hidden, {name: names.get(at, at) for name, at in before.items()}
        )
        right = _by_definition(new, come - set(names.values()), hidden, after)
        found = {
            left[key][0]: right[key][0] for key in left.keys() & right.keys() if len(left[key]) == len(right[key]) == 1
        }
        if not found:
            return names
        names |= found


def _by_definition(
    mission: Mission, wanted: set[str], hidden: set[str], within: Mapping[str, str]
) -> dict[tuple[str, str], list[str]]:  # fmt: skip
    found: dict[tuple[str, str], list[str]] = defaultdict(list)
    for _, name, state in mission.walk():
        if name in wanted:
            found[within[name], _definition(state, hidden)].append(name)
    return found


def _definition(state: State, hidden: set[str]) -> str:
    """A state as text, without the names that only one of the missions has and without what stands inside."""
    own = state.written()
    if state.children():
        own[state.child_place()] = len(state.children())
    return json.dumps(_mapped(own, dict.fromkeys(hidden, "?")), sort_keys=True)


def with_names(mission: Mission, names: Mapping[str, str]) -> Mission:
    """The same mission with some states called otherwise."""
    return Mission.model_validate(_mission(mission.written(), names)) if names else mission


def _mission(document: dict[str, Any], names: Mapping[str, str]) -> dict[str, Any]:
    reached = ("states", "transitions", "initial", "on_cancel", "invariants")
    return {word: _mapped({word: value}, names)[word] if word in reached else value for word, value in document.items()}


def _mapped(given: Any, names: Mapping[str, str]) -> Any:
    """A part of a mission with the names of states replaced wherever they are meant."""
    if isinstance(given, list):
        return [_mapped(item, names) for item in given]
    if not isinstance(given, dict):
        return given
    found: dict[str, Any] = {}
    for word, value in given.items():
        if word in ("to", "initial", "of", "on_cancel") or (word == "in" and "key" not in given):
            found[word] = (
                [names.get(each, each) for each in value] if isinstance(value, list) else names.get(value, value)
            )
        elif word == "states" or (word == "parallel" and isinstance(value, dict)):
            found[word] = (
                {names.get(name, name): _mapped(state, names) for name, state in value.items()}
                if isinstance(value, dict)
                else value
            )
        else:
            found[word] = value if word in DATA else _mapped(value, names)
    return found


def paired(old: Sequence[Transition], new: Sequence[Transition]) -> list[tuple[int | None, int | None]]:
    """Which row became which: the same first, then those that differ least; (old, None) is gone, (None, new) has come.

    In the order of the new rows, with those that are gone at the end.
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
        for here, row in list(right.items()):
            match = next((there for there, before in left.items() if same(before, row)), None)
            if match is not None:
                pairs[here] = match
                del left[match], right[here]
    found: list[tuple[int | None, int | None]] = [(pairs.get(index), index) for index in range(len(new))]
    return found + [(index, None) for index in left]
