# SPDX-License-Identifier: Apache-2.0
"""What the fields of written things refer to: names, paths and templates, found by their annotations.

Rule: nothing lists fields by name. A field that refers to something carries a `Refers`; what it holds of further
written things is found by its type.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from functools import cache
from types import UnionType
from typing import Annotated, Any, Literal, NamedTuple, Union, get_args, get_origin

from rai_missions.errors import escaped

__all__ = (
    "EVENT", "HELD", "INTERFACES", "KEY", "OPERAND", "OPERAND_WORDS", "PATH", "STATE", "TEMPLATE", "TIMER", "TRIGGER",
    "FieldUse", "Interface", "KeyValue", "OneOrMany", "Reference", "Refers", "fields_of", "found", "inside",
    "reference_word", "rewritten", "template_paths", "template_words", "written_keys",
)  # fmt: skip

Interface = Literal["action", "service", "topic"]
"""What a robot's profile names."""
Sort = Literal["state", "key", "event", "timer", "trigger", "path", "template", "operand", "predicate", Interface]
INTERFACES: tuple[Interface, ...] = get_args(Interface)


@dataclass(frozen=True, slots=True)
class Refers:
    """Part of a field's annotation: what the text there refers to."""

    sort: Sort
    """`path`: a key or a field of one; `template`: a JSON value in which `{"from": path}` is replaced by a value;
    `operand`: a value, or another key as `{"key": path}`; `trigger`: events, outcomes and options."""
    written: str = ""
    """For a key that is written here, by what: `result`, `each`, `set` or `status`; empty where it is read."""


class OneOrMany:
    """In a field's annotation: a list of one may be written as its item, and has its place."""


STATE, KEY, EVENT, TIMER = Refers("state"), Refers("key"), Refers("event"), Refers("timer")
PATH, TEMPLATE, OPERAND, TRIGGER = Refers("path"), Refers("template"), Refers("operand"), Refers("trigger")


class Reference(NamedTuple):
    """A name that a written thing refers to; left out are the words of a `trigger`, which are of several sorts."""

    refers: Refers
    """Of a `template` or an `operand`, the paths in it: `path`."""
    name: Any
    place: str
    """The JSON pointer of the name."""


class KeyValue(NamedTuple):
    """A key of the mission that a written thing writes, and with what."""

    key: str
    place: str
    """The JSON pointer of the key's name; for `set`, `add` and `from` that of the effect."""
    by: str
    """`set`, `add`, `from`, `result`, `each`, or `status` for what a tree's node reports."""
    value: Any = None
    """The constant, the number added, or the path."""


class FieldUse(NamedTuple):
    """A field that refers to something, or holds written things."""

    name: str
    word: str
    """As JSON has it."""
    hint: Any


@dataclass(frozen=True, slots=True)
class _ListHint:
    item: Any
    one_or_many: bool = False


@dataclass(frozen=True, slots=True)
class _MapHint:
    word: Any
    item: Any


HELD = "held"
"""The hint of a written thing."""


def fields_of(kind: Any) -> tuple[FieldUse, ...]:
    """The fields of a kind that refer to something or hold written things, in their order."""
    return _fields_of(kind)  # for type checkers a class is no argument of a cached function


@cache
def _fields_of(kind: Any) -> tuple[FieldUse, ...]:
    uses = []
    for name, field in kind.model_fields.items():
        marked = [each for each in field.metadata if isinstance(each, Refers)]
        hint = marked[0] if marked else _hint(field.annotation)
        if isinstance(hint, _ListHint):
            hint = _ListHint(hint.item, any(isinstance(each, OneOrMany) for each in field.metadata))
        if hint is not None:
            uses.append(FieldUse(name, field.alias or name, hint))
    return tuple(uses)


@cache
def _naming_fields(kind: Any) -> tuple[FieldUse, ...]:
    """The fields that refer to something of one sort; the words of a trigger are of several sorts."""
    return tuple(use for use in _fields_of(kind) if any(_is_named(each) for each in _parts(use.hint)))


def _is_named(hint: Any) -> bool:
    return isinstance(hint, Refers) and hint.sort != "trigger"


@cache
def _written_fields(kind: Any) -> tuple[FieldUse, ...]:
    """The fields that name keys as written."""
    return tuple(use for use in _naming_fields(kind) if any(getattr(each, "written", "") for each in _parts(use.hint)))


@cache
def _holding_fields(kind: Any) -> tuple[FieldUse, ...]:
    """The fields that hold written things."""
    return tuple(use for use in _fields_of(kind) if HELD in _parts(use.hint))


def _parts(hint: Any) -> Iterator[Any]:
    """What the values of a hint are made of: each a `Refers`, `HELD`, or None."""
    if isinstance(hint, _MapHint):
        yield from (*_parts(hint.word), *_parts(hint.item))
    elif isinstance(hint, _ListHint):
        yield from _parts(hint.item)
    else:
        yield hint


def _hint(annotation: Any) -> Any:
    """What the values of a type refer to or hold; None for plain ones."""
    origin, given = get_origin(annotation), get_args(annotation)
    if origin is Annotated:
        return next((each for each in annotation.__metadata__ if isinstance(each, Refers)), None) or _hint(given[0])
    if origin in (Union, UnionType):
        return next((hint for each in given if (hint := _hint(each)) is not None), None)
    if origin is tuple:
        item = _hint(given[0])
        return None if item is None else _ListHint(item)
    if origin is dict:
        word, item = map(_hint, given)
        return None if word is None and item is None else _MapHint(word, item)
    return HELD if hasattr(annotation, "model_fields") else None


