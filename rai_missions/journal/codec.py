# SPDX-License-Identifier: Apache-2.0
"""Steps as JSON, and back, exactly: `decode(encode(step)) == step`.

Rule: a field that is left out has its default; a field that a Step comes to hold later needs no change here.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any, Literal, NamedTuple, TypeVar, cast, get_args, get_origin, get_type_hints

from rai_missions.engine.decision import Evidence, Offer, Question, Verdict
from rai_missions.engine.description import effect_word
from rai_missions.engine.modes import Mode
from rai_missions.engine.step import Ask, Effect, Move, Step
from rai_missions.errors import UsageError
from rai_missions.event import Event
from rai_missions.journal.json_values import Fetch, Keep, from_json, keep_nothing, to_json
from rai_missions.redaction import cut_repr
from rai_missions.states.state import Holder

__all__ = ("decode", "encode")

Writer = Callable[[Any, Keep], Any]
Reader = Callable[[Any, Fetch], Any]
Value = TypeVar("Value")


class FieldCodec(NamedTuple):
    """How one field is written and read."""

    write: Writer
    read: Reader


def _same(value: Any, _: object) -> Any:
    return value


def _checked(*kinds: type) -> FieldCodec:
    def read(value: Any, fetch: Fetch) -> Any:
        if type(value) not in kinds:
            raise ValueError(
                f"{cut_repr(value, 60)} is given where {' or '.join(kind.__name__ for kind in kinds)} belongs"
            )
        return value

    return FieldCodec(_same, read)


def _tuple_of(form: FieldCodec) -> FieldCodec:
    def write(value: Any, keep: Keep) -> Any:
        return [form.write(item, keep) for item in value]

    def read(value: Any, fetch: Fetch) -> Any:
        if not isinstance(value, list):
            raise ValueError(f"{cut_repr(value, 60)} is given where a list belongs")
        return tuple([form.read(item, fetch) for item in value])

    return FieldCodec(write, read)


def _pair(second: FieldCodec) -> FieldCodec:
    def write(value: Any, keep: Keep) -> Any:
        return [value[0], second.write(value[1], keep)]

    def read(value: Any, fetch: Fetch) -> Any:
        name, item = value
        return TEXT.read(name, fetch), second.read(item, fetch)

    return FieldCodec(write, read)


TEXT, INTEGER, NUMBER, TRUTH = _checked(str), _checked(int), _checked(float, int), _checked(bool, type(None))
VALUE = FieldCodec(lambda value, keep: to_json(value), from_json)
"""Any value; also the form of every field whose type reports no more."""
SHOWN = FieldCodec(to_json, from_json)
"""What someone is asked about: the bytes of its pictures are kept."""
TEXTS = _tuple_of(TEXT)


def _value_of(*kinds: type) -> FieldCodec:
    """A value of certain types: who altered a journal may have written another."""

    def read(value: Any, fetch: Fetch) -> Any:
        found = from_json(value, fetch)
        if type(found) not in kinds:
            raise ValueError(
                f"{cut_repr(value, 60)} is given where {' or '.join(kind.__name__ for kind in kinds)} belongs"
            )
        return found

    return FieldCodec(VALUE.write, read)


def _word_of(words: Any) -> FieldCodec:
    """One of the words of a `Literal`."""

    def read(value: Any, fetch: Fetch) -> Any:
        if value not in get_args(words):
            raise ValueError(f"{cut_repr(value, 60)} is where one of {', '.join(get_args(words))} belongs")
        return value

    return FieldCodec(_same, read)


FORMS: Mapping[Any, FieldCodec] = {
    str: _value_of(str),
    int: _value_of(int),
    bool: _value_of(bool),
    float: _value_of(float, int),
    str | None: _value_of(str, type(None)),
    float | None: _value_of(float, int, type(None)),
    tuple[str, ...]: TEXTS,
    Mapping[str, Any]: _value_of(dict),
    Mapping[str, Any] | None: _value_of(dict, type(None)),
}
"""A field's type → its form, where a table below does not name another."""


def _record(kind: type[Any], /, **forms: FieldCodec) -> FieldCodec:
    """The form of a named tuple, written as an object of its fields."""
    defaults, hints = kind._field_defaults, get_type_hints(kind)
    table = tuple((name, defaults.get(name, ...), forms.get(name) or _usual(hints[name])) for name in kind._fields)

    def write(value: Any, keep: Keep) -> Any:
        return {
            name: form.write(item, keep)
            for (name, default, form), item in zip(table, value, strict=True)
            if item is not default
        }

    by_name = {name: form for name, _, form in table}

    def read(value: Any, fetch: Fetch) -> Any:
        if not isinstance(value, dict):
            raise ValueError(f"{cut_repr(value, 60)} is given where an object belongs")
        unknown = sorted(value.keys() - by_name.keys())
        if unknown:
            raise ValueError(f"a {kind.__name__} has no {unknown[0]!r}")
        return kind(**{name: by_name[name].read(item, fetch) for name, item in value.items()})

    return FieldCodec(write, read)


def _usual(hint: Any) -> FieldCodec:
    """The form of a field that no table names, by its type."""
    if get_origin(hint) is Literal:
        return _word_of(hint)
    return _record(hint) if hasattr(hint, "_fields") else FORMS.get(hint, VALUE)


EVENT = _record(Event, name=TEXT, at=NUMBER, kind=TEXT, number=INTEGER)
MOVE = _record(Move, taken=TEXTS, exited=TEXTS, entered=TEXTS, trigger=TEXT)
QUESTION = _record(
    Question,
    number=INTEGER,
    owner=TEXT,
    asked=TEXT,
    text=TEXT,
    options=_tuple_of(_record(Offer, name=TEXT, about=TEXT)),
    evidence=_tuple_of(_record(Evidence, key=TEXT, value=SHOWN, fresh=_checked(bool))),
    refused=TEXTS,
    tools=TEXTS,
)


EFFECTS: Mapping[type[Any], tuple[str, FieldCodec]] = {
    kind: (effect_word(kind), _record(kind, **({"question": QUESTION} if kind is Ask else {})))
    for kind in cast("tuple[type[Any], ...]", Effect.__args__)
}
"""Each effect is written as `{"start_goal": {…}}`."""
EFFECT_WORDS = dict(EFFECTS.values())


def _write_effect(effect: Any, keep: Keep) -> Any:
    word, form = EFFECTS[type(effect)]
    return {word: form.write(effect, keep)}


def _read_effect(written: Any, fetch: Fetch) -> Any:
    ((word, fields),) = written.items()
    if word not in EFFECT_WORDS:
        raise ValueError(f"no effect is written {cut_repr(word, 60)}; there is: {', '.join(EFFECT_WORDS)}")
    return EFFECT_WORDS[word].read(fields, fetch)


STEP = _record(
    Step,
    seq=INTEGER,
    at=NUMBER,
    event=EVENT,
    moves=_tuple_of(MOVE),
    guards=_tuple_of(_pair(TRUTH)),
    writes=_tuple_of(_pair(VALUE)),
    effects=_tuple_of(FieldCodec(_write_effect, _read_effect)),
    why=TEXT,
    notes=TEXTS,
    mode=_word_of(Mode),
    holder=_word_of(Holder),
    verdicts=_tuple_of(_record(Verdict, number=INTEGER, note=INTEGER)),
    kept=_checked(bool),
)


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
        ValueError: It is no step; also `TypeError` for a field that is missing.
    """
    return cast("Step", STEP.read(written, fetch))
