# SPDX-License-Identifier: Apache-2.0
"""What the fields of a written thing refer to, as their annotations say: states, keys, events, timers, paths.

Rule: nothing lists fields by name. A field that refers to something carries a `Refers`; what it holds of further
written things is found by its type.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from types import UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

__all__ = (
    "EVENT", "HELD", "KEY", "OPERAND", "PATH", "STATE", "TEMPLATE", "TIMER", "TRIGGER", "FieldUse", "Reference",
    "Refers", "escaped", "fields_of", "found", "inside", "rewritten",
)  # fmt: skip

Sort = Literal["state", "key", "event", "timer", "trigger", "path", "template", "operand", "predicate"]


@dataclass(frozen=True, slots=True)
class Refers:
    """Stands in a field's annotation: what the text there refers to."""

    sort: Sort
    """`path`: a key or a field of one; `template`: a JSON value in which `{"from": path}` stands for a value;
    `operand`: a value, or another key as `{"key": path}`; `trigger`: events, outcomes and options."""
    written: str = ""
    """For a key that is written here, by what: `result`, `each`, `set` or `status`; empty where it is read."""


STATE, KEY, EVENT, TIMER = Refers("state"), Refers("key"), Refers("event"), Refers("timer")
PATH, TEMPLATE, OPERAND, TRIGGER = Refers("path"), Refers("template"), Refers("operand"), Refers("trigger")


class Reference(NamedTuple):
    """A name that a written thing refers to."""

    refers: Refers
    """Of a `template` or an `operand`, the paths in it: `path`."""
    name: Any
    """The name, or the names of a `trigger`."""
    place: str
    """The JSON pointer of the name."""


class FieldUse(NamedTuple):
    """A field that refers to something, or holds written things."""

    name: str
    word: str
    """As JSON has it."""
    hint: Any


@dataclass(frozen=True, slots=True)
class _Listed:
    item: Any


@dataclass(frozen=True, slots=True)
class _Worded:
    word: Any
    item: Any


HELD = "held"
"""The hint of a written thing."""


def fields_of(kind: Any) -> tuple[FieldUse, ...]:
    """The fields of a kind that refer to something or hold written things, in their order."""
    return _fields_of(kind)


@cache
def _fields_of(kind: Any) -> tuple[FieldUse, ...]:
    uses = []
    for name, field in kind.model_fields.items():
        marked = [each for each in field.metadata if isinstance(each, Refers)]
        hint = marked[0] if marked else _hint(field.annotation)
        if hint is not None:
            uses.append(FieldUse(name, field.alias or name, hint))
    return tuple(uses)


def _hint(annotation: Any) -> Any:
    """What a type says of its values; None for plain ones."""
    origin, given = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return next((each for each in annotation.__metadata__ if isinstance(each, Refers)), None) or _hint(given[0])
    if origin in (Union, UnionType):
        return next((hint for each in given if (hint := _hint(each)) is not None), None)
    if origin is tuple:
        item = _hint(given[0])
        return None if item is None else _Listed(item)
    if origin is dict:
        word, item = map(_hint, given)
        return None if word is None and item is None else _Worded(word, item)
    return HELD if hasattr(annotation, "model_fields") else None


def escaped(word: object) -> str:
    """A step of a JSON pointer (RFC 6901)."""
    return str(word).replace("~", "~0").replace("/", "~1")


def found(thing: Any, place: str = "") -> Iterator[Reference]:
    """What a written thing itself refers to; not what is referred to by the things inside it."""
    for use in fields_of(type(thing)):
        given = getattr(thing, use.name)
        if given is not None and use.hint is not HELD:
            yield from _found(given, use.hint, f"{place}/{use.word}")


def _found(given: Any, hint: Any, place: str) -> Iterator[Reference]:
    if isinstance(hint, Refers):
        if hint.sort == "template":
            yield from (Reference(PATH, path, here) for path, here in _paths(given, place))
        elif hint.sort != "operand":
            yield Reference(hint, given, place)
        elif (word := _other(given)) is not None:
            yield Reference(PATH, given[word], f"{place}/{word}")
    elif isinstance(hint, _Listed):
        for index, item in enumerate(given):
            yield from _found(item, hint.item, f"{place}/{index}")
    elif isinstance(hint, _Worded):
        for word, item in given.items():
            here = f"{place}/{escaped(word)}"
            yield from _found(word, hint.word, here)
            yield from _found(item, hint.item, here)


def _paths(template: Any, place: str) -> Iterator[tuple[str, str]]:
    if isinstance(template, Mapping):
        if len(template) == 1 and isinstance(template.get("from"), str):
            yield template["from"], f"{place}/from"
        else:
            for word, item in template.items():
                yield from _paths(item, f"{place}/{escaped(word)}")
    elif isinstance(template, list | tuple):
        for index, item in enumerate(template):
            yield from _paths(item, f"{place}/{index}")


def _other(operand: Any) -> str | None:
    """The word under which an operand names another key, where it does."""
    if isinstance(operand, Mapping) and len(operand) == 1:
        word, value = next(iter(operand.items()))
        return word if word in ("key", "from") and isinstance(value, str) else None
    return None


def inside(thing: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """The written things directly inside one, each with its JSON pointer."""
    for use in fields_of(type(thing)):
        given = getattr(thing, use.name)
        if given is not None and not isinstance(use.hint, Refers):
            yield from _inside(given, use.hint, f"{place}/{use.word}")


def _inside(given: Any, hint: Any, place: str) -> Iterator[tuple[str, Any]]:
    if hint is HELD:
        yield place, given
    elif isinstance(hint, _Listed):
        for index, item in enumerate(given):
            yield from _inside(item, hint.item, f"{place}/{index}")
    elif isinstance(hint, _Worded):
        for word, item in given.items():
            yield from _inside(item, hint.item, f"{place}/{escaped(word)}")


def rewritten(given: Any, hint: Any, change: Callable[[Sort, Any], Any]) -> Any:
    """A value with what it refers to changed, that of written things inside it too.

    Args:
        given: The value of a field, or a written thing.
        hint: What its annotation says.
        change: Takes the sort and the name: `state`, `key`, `event`, `timer`, `trigger` or `path`.
    """
    if given is None:
        return None
    if isinstance(hint, Refers):
        return _referring(given, hint.sort, change)
    if isinstance(hint, _Listed):
        return tuple(rewritten(item, hint.item, change) for item in given)
    if isinstance(hint, _Worded):
        return {rewritten(word, hint.word, change): rewritten(item, hint.item, change) for word, item in given.items()}
    if hint is None:
        return given
    uses = (use for use in fields_of(type(given)) if use.name in given.model_fields_set)
    return given.model_copy(update={use.name: rewritten(getattr(given, use.name), use.hint, change) for use in uses})


def _referring(given: Any, sort: Sort, change: Callable[[Sort, Any], Any]) -> Any:
    if sort == "template":
        if isinstance(given, Mapping):
            if len(given) == 1 and isinstance(given.get("from"), str):
                return {"from": change("path", given["from"])}
            return {word: _referring(item, sort, change) for word, item in given.items()}
        return [_referring(item, sort, change) for item in given] if isinstance(given, list | tuple) else given
    if sort == "operand":
        word = _other(given)
        return given if word is None else {word: change("path", given[word])}
    return change(sort, given)
