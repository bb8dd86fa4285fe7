# SPDX-License-Identifier: Apache-2.0
"""Other names for what a mission refers to: keys, events, states and timers, wherever they stand.

Rule: `REFERS` says of every field that names something what it names; a test holds it complete.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, NamedTuple, TypeVar

from rai_missions.guards import Compare, Fresh, In, Named, Near
from rai_missions.model import MissionModel
from rai_missions.states import Action, Call, Compound, DecisionSpec, Default, Each, Include, Parallel, Transition
from rai_missions.states.effects import Call as CallEffect
from rai_missions.states.effects import Drop, Publish, Raise, Set
from rai_missions.states.tree import ActionLeaf, CallLeaf, PublishLeaf, SetLeaf, StatusToBlackboard

__all__ = ("REFERS", "Names", "renamed")

AnyWritten = TypeVar("AnyWritten", bound=MissionModel)
Change = Callable[[str], str]


class Names(NamedTuple):
    """New names for old ones."""

    state: Change
    key: Change
    event: Change
    timer: Change
    trigger: Callable[[tuple[str, ...]], tuple[str, ...]]
    """For the words of a row's `on`, among which there are outcomes and options too."""


def path(names: Names, given: str) -> str:
    """A key or a field of one; what the event or answer in hand brought keeps its name."""
    head, dot, rest = given.partition(".")
    return names.key(head) + dot + rest


def template(names: Names, given: Any) -> Any:
    """A JSON value in which `{"from": path}` stands for a key's value, and in a comparison `{"key": path}` too."""
    if isinstance(given, Mapping):
        if len(given) == 1 and isinstance(given.get("from"), str):
            return {"from": path(names, given["from"])}
        return {word: template(names, item) for word, item in given.items()}
    if isinstance(given, list | tuple):
        return [template(names, item) for item in given]
    return given


def operand(names: Names, given: Any) -> Any:
    if isinstance(given, Mapping) and len(given) == 1:
        word, value = next(iter(given.items()))
        if word in ("key", "from") and isinstance(value, str):
            return {word: path(names, value)}
    return given


def _each(change: Callable[[Names, Any], Any]) -> Callable[[Names, Any], Any]:
    return lambda names, given: tuple(change(names, item) for item in given)


def _words(change: Callable[[Names, Any], Any]) -> Callable[[Names, Any], Any]:
    return lambda names, given: {change(names, word): _inside(item, names) for word, item in given.items()}


def state(names: Names, given: str) -> str:
    return names.state(given)


def key(names: Names, given: str) -> str:
    return names.key(given)


def event(names: Names, given: str) -> str:
    return names.event(given)


def timer(names: Names, given: str) -> str:
    return names.timer(given)


def trigger(names: Names, given: tuple[str, ...]) -> tuple[str, ...]:
    return names.trigger(given)


OPERATORS = dict.fromkeys(Compare.WORDS.values(), operand)
GOAL = {"goal": template, "result": _words(key)}
REQUEST = {"request": template, "result": _words(key)}
SET = {"set": key, "value": template, "from_": path}

REFERS: Mapping[type[MissionModel], Mapping[str, Callable[[Names, Any], Any]]] = {
    Transition: {"on": trigger, "of": state, "to": _each(state)},
    Default: {"to": _each(state), "on": trigger, "of": state},
    Compound: {"initial": _each(state), "states": _words(state)},
    Parallel: {"parallel": _words(state)},
    Each: {"each": path, "item": key, "initial": _each(state), "states": _words(state)},
    Include: {"with_": template},
    Action: GOAL,
    ActionLeaf: GOAL,
    Call: REQUEST,
    CallLeaf: REQUEST,
    DecisionSpec: {"evidence": _each(path)},
    SetLeaf: SET,
    PublishLeaf: {"message": template},
    StatusToBlackboard: {"key": key},
    Set: SET,
    Raise: {"event": event, "id": timer, "data": template},
    Drop: {"drop": timer},
    CallEffect: {"request": template},
    Publish: {"message": template},
    Compare: {"key": path, **OPERATORS},
    Fresh: {"fresh": path},
    In: {"state": state},
    Near: {"near": _each(path)},
    Named: {"with_": template},
}
"""Kind → field → how what it names is renamed; other fields hold written things, which are gone into, or values."""


def renamed(item: AnyWritten, names: Names) -> AnyWritten:
    """A written thing with every name in it replaced."""
    refers = REFERS.get(type(item), {})
    changed = {}
    for field in item.model_fields_set:
        given = getattr(item, field)
        if given is not None:
            change = refers.get(field)
            changed[field] = change(names, given) if change else _inside(given, names)
    return item.model_copy(update=changed)


def _inside(given: Any, names: Names) -> Any:
    if isinstance(given, MissionModel):
        return renamed(given, names)
    if isinstance(given, tuple):
        return tuple(_inside(item, names) for item in given)
    if isinstance(given, dict):
        return {word: _inside(item, names) for word, item in given.items()}
    return given
