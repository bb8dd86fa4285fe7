# SPDX-License-Identifier: Apache-2.0
"""A second world where one is: every object that a world reaches, copied as a value.

Rule: nothing is shared but what can never change. A field that leads out of the world is listed by its class, in
`LEADS_OUT`; what is no value is brought to the same place by `resume_copy`; a kind of object that is not known here is
refused with its path, so that a thread, a file or a connection never gets into a copy by accident.
"""

from __future__ import annotations

import copy
import enum
import functools
import random
import threading
import types
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Mapping
from typing import Any, TypeVar

import mujoco
import numpy as np

from rai_missions.errors import UsageError
from rai_missions.worlds.camera import Camera

__all__ = ("CONSTANT", "branched", "fields_of", "leads_out")

T = TypeVar("T")
Copy = Callable[[Any, str], Any]

OURS = ("rai_missions.worlds.", "rai_missions.planning.", "rai_missions.image")
"""Modules whose objects are copied field by field."""
CONSTANT = (
    type(None),
    bool,
    int,
    float,
    complex,
    str,
    bytes,
    range,
    type,
    types.ModuleType,
    types.BuiltinFunctionType,
    np.generic,
    np.dtype,
    enum.Enum,
)
"""Kinds whose values never change."""
LOCK, RLOCK = type(threading.Lock()), type(threading.RLock())


class Copier:
    """One branching: each object once, however many refer to it."""

    def __init__(self) -> None:
        self._made: dict[int, Any] = {}
        self._kept: list[Any] = []
        """What was looked at, so that no identity is used again meanwhile."""
        self.unfinished: list[Any] = []
        """What has to be brought to its place once everything is copied."""

    def copy(self, what: Any, path: str) -> Any:
        if id(what) in self._made:
            return self._made[id(what)]
        if isinstance(what, CONSTANT):
            return what
        self._kept.append(what)
        return self._of_kind(what, path)

    def _of_kind(self, what: Any, path: str) -> Any:
        kind = type(what)
        if kind in COPIES:
            return self._keep(what, COPIES[kind](what, path, self.copy))
        if isinstance(what, types.FunctionType):
            return self._function(what, path)
        if isinstance(what, list | set | dict | deque):
            return self._container(what, path)
        if isinstance(what, tuple | frozenset):
            return what if is_constant(what) else self._keep(what, self._fixed(what, path))
        if f"{kind.__module__}.".startswith(OURS):
            return self._object(what, path)
        raise UsageError(f"the world cannot be branched: {path} is a {kind.__module__}.{kind.__qualname__}")

    def _keep(self, what: Any, made: Any) -> Any:
        return self._made.setdefault(id(what), made)

    def _container(self, what: Any, path: str) -> Any:
        """What may contain itself: it is known before its content is copied."""
        if isinstance(what, dict):
            made: Any = self._keep(what, type(what)())
            for key, value in what.items():
                made[self.copy(key, f"{path}.key")] = self.copy(value, f"{path}[{key!r}]")
            return made
        made = self._keep(what, deque(maxlen=what.maxlen) if isinstance(what, deque) else type(what)())
        add = made.add if isinstance(what, set) else made.append
        for index, each in enumerate(what):
            add(self.copy(each, f"{path}[{index}]"))
        return made

    def _function(self, what: types.FunctionType, path: str) -> Any:
        """A function with what it has closed over; one that has closed over nothing is a constant."""
        if not what.__closure__:
            return what
        cells = tuple(types.CellType() for _ in what.__closure__)
        made = types.FunctionType(what.__code__, what.__globals__, what.__name__, what.__defaults__, cells)
        made.__kwdefaults__ = what.__kwdefaults__
        self._keep(what, made)  # it may have closed over itself
        for name, mine, theirs in zip(what.__code__.co_freevars, cells, what.__closure__, strict=True):
            mine.cell_contents = self.copy(theirs.cell_contents, f"{path}.{name}")
        return made

    def _fixed(self, what: Any, path: str) -> Any:
        each = [self.copy(one, f"{path}[{index}]") for index, one in enumerate(what)]
        return type(what)._make(each) if hasattr(what, "_make") else type(what)(each)

    def _object(self, what: Any, path: str) -> Any:
        made = self._keep(what, object.__new__(type(what)))
        if hasattr(made, "resume_copy"):
            self.unfinished.append(made)
        outside = leads_out(type(what))
        for name in fields_of(what):
            cut = outside.get(name)
            value = cut() if cut is not None else self.copy(getattr(what, name), f"{path}.{name}")
            object.__setattr__(made, name, value)
        return made


