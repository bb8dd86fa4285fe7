# SPDX-License-Identifier: Apache-2.0
"""The parts of a mission, wherever they are in it."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeVar

from pydantic import BaseModel

from rai_missions.guards.guard import Guard
from rai_missions.model import MissionModel
from rai_missions.states import State
from rai_missions.states.effects import Set
from rai_missions.states.tree.leaves import SetLeaf

__all__ = ("guards_in", "inside", "own_parts", "parts", "texts_in", "writes_in")

Part = TypeVar("Part")


def inside(value: Any) -> Iterable[Any]:
    """What is directly inside a mission, or a part of it."""
    if isinstance(value, MissionModel):
        return [part for _, part in value.inside()]
    if isinstance(value, Mapping):
        return value.values()
    return value if isinstance(value, list | tuple) else ()


def parts(value: Any, kind: type[Part]) -> Iterator[Part]:
    """Every part of a mission, or of a part of it, that is of a kind; outermost first."""
    if isinstance(value, kind):
        yield value
    for part in inside(value):
        yield from parts(part, kind)


def guards_in(value: Any) -> Iterator[Guard]:
    """Every guard, those inside others included."""
    if isinstance(value, Guard):
        yield from value.walk()
        return
    for part in inside(value):
        yield from guards_in(part)


def own_parts(state: State | None) -> list[Any]:
    """What is written in a state, without the states inside it; nothing in the mission itself."""
    fields = type(state).model_fields if state is not None else ()
    return [getattr(state, field) for field in fields if field not in ("states", "parallel")]


def texts_in(value: Any, *, without: Callable[[BaseModel, str], bool] = lambda part, field: False) -> Iterator[str]:
    """Every text in a part of a mission, names in its mappings included.

    Args:
        value: The part.
        without: Whether a field of a model is left out.
    """
    if isinstance(value, str):
        yield value
    elif isinstance(value, BaseModel):
        for name, part in vars(value).items():
            if not without(value, name):
                yield from texts_in(part, without=without)
    elif isinstance(value, Mapping):
        for part in (*value, *value.values()):
            yield from texts_in(part, without=without)
    elif isinstance(value, list | tuple | set | frozenset):
        for part in value:
            yield from texts_in(part, without=without)


def writes_in(value: Any) -> Iterator[Set]:
    """Every effect that writes a key, those of trees included."""
    yield from parts(value, Set)
    for leaf in parts(value, SetLeaf):
        yield leaf.effect()
