# SPDX-License-Identifier: Apache-2.0
"""A mission as text, one thing a line, for tools that compare lines.

Rule: two missions have the same text where they are the same but for the order in which things are named, else not.
"""

from __future__ import annotations

import json
from collections.abc import Iterator, Mapping
from typing import Any

from rai_missions.guards import Compare, Guard
from rai_missions.mission.mission import Mission
from rai_missions.model import MissionModel
from rai_missions.states import Transition
from visualize.style import clean

__all__ = ("outline",)

INDENT = "  "


def outline(mission: Mission) -> str:
    """The text."""
    return "\n".join([*(clean(line) for line in _fields(mission, "")), ""])


def _fields(item: MissionModel, indent: str) -> Iterator[str]:
    """What is written in a thing, in the order of its kind's fields."""
    for name, field in type(item).model_fields.items():
        value = getattr(item, name)
        if name == "transitions" or value != field.get_default(call_default_factory=True):
            yield from _value(field.alias or name, value, indent)


def _value(word: str, value: Any, indent: str) -> Iterator[str]:
    if isinstance(value, Guard):
        yield f"{indent}{word}: {_guard(value)}"
    elif isinstance(value, Transition):
        yield f"{indent}transition {_trigger(value)}"
        yield from (
            line for field in ("when", "do", "internal", "about") for line in _part(value, field, indent + INDENT)
        )
    elif isinstance(value, MissionModel):
        kind = getattr(value, "word", "")
        yield f"{indent}{word}:" + (f" {kind}" if kind and kind != word else "")
        yield from _fields(value, indent + INDENT)
    elif isinstance(value, Mapping) and any(isinstance(each, MissionModel) for each in value.values()):
        yield f"{indent}{word}:"
        for name in sorted(value):
            yield from _value(name, value[name], indent + INDENT)
    elif isinstance(value, tuple) and any(isinstance(each, MissionModel) for each in value):
        for each in value:
            yield from _value(word, each, indent)
    elif value != () or word != "transitions":
        yield f"{indent}{word}: {_json(value)}"


def _part(transition: Transition, field: str, indent: str) -> Iterator[str]:
    value = getattr(transition, field)
    if value != type(transition).model_fields[field].get_default(call_default_factory=True):
        yield from _value(field, value, indent)


def _trigger(transition: Transition) -> str:
    words = (
        f"after {_json(transition.after_s)} s"
        if transition.after_s is not None
        else "on " + ", ".join(transition.on)
        if transition.on
        else "now"
    )
    of = f" of {transition.of}" if transition.of else ""
    return f"{words}{of} → {', '.join(transition.to)}" if transition.to else f"{words}{of}, stays"


def _guard(guard: Guard) -> str:
    """In words where they are exact; a text in them could be taken for a number or a key."""
    plain = all(
        isinstance(each.operand, bool | int | float) for each in guard.walk() if isinstance(each, Compare)
    ) and not any(each.predicates() for each in guard.walk())
    return guard.words() if plain else _json(guard.written())


def _json(value: Any) -> str:
    return json.dumps(value, sort_keys=True, ensure_ascii=False, default=_other)


def _other(value: Any) -> Any:
    return getattr(value, "__qualname__", str(value))
