# SPDX-License-Identifier: Apache-2.0
"""Walks all objects of a world and of its copy at once; it knows nothing of how a copy is made."""

from __future__ import annotations

import random
import threading
import types
from collections import deque
from collections.abc import Iterator
from typing import Any

import mujoco
import numpy as np

from rai_missions.worlds.branching import CONSTANT, fields_of, leads_out
from rai_missions.worlds.camera import Camera

__all__ = ("Walk", "faults")

LOCKS = (type(threading.Lock()), type(threading.RLock()))


def faults(one: Any, other: Any) -> list[str]:
    """Where a copy is not the same as a world, or shares something with it that may change."""
    return list(Walk().pair(one, other, "world"))


class Walk:
    """Both graphs of objects at once; it knows nothing of how a copy is made."""

    def __init__(self) -> None:
        self.twins: dict[int, Any] = {}
        self.kept: list[Any] = []
        self.cut: set[str] = set()

    def pair(self, one: Any, other: Any, path: str) -> Iterator[str]:
        if isinstance(one, CONSTANT):
            if type(one) is not type(other) or not (one is other or one == other or (one != one and other != other)):
                yield f"{path} is {other!r}, not {one!r}"
            return
        if id(one) in self.twins:
            if self.twins[id(one)] is not other and not isinstance(one, types.MethodType | tuple | frozenset):
                yield f"{path} is one object in the world and two in the branch"
            return
        self.twins[id(one)] = other
        self.kept += [one, other]
        if type(one) is not type(other):
            yield f"{path} is a {type(other).__name__}, not a {type(one).__name__}"
            return
        yield from self.inside(one, other, path)

    def inside(self, one: Any, other: Any, path: str) -> Iterator[str]:
        if one is other and not is_constant(one):
            yield f"{path} is shared: a {type(one).__name__}"
        elif isinstance(one, np.ndarray):
            yield from array(one, other, path)
        elif isinstance(one, mujoco.MjData | mujoco.MjModel):
            yield from arrays(one, other, path)
        elif isinstance(one, random.Random | np.random.Generator):
            if drawn(one) != drawn(other):
                yield f"{path} draws other numbers"
        elif isinstance(one, Camera):
            if (one.width, one.height) != (other.width, other.height):
                yield f"{path} takes pictures of another size"
            yield from self.pair(one.model, other.model, f"{path}.model")
        elif type(one) in LOCKS:
            return
        else:
            yield from self.parts(one, other, path)

    def parts(self, one: Any, other: Any, path: str) -> Iterator[str]:
        mine, theirs = self.children(one), self.children(other)
        if mine.keys() != theirs.keys():
            yield f"{path} has {sorted(mine.keys() ^ theirs.keys())} in only one of them"
            return
        for name, value in mine.items():
            if name in leads_out(type(one)):
                self.cut.add(f"{type(one).__name__}.{name}")
            else:
                yield from self.pair(value, theirs[name], f"{path}.{name}")

    def children(self, what: Any) -> dict[str, Any]:
        if isinstance(what, dict):
            return {f"[{key!r}]": value for key, value in what.items()} | {
                f".key{index}": key for index, key in enumerate(what)
            }
        if isinstance(what, list | tuple | deque):
            return {f"[{index}]": value for index, value in enumerate(what)}
        if isinstance(what, set | frozenset):
            return {f"[{index}]": value for index, value in enumerate(sorted(what, key=repr))}
        if isinstance(what, types.MethodType):
            return {"function": what.__func__, "self": what.__self__}
        if isinstance(what, types.FunctionType):
            cells = zip(what.__code__.co_freevars, what.__closure__ or (), strict=True)
            return {name: cell.cell_contents for name, cell in cells}
        return {name: getattr(what, name) for name in fields_of(what)}


def array(one: Any, other: Any, path: str) -> Iterator[str]:
    if one.tobytes() != other.tobytes() or one.shape != other.shape or one.dtype != other.dtype:
        yield f"{path} has other numbers"
    if np.shares_memory(one, other):
        yield f"{path} shares its memory"


def drawn(one: Any) -> str:
    return repr(one.getstate() if isinstance(one, random.Random) else one.bit_generator.state)


def arrays(one: Any, other: Any, path: str) -> Iterator[str]:
    """All arrays that MuJoCo has in a model or its state."""
    for name in dir(one):
        value = None if name.startswith("_") else attribute(one, name)
        if isinstance(value, np.ndarray) and value.size:
            yield from array(value, getattr(other, name), f"{path}.{name}")


def attribute(one: Any, name: str) -> Any:
    try:
        return getattr(one, name)
    except mujoco.FatalError:
        return None


def is_constant(one: Any) -> bool:
    """Of what may be shared although it is no `CONSTANT`: it holds nothing."""
    if isinstance(one, types.FunctionType):
        return not one.__closure__
    return isinstance(one, tuple | frozenset) and all(isinstance(each, CONSTANT) for each in one)
