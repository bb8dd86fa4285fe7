# SPDX-License-Identifier: Apache-2.0
"""Types: what is compared, set, iterated and measured is of a type with which that can be done."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from typing import Any

from rai_missions.check.finding import Found
from rai_missions.check.index import KeyWrite, MissionIndex, PathUse, Scope
from rai_missions.check.paths import meaning
from rai_missions.errors import DefinitionError, Fault
from rai_missions.guards import GoalIs
from rai_missions.guards.compare import NUMBERS, comparable
from rai_missions.keys import Key, pose_slip, type_error
from rai_missions.states.effects import references

__all__ = (
    "mismatched_activities", "mismatched_comparisons", "mismatched_items", "mismatched_lists", "mismatched_poses",
    "mismatched_writes", "odd_poses", "unreadable_goals",
)  # fmt: skip


def _kind(index: MissionIndex, path: str, scope: Scope) -> str | None:
    return meaning(index, PathUse(path, "", scope)).kind


class _DeclaredTypes:
    """What is declared where a guard is."""

    def __init__(self, index: MissionIndex, scope: Scope) -> None:
        self._index, self._scope = index, scope

    def kind(self, path: str) -> str | None:
        return _kind(self._index, path, self._scope)

    def frame(self, path: str) -> str | None:
        key = self._index.mission.blackboard.get(path)
        return key.frame if key is not None else None

    def listed(self, path: str) -> Sequence[str] | None:
        key = self._index.mission.blackboard.get(path)
        return key.enum if key is not None else None


def mismatched_comparisons(index: MissionIndex) -> Found:
    """A comparison is between values of one type, and `<` between numbers or strings."""
    return _mismatched(index, of_poses=False)


def mismatched_poses(index: MissionIndex) -> Found:
    """`near` measures between two poses that are given in one frame."""
    return _mismatched(index, of_poses=True)


def _mismatched(index: MissionIndex, *, of_poses: bool) -> Found:
    for place, part, ruled in index.parts:
        if (part.word == "near") is of_poses:
            yield from ((place + inner, why) for inner, why in part.type_faults(_DeclaredTypes(index, ruled.scope)))


def mismatched_lists(index: MissionIndex) -> Found:
    """`each` goes over a list."""
    for write in index.writes:
        kind = _kind(index, write.value, write.scope) if write.by == "each" else None
        if kind not in (None, "list"):
            assert write.scope.owner is not None
            place = f"{write.scope.owner.place}/each"
            yield place, f"'{write.value}' is of type '{kind}', not 'list'; 'each' goes over a list"


def mismatched_items(index: MissionIndex) -> Found:
    """Each item of a list that the mission gives to an `each` fits the key that has the item."""
    for key, place, item in _items(index):
        if why := type_error(key, item, written=True):
            yield place, f"this cannot be an item: {why}"


def odd_poses(index: MissionIndex) -> Found:
    """A pose that the mission gives has the words of a pose alone, and its `yaw` is within a turn."""
    keys = index.mission.blackboard
    given = ((keys[name], place, value) for name, place, value in _constants(index) if name in keys)
    for key, place, value in (*given, *_items(index)):
        if not type_error(key, value) and (why := pose_slip(key, value)):
            yield place, why


def mismatched_activities(index: MissionIndex) -> Found:
    """A request is read from a string, a goal is an object, and so is what is seen, what is read and a plan."""
    for spot in index.spots:
        for use in spot.state.type_needs():
            kind = _kind(index, use.path, Scope(spot))
            if kind not in (None, use.kind):
                yield f"{spot.place}{use.place}", f"'{use.path}' is of type '{kind}', not '{use.kind}'; {use.why}"


def mismatched_writes(index: MissionIndex) -> Found:
    """What is set, added or copied to a key is of the key's type."""
    for write in index.writes:
        key = index.mission.blackboard.get(write.key)
        if key is not None and (found := _written(index, write, key)):
            yield found


def _written(index: MissionIndex, write: KeyWrite, key: Key) -> tuple[str, str] | None:
    """What is wrong with a write, if anything is."""
    if write.by == "from":
        kind = _kind(index, write.value, write.scope)
        exact = key.type == "integer" and kind == "number"
        if kind is not None and (exact or not (comparable(kind, key.type) or {kind, key.type} == {"object", "pose"})):
            return (
                write.place,
                f"'{write.key}' is of type '{key.type}' and '{write.value}' of type '{kind}'; copy a key of its type",
            )
    elif write.by == "add":
        if key.type not in NUMBERS:
            return (
                f"{write.place}/add",
                f"'{write.key}' is of type '{key.type}', to which nothing can be added; use 'value'",
            )
        if key.type == "integer" and write.value != int(write.value):
            return (
                f"{write.place}/add",
                f"'{write.key}' is an integer, and {write.value:g} is none; add a whole number, or make it a number",
            )
    elif write.by == "status" and key.type != "string":
        return write.place, f"'{write.key}' is of type '{key.type}', and a status is a string; write one that is"
    elif (
        write.by == "set"
        and next(references(write.value), None) is None
        and (why := type_error(key, write.value, written=True))
    ):
        return f"{write.place}/value", f"'{write.key}' cannot hold this: {why}"
    return None


def unreadable_goals(index: MissionIndex) -> Found:
    """A goal that is written in the mission is one that the planner reads."""
    constants = list(_constants(index))
    goals = _goal_paths(index) if constants else set[str]()
    for name, place, value in constants:
        if name in goals:
            yield from ((place + each.place, each.sentence) for each in _goal_faults(value))


def _goal_faults(value: Mapping[str, Any]) -> tuple[Fault, ...]:
    from rai_missions.planning import read_goal  # a planner; few missions have goals

    try:
        read_goal(value)
    except DefinitionError as error:
        return tuple(error.faults)
    return ()


def _goal_paths(index: MissionIndex) -> set[str]:
    """From where guards and activities read a goal."""
    asked = {part.goal for _, part, _ in index.parts if isinstance(part, GoalIs)}
    return asked | {use.path for spot in index.spots for use in spot.state.type_needs() if use.is_goal}


def _items(index: MissionIndex) -> Iterator[tuple[Key, str, Any]]:
    """The items of the lists that the mission itself gives to what an `each` goes over: the item's key, place, item."""
    keys = index.mission.blackboard
    taken = {(write.value, write.key) for write in index.writes if write.by == "each" and write.key in keys}
    if taken:
        for name, place, value in _given(index):
            if isinstance(value, list | tuple):
                for key in sorted(key for listed, key in taken if listed == name):
                    yield from ((keys[key], f"{place}/{number}", item) for number, item in enumerate(value))


def _constants(index: MissionIndex) -> Iterator[tuple[str, str, Mapping[str, Any]]]:
    """The objects that the mission itself gives to its keys: key, place, object; an empty one is no goal."""
    for name, place, value in _given(index):
        if isinstance(value, Mapping) and value:
            yield name, place, value


def _given(index: MissionIndex) -> Iterator[tuple[str, str, Any]]:
    """The values that the mission itself gives to its keys, without those that name other keys: key, place, value."""
    initial = ((name, f"/blackboard/{name}/initial", key.initial) for name, key in index.mission.blackboard.items())
    values = ((write.key, f"{write.place}/value", write.value) for write in index.writes if write.by == "set")
    for name, place, value in (*initial, *values):
        if next(references(value), None) is None:
            yield name, place, value