def found(thing: Any, place: str = "") -> Iterator[Reference]:
    """What a written thing itself refers to; not what is referred to by the things inside it."""
    kind: Any = type(thing)
    uses = _naming_fields(kind)
    return iter(_found(thing, uses, place) if uses else ())


def written_keys(thing: Any, place: str) -> Iterator[KeyValue]:
    """The mission's keys that the fields of a written thing name as written."""
    kind: Any = type(thing)
    if not (uses := _written_fields(kind)):
        return iter(())
    return (KeyValue(name, here, refers.written) for refers, name, here in _found(thing, uses, place) if refers.written)


def _found(thing: Any, uses: Iterable[FieldUse], place: str) -> list[Reference]:
    into: list[Reference] = []
    for name, word, hint in uses:
        given = getattr(thing, name)
        if given or (given is not None and isinstance(hint, Refers)):  # most lists of most things are empty
            _find(given, hint, f"{place}/{word}", into)
    return into


def _find(given: Any, hint: Any, place: str, into: list[Reference]) -> None:
    if isinstance(hint, Refers):
        if hint.sort == "template":
            into += (Reference(PATH, path, here) for path, here in template_paths(given, place))
        elif hint.sort != "operand":
            into.append(Reference(hint, given, place))
        elif (word := reference_word(given, OPERAND_WORDS)) is not None:
            into.append(Reference(PATH, given[word], f"{place}/{word}"))
    elif isinstance(hint, _ListHint):
        bare = hint.one_or_many and len(given) == 1
        if bare and isinstance(hint.item, Refers) and hint.item.sort not in ("template", "operand"):
            into.append(Reference(hint.item, given[0], place))
            return
        for index, item in enumerate(given):
            _find(item, hint.item, place if bare else f"{place}/{index}", into)
    elif isinstance(hint, _MapHint):
        for word, item in given.items():
            here = f"{place}/{escaped(word)}"
            _find(word, hint.word, here, into)
            _find(item, hint.item, here, into)


def template_paths(template: Any, place: str = "") -> Iterator[tuple[str, str]]:
    """The paths that a template takes values from, each with its JSON pointer."""
    if reference_word(template) is not None:
        yield template["from"], f"{place}/from"
    elif isinstance(template, Mapping):
        for word, item in template.items():
            yield from template_paths(item, f"{place}/{escaped(word)}")
    elif isinstance(template, list | tuple):
        for index, item in enumerate(template):
            yield from template_paths(item, f"{place}/{index}")


OPERAND_WORDS = ("key", "from")


def template_words(template: Any) -> str:
    """A goal, request, message or value: `pose ← target, speed 1.2`; objects of a list: `[x 1, y 2; x 3, y 4]`."""
    if reference_word(template) is not None:
        return f"← {template['from']}"
    if isinstance(template, Mapping):
        return ", ".join(f"{name} {template_words(item)}" for name, item in template.items())
    if isinstance(template, list | tuple):
        between = "; " if any(isinstance(item, Mapping) for item in template) else ", "
        return "[" + between.join(map(template_words, template)) + "]"
    if template is None:
        return "null"
    return str(template).lower() if isinstance(template, bool) else str(template)


def reference_word(value: Any, words: tuple[str, ...] = ("from",)) -> str | None:
    """The word of a value that is but a path, as in `{"from": path}`; None for any other value."""
    word = next(iter(value), None) if isinstance(value, Mapping) and len(value) == 1 else None
    return word if word in words and isinstance(value[word], str) else None


def inside(thing: Any, place: str = "") -> Iterator[tuple[str, Any]]:
    """The written things directly inside one, each with its JSON pointer."""
    kind: Any = type(thing)
    into: list[tuple[str, Any]] = []
    for name, word, hint in _holding_fields(kind):
        given = getattr(thing, name)
        if (given is not None) if hint is HELD else given:
            _gather(given, hint, f"{place}/{word}", into)
    return iter(into)


def _gather(given: Any, hint: Any, place: str, into: list[tuple[str, Any]]) -> None:
    if hint is HELD:
        into.append((place, given))
    elif isinstance(hint, _ListHint):
        for index, item in enumerate(given):
            _gather(item, hint.item, f"{place}/{index}", into)
    elif isinstance(hint, _MapHint):
        for word, item in given.items():
            _gather(item, hint.item, f"{place}/{escaped(word)}", into)


def rewritten(given: Any, hint: Any, change: Callable[[Sort, Any], Any]) -> Any:
    """A value with what it refers to changed, that of written things inside it too.

    Args:
        given: The value of a field, or a written thing.
        hint: The hint of its annotation.
        change: Takes the sort and the name: `state`, `key`, `event`, `timer`, `trigger` or `path`.
    """
    if given is None:
        return None
    if isinstance(hint, Refers):
        return _referring(given, hint.sort, change)
    if isinstance(hint, _ListHint):
        return tuple(rewritten(item, hint.item, change) for item in given)
    if isinstance(hint, _MapHint):
        return {rewritten(word, hint.word, change): rewritten(item, hint.item, change) for word, item in given.items()}
    if hint is None:
        return given
    uses = (use for use in fields_of(type(given)) if use.name in given.model_fields_set)
    return given.model_copy(update={use.name: rewritten(getattr(given, use.name), use.hint, change) for use in uses})


def _referring(given: Any, sort: Sort, change: Callable[[Sort, Any], Any]) -> Any:
    if sort not in ("template", "operand"):
        return change(sort, given)
    word = reference_word(given, OPERAND_WORDS if sort == "operand" else ("from",))
    if word is not None:
        return {word: change("path", given[word])}
    if sort == "template" and isinstance(given, Mapping):
        return {name: _referring(item, sort, change) for name, item in given.items()}
    if sort == "template" and isinstance(given, list | tuple):
        return [_referring(item, sort, change) for item in given]
    return given
