# SPDX-License-Identifier: Apache-2.0
"""Steps as JSON, and back, exactly: `decode(encode(step)) == step`.

Rule: how a field is written follows from its type, so a new field of a Step needs no change here; a field that is left
out has its default.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from functools import cache
from types import UnionType
from typing import Any, Literal, NamedTuple, Union, cast, get_args, get_origin, get_type_hints

from rai_missions.engine.decision import Evidence
from rai_missions.engine.description import effect_word
from rai_missions.engine.step import Step
from rai_missions.errors import UsageError
from rai_missions.journal.json_values import Fetch, Keep, from_json, keep_nothing, to_json
from rai_missions.redaction import cut_repr

__all__ = ("decode", "encode", "form_of", "wrong")

Writer = Callable[[Any, Keep], Any]
Reader = Callable[[Any, Fetch], Any]


class FieldCodec(NamedTuple):
    """How one field is written and read."""

    write: Writer
    read: Reader


def wrong(value: Any, wanted: str) -> ValueError:
    """The error for a value where another belongs."""
    return ValueError(f"{cut_repr(value, 60)} is given where {wanted} belongs")


def as_it_is(value: Any, _: object) -> Any:
    """How what JSON has is written, and read."""
    return value


def _without_bytes(value: Any, _: object) -> Any:
    """How any value is written; a picture in it is a reference alone."""
    return to_json(value)


def _listed(value: Any, _: object) -> Any:
    """How items that JSON has are written."""
    return list(value)


def _typed(*kinds: type) -> FieldCodec:
    """A value of certain types: who altered a journal may have written another."""

    def checked(value: Any, written: Any) -> Any:
        if type(value) not in kinds:
            raise wrong(written, " or ".join(kind.__name__ for kind in kinds))
        return value

    def read(value: Any, _: Fetch) -> Any:
        return value if type(value) in kinds else checked(value, value)

    def read_coded(value: Any, fetch: Fetch) -> Any:
        return checked(from_json(value, fetch), value)

    is_coded = not {float, dict}.isdisjoint(kinds)
    return FieldCodec(_without_bytes, read_coded) if is_coded else FieldCodec(as_it_is, read)


def _list_of(form: FieldCodec) -> FieldCodec:
    def write(value: Any, keep: Keep) -> Any:
        return [form.write(item, keep) for item in value]

    def read(value: Any, fetch: Fetch) -> Any:
        if not isinstance(value, list):
            raise wrong(value, "a list")
        return tuple([form.read(item, fetch) for item in value])

    return FieldCodec(_listed if form.write is as_it_is else write, read)


def _fixed(*forms: FieldCodec) -> FieldCodec:
    """A tuple of so many values."""
    reads = [form.read for form in forms]

    def write(value: Any, keep: Keep) -> Any:
        return [form.write(item, keep) for form, item in zip(forms, value, strict=True)]

    def read(value: Any, fetch: Fetch) -> Any:
        return tuple([each(item, fetch) for each, item in zip(reads, value, strict=True)])

    return FieldCodec(_listed if all(form.write is as_it_is for form in forms) else write, read)


def _word_of(words: tuple[Any, ...]) -> FieldCodec:
    """One of the words of a `Literal`."""

    def read(value: Any, fetch: Fetch) -> Any:
        if value not in words:
            raise ValueError(f"{cut_repr(value, 60)} is where one of {', '.join(filter(None, words))} belongs")
        return value

    return FieldCodec(as_it_is, read)


VALUE = FieldCodec(_without_bytes, from_json)
SHOWN = {(Evidence, "value"): FieldCodec(to_json, from_json)}
"""What is asked about: the bytes of its pictures are kept."""
KINDS: Mapping[Any, tuple[type, ...]] = {str: (str,), int: (int,), bool: (bool,), float: (float, int), Mapping: (dict,)}
"""A field's type → the types of its values."""


def _record(kind: type[Any]) -> FieldCodec:
    """A named tuple, as an object of its fields."""
    defaults, hints = kind._field_defaults, get_type_hints(kind)
    forms = {name: SHOWN.get((kind, name)) or form_of(hints[name]) for name in kind._fields}
    reads = {name: form.read for name, form in forms.items()}
    table = tuple((name, defaults.get(name, ...), each.write is as_it_is, each.write) for name, each in forms.items())

    def write(value: Any, keep: Keep) -> Any:
        return {
            name: item if is_plain else write(item, keep)
            for (name, default, is_plain, write), item in zip(table, value, strict=True)
            if item is not default
        }

    def read(value: Any, fetch: Fetch) -> Any:
        if not isinstance(value, dict):
            raise wrong(value, "an object")
        if odd := sorted(value.keys() - forms.keys()):
            raise ValueError(f"a {kind.__name__} has no {odd[0]!r}")
        fields = {name: reads[name](item, fetch) for name, item in value.items()}
        try:
            return kind(**fields)
        except TypeError:
            missing = next(name for name in forms if name not in fields and name not in defaults)
            raise ValueError(f"'{missing}' is missing") from None

    return FieldCodec(write, read)


def _one_of(kinds: Iterable[type[Any]]) -> FieldCodec:
    """A named tuple of several kinds, as `{"start_goal": {…}}`."""
    forms = {kind: (effect_word(kind), _record(kind)) for kind in kinds}
    words = dict(forms.values())

    def write(value: Any, keep: Keep) -> Any:
        word, form = forms[type(value)]
        return {word: form.write(value, keep)}

    def read(value: Any, fetch: Fetch) -> Any:
        ((word, fields),) = value.items()
        if word not in words:
            raise ValueError(f"no effect is written {cut_repr(word, 60)}; there is: {', '.join(words)}")
        return words[word].read(fields, fetch)

    return FieldCodec(write, read)


@cache
def form_of(hint: Any) -> FieldCodec:
    """How values of a type are written and read."""
    none: tuple[type, ...] = ()
    if get_origin(hint) in (Union, UnionType):
        if type(None) not in get_args(hint):
            return _one_of(get_args(hint))
        hint, none = next(each for each in get_args(hint) if each is not type(None)), (type(None),)
    origin, args = get_origin(hint), get_args(hint)
    if (kinds := KINDS.get(origin or hint)) is not None:
        return _typed(*kinds, *none)
    if origin is Literal:
        return _word_of((*args, None) if none else args)
    if origin is tuple:
        return _list_of(form_of(args[0])) if args[1] is ... else _fixed(*map(form_of, args))
    return _record(hint) if hasattr(hint, "_fields") else VALUE


STEP = form_of(Step)


def _nowhere(ref: str, digest: str) -> Callable[[], bytes]:
    def missing() -> bytes:
        raise UsageError(f"picture '{ref}' was read without its bytes; read the journal that holds them")

    return missing


def encode(step: Step, keep: Keep = keep_nothing) -> dict[str, Any]:
    """A step as JSON.

    Args:
        step: Any step of a chart.
        keep: Stores the bytes of a picture that a question shows; all others are written as references alone.

    Raises:
        UsageError: A value in it that a journal cannot hold.
    """
    return cast("dict[str, Any]", STEP.write(step, keep))


def decode(written: Any, fetch: Fetch = _nowhere) -> Step:
    """The step that `encode` wrote.

    Raises:
        ValueError: It is no step; also `TypeError`.
    """
    return cast("Step", STEP.read(written, fetch))