def is_constant(what: tuple[Any, ...] | frozenset[Any]) -> bool:
    """Whether it holds nothing that changes."""
    return all(isinstance(each, CONSTANT) for each in what)


def leads_out(kind: type) -> Mapping[str, Callable[[], Any]]:
    """The fields of a kind of object that lead out of the world, each with what makes the copy's own value."""
    found: Mapping[str, Callable[[], Any]] = getattr(kind, "LEADS_OUT", {})
    return found


def fields_of(what: Any) -> Iterator[str]:
    """The names of all fields that an object has."""
    yield from getattr(what, "__dict__", ())
    for kind in type(what).__mro__:
        names: Iterable[str] = kind.__dict__.get("__slots__", ())
        yield from (name for name in ((names,) if isinstance(names, str) else names) if hasattr(what, name))


def _array(what: Any, path: str, copy_of: Copy) -> Any:
    if what.dtype.hasobject or not isinstance(_owner(what), np.ndarray | bytes):
        raise UsageError(f"the world cannot be branched: {path} is a view of memory that is not its own")
    made = what.copy(order="K")
    made.setflags(write=what.flags.writeable)
    return made


def _owner(array: Any) -> Any:
    """Whose memory an array shows: its own, another array's, or something else's."""
    while isinstance(array, np.ndarray) and array.base is not None:
        array = array.base
    return array


def _random(what: random.Random, path: str, copy_of: Copy) -> random.Random:
    made = random.Random()
    made.setstate(what.getstate())
    return made


def _partial(what: Any, path: str, copy_of: Copy) -> Any:
    arguments = copy_of(what.args, f"{path}.args")
    return functools.partial(copy_of(what.func, f"{path}.func"), *arguments, **copy_of(what.keywords, f"{path}.words"))


def _data(what: Any, path: str, copy_of: Copy) -> Any:
    """The whole physical state, contacts and the solver's warm start included."""
    model = copy_of(what.model, f"{path}.model")
    made = mujoco.MjData(model)
    mujoco.mj_copyData(made, model, what)
    return made


COPIES: Mapping[type, Callable[[Any, str, Copy], Any]] = {
    np.ndarray: _array,
    np.random.Generator: lambda what, path, copy_of: copy.deepcopy(what),
    random.Random: _random,
    types.MethodType: lambda what, path, copy_of: types.MethodType(what.__func__, copy_of(what.__self__, path)),
    functools.partial: _partial,
    mujoco.MjData: _data,
    mujoco.MjModel: lambda what, path, copy_of: copy.copy(what),
    LOCK: lambda what, path, copy_of: threading.Lock(),
    RLOCK: lambda what, path, copy_of: threading.RLock(),
    Camera: lambda what, path, copy_of: what.twin(copy_of(what.model, f"{path}.model")),
}
"""Kind → what makes another one of the same value, given the first, its path and what copies what it refers to."""


def branched(what: T, name: str = "world") -> T:
    """An exact copy of an object and of all that it reaches.

    Args:
        what: The object.
        name: What paths in messages begin with.

    Raises:
        UsageError: Something is reached that is not known to be copied exactly; the message has its path.
    """
    copier = Copier()
    made: T = copier.copy(what, name)
    for each in copier.unfinished:
        each.resume_copy()
    return made
