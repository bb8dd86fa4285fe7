# SPDX-License-Identifier: Apache-2.0
"""Whether the code of a kind can be pure: a guard or activity of another package reads what it is given, and no more.

Rule: this refuses what is plainly impure, by its name; it is no sandbox. What it looks at is the code itself, never a
run of it: every function of the kind, and every function and class of the same package that one of them uses.
"""

from __future__ import annotations

import builtins
import dis
import inspect
import sys
from collections.abc import Iterator
from functools import cached_property
from pathlib import Path
from types import CodeType, FunctionType, ModuleType
from typing import Any

__all__ = ("impurity",)

PURE = frozenset((
    "__future__", "abc", "bisect", "builtins", "cmath", "collections", "copy", "dataclasses", "decimal", "enum",
    "fractions", "functools", "heapq", "itertools", "json", "math", "numbers", "operator", "re", "statistics", "string",
    "textwrap", "types", "typing",
))  # fmt: skip
"""Modules of Python whose functions give the same for the same; every other one of Python's is refused."""
READS = frozenset((
    "breakpoint", "compile", "eval", "exec", "globals", "hash", "id", "input", "open", "print", "__import__", "vars",
    "locals",
))  # fmt: skip
"""Built-in functions that do more than that, or differ from process to process."""
SOURCES = {
    "time": "the clock", "datetime": "the clock", "random": "chance", "secrets": "chance", "uuid": "chance",
    "os": "the system", "pathlib": "files", "io": "files", "open": "files", "socket": "the network",
    "urllib": "the network", "http": "the network", "subprocess": "other programs", "threading": "other threads",
}  # fmt: skip
UNCALLED = ("__annotate_func__", "__hash__", "__repr__", "__setattr__", "__delattr__")
"""What a class has for other uses than to be evaluated, and Python makes for it."""
FOREIGN = frozenset(("numpy.random", "requests", "httpx", "rclpy", "paho"))


def impurity(kind: type[Any]) -> str:
    """What the code of a kind uses that depends on more than what it is given; empty where nothing is found."""
    home = kind.__module__.partition(".")[0]
    seen: set[int] = set()
    rest: list[Any] = [kind]
    while rest:
        thing = rest.pop()
        if id(thing) in seen:
            continue
        seen.add(id(thing))
        if isinstance(thing, type):
            rest += _members(thing, home)
        elif isinstance(thing, FunctionType) and thing.__module__.partition(".")[0] == home:
            for place, name, used in _uses(thing):
                if why := _impure(name, used):
                    return f"it is impure: {place} uses {why}"
                rest.append(used)
    return ""


def _members(kind: type[Any], home: str) -> Iterator[Any]:
    """The functions of a class and of those of its package that it derives from."""
    for each in kind.__mro__:
        if each.__module__.partition(".")[0] == home:
            yield from (_function_in(member) for name, member in list(vars(each).items()) if name not in UNCALLED)


def _function_in(member: Any) -> Any:
    """The function that a member of a class evaluates; None for any other member."""
    if isinstance(member, staticmethod | classmethod):
        return member.__func__
    if isinstance(member, property):
        return member.fget
    if isinstance(member, cached_property):
        return member.func
    return inspect.unwrap(member) if isinstance(member, FunctionType) else None


def _uses(function: FunctionType) -> Iterator[tuple[str, str, Any]]:
    """What a function and those inside it use: where in its file, by which name, and the thing."""
    for code in _codes(function.__code__):
        file = Path(code.co_filename).name
        yield from ((f"{file}:{line}", name, used) for line, name, used in _used(code, function))


def _codes(code: CodeType) -> Iterator[CodeType]:
    """A function's code and that of the functions inside it."""
    yield code
    for each in code.co_consts:
        if isinstance(each, CodeType):
            yield from _codes(each)


def _used(code: CodeType, function: FunctionType) -> Iterator[tuple[int, str, Any]]:
    """What code refers to by name: globals, what it imports, and attributes of modules and classes."""
    closed = inspect.getclosurevars(function).nonlocals if code is function.__code__ else {}
    line = code.co_firstlineno
    last: Any = None
    for step in dis.get_instructions(code):
        line = (step.positions.lineno if step.positions is not None else None) or line
        name, before, last = str(step.argval), last, None
        if step.opname == "IMPORT_NAME":
            yield line, name, sys.modules.get(name) or ModuleType(name)
        elif step.opname in REBINDS or (step.opname in SETS and code.co_name not in MAKING):
            yield line, name, REBOUND
        elif step.opname in ("LOAD_GLOBAL", "LOAD_NAME"):
            last = function.__globals__.get(name, getattr(builtins, name, None))
            yield line, name, last
        elif step.opname in ("LOAD_ATTR", "LOAD_METHOD") and isinstance(before, ModuleType | type):
            last = getattr(before, name, None)
            yield line, name, getattr(last, "__func__", last)
        elif step.opname == "LOAD_DEREF" and name in closed:
            yield line, name, closed[name]
        elif step.opname in ("PUSH_NULL", "PRECALL", "CACHE"):
            last = before


REBINDS, SETS = ("STORE_GLOBAL", "DELETE_GLOBAL"), ("STORE_ATTR", "DELETE_ATTR")
MAKING = ("__init__", "__new__", "__post_init__")
REBOUND = object()
"""A global name, or an attribute, that a function gives another value."""


def _impure(name: str, used: Any) -> str:
    """What of the world something depends on, in words; empty if it may be used."""
    if used is REBOUND or isinstance(used, list | dict | set | bytearray):
        return f"'{name}', which can change between two looks; keep what is constant in a tuple or a frozenset"
    owner = getattr(used, "__self__", None)  # `random.random` is a method of a generator
    module = used.__name__ if isinstance(used, ModuleType) else getattr(used, "__module__", None) or ""
    if owner is not None and not isinstance(owner, ModuleType | type):
        module = type(owner).__module__
    if module in ("builtins", "io", "_io"):
        what = getattr(used, "__name__", name)
        return f"'{what}'" + _of(what) if what in READS else ""
    root = module.lstrip("_").partition(".")[0]
    is_pythons = module.partition(".")[0] in sys.stdlib_module_names and root not in PURE
    if is_pythons or any(f"{module}.".startswith(f"{each}.") for each in FOREIGN):
        public = module.partition("._")[0]  # what is public may be defined in a private module of the same package
        return f"'{public}'" + _of(root)
    return ""


def _of(root: str) -> str:
    return f" ({SOURCES[root]})" if root in SOURCES else ""
