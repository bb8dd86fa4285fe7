# SPDX-License-Identifier: Apache-2.0
"""Success rests on what the robot reported: which keys come from it, and whether a guard can be true without it.

Rule: no one can declare success, the author included. What is set to a constant, given at the start or answered by a
model counts as reported by no one.
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any, NamedTuple

from rai_missions.check.finding import Found
from rai_missions.check.index import KeyWrite, MissionIndex
from rai_missions.check.paths import key_of
from rai_missions.states import Final
from rai_missions.states.effects import references
from rai_missions.states.state import OUTCOMES

__all__ = ("early_results", "missing_requires", "origins", "unfounded_success")


class Origin(NamedTuple):
    """Where a key's values come from."""

    robot: bool = False
    """Some come from the robot."""
    stranger: bool = False
    """Some come from an argument, an answer, or a payload that anybody may send."""
    constants: frozenset[str] = frozenset()
    """The constants that the author wrote, as JSON."""

    def joined(self, other: Origin) -> Origin:
        """Both."""
        return Origin(self.robot or other.robot, self.stranger or other.stranger, self.constants | other.constants)


ROBOT, STRANGER, NO_ROBOT = Origin(robot=True), Origin(stranger=True), Origin()


def origins(index: MissionIndex) -> Mapping[str, Origin]:
    """Where the values of each key come from; a fixpoint, for keys are copied to keys."""
    found = index.remembered.get("origins")
    if isinstance(found, dict):
        return found
    found = {name: _first(key.source, key.initial) for name, key in index.mission.blackboard.items()}
    index.remembered["origins"] = found
    waiting: dict[str, list[KeyWrite]] = {}
    for write in index.writes:
        if write.by in ("from", "each"):
            waiting.setdefault(write.value.partition(".")[0], []).append(write)
        if write.key in found and index.mission.blackboard[write.key].source == "mission":
            found[write.key] = found[write.key].joined(_of(write))
    todo = list(found)
    while todo:
        name = todo.pop()
        for write in waiting.get(name, ()):
            before = found.get(write.key)
            if before is None or index.mission.blackboard[write.key].source != "mission":
                continue
            after = before.joined(_taken(found[name], write))
            if after != before:
                found[write.key] = after
                todo.append(write.key)
    return found


def _first(source: str, initial: Any) -> Origin:
    if source == "mission":
        return NO_ROBOT if initial is None else Origin(constants=frozenset([_text(initial)]))
    return ROBOT if source == "robot" else STRANGER


def _text(value: Any) -> str:
    return json.dumps(value, sort_keys=True, default=str)


def _of(write: KeyWrite) -> Origin:
    """What a write adds by itself; copies of keys are followed later."""
    if write.by == "result":
        return ROBOT
    if write.by == "set":
        return (
            STRANGER
            if next(references(write.value), None) is not None
            else Origin(constants=frozenset([_text(write.value)]))
        )
    if write.by == "status":
        return Origin(constants=frozenset(map(_text, ("running", "success", "failure"))))
    if write.by in ("add", "read", "plan"):  # worked out, of a request or a goal too
        return STRANGER
    root = write.value.partition(".")[0]
    if root == "event":
        return ROBOT if _from_activity(write) else STRANGER
    return STRANGER if root == "answer" else NO_ROBOT


def _from_activity(write: KeyWrite) -> bool:
    """Whether `event.…` is the result of an action or call: every trigger of the transition is an outcome of one."""
    transition = write.scope.transition
    if (
        transition is None
        or transition.owner is None
        or transition.definition.of is not None
        or not transition.owner.state.reports_robot
    ):
        return False
    return all(word in OUTCOMES for word in transition.definition.on)


def _taken(origin: Origin, write: KeyWrite) -> Origin:
    """What a copy, or a field or item of it, carries along."""
    if write.by == "each":
        return origin._replace(constants=frozenset(), stranger=origin.stranger or bool(origin.constants))
    return origin._replace(constants=frozenset(map(_text, _fields(origin, write.value))))


class _Sources:
    """Where the values of a mission's keys come from, for guards."""

    def __init__(self, index: MissionIndex) -> None:
        self._index = index

    def is_robots(self, path: str) -> bool:
        return _origin(self._index, path) == ROBOT

    def constants(self, path: str) -> list[Any] | None:
        origin = _origin(self._index, path)
        return None if not origin.robot or origin.stranger else _fields(origin, path)

    def known(self, path: str) -> list[Any]:
        name = path.partition(".")[0]
        key = self._index.mission.blackboard.get(name)
        initial = [key.initial] if key is not None and key.initial is not None and "." not in path else []
        return initial + _fields(_origin(self._index, path), path)


def _origin(index: MissionIndex, path: str) -> Origin:
    """The origin of the key that a path means; another rule reports a key that does not exist."""
    name = key_of(index, path)
    return STRANGER if path.startswith(("event.", "answer.")) else origins(index).get(name or "", ROBOT)


def _fields(origin: Origin, path: str) -> list[Any]:
    """What its constants have at a path."""
    values = [json.loads(text) for text in origin.constants]
    for field in path.split(".")[1:]:
        values = [value[field] for value in values if isinstance(value, dict) and field in value]
    return values


def unfounded_success(index: MissionIndex) -> Found:
    """`achieved` and the `requires` of a top-level `succeeded` each rest on a robot key or an action's result."""
    for ruled in index.guards:
        owner = ruled.scope.owner
        final = ruled.role == "requires" and owner is not None and owner.parent is None and _succeeds(owner.state)
        if (ruled.role == "achieved" or final) and not ruled.guard.rests(_Sources(index)):
            or_result = ", or one that an action's 'result' writes" if final else ""
            yield (
                ruled.place,
                f"this can be true without a word of the robot: {ruled.guard.words():.200}; "
                f"compare a key of the source 'robot'{or_result}",
            )


def early_results(index: MissionIndex) -> Found:
    """What `achieved` reads is known before the action's own `result` is written."""
    read: dict[str, dict[str, None]] = {}
    for _, part, whole in index.parts:
        if whole.role == "achieved":
            read.setdefault(whole.place, {}).update((key_of(index, path) or "", None) for path in part.paths())
    writers: dict[str, list[str]] = {}
    for write in index.writes:
        after = f"{write.place.rpartition('/result/')[0]}/achieved" if write.by == "result" else ""
        writers.setdefault(write.key, []).append(after)
    for place, keys in read.items():
        for key in keys:
            by = writers.get(key, [])
            if place in by and all(key in read.get(other, ()) for other in by):
                yield (
                    place,
                    f"it is judged before the action's 'result' writes '{key}', so the result cannot make it true; "
                    "ask this in the 'requires' of the final that follows, or compare a key of the source 'robot'",
                )


def _succeeds(state: object) -> bool:
    return isinstance(state, Final) and state.final == "succeeded"


def missing_requires(index: MissionIndex) -> Found:
    """A top-level `succeeded` has a `requires`."""
    for spot in index.top:
        if isinstance(spot.state, Final) and _succeeds(spot.state) and spot.state.requires is None:
            answered = any(
                transition.owner is not None and bool(transition.owner.options)
                for transition in index.transitions
                if spot.name in transition.definition.to
            )
            why = (
                "an answer alone would declare success" if answered else "nothing the robot reports would have to agree"
            )
            yield (
                spot.place,
                f"the mission succeeds at '{spot.name}' without 'requires', so {why}; "
                "add what the robot's keys must state",
            )
