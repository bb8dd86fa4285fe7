# SPDX-License-Identifier: Apache-2.0
"""The types of fields: what a text, a name, a path, a number or a value may be, and how it is written in JSON.

Rule: nothing is coerced.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Annotated, Any, Literal, Protocol, TypeAlias

from pydantic import AfterValidator, BeforeValidator, Field, PlainSerializer, Strict, ValidationInfo
from pydantic_core import PydanticCustomError, PydanticKnownError

from rai_missions.model.references import EVENT, KEY, PATH, STATE, TIMER, OneOrMany, Refers
from rai_missions.model.validation_errors import NULL

__all__ = (
    "LISTED", "NAME", "NOT_NULL", "PATH_PATTERN", "RECORDED", "WHOLE", "ActionName", "Bool", "EventName", "Format",
    "HasPath", "Integer", "Json", "KeyName", "KeyPath", "Name", "Number", "Path", "Seconds", "ServiceName", "StateName",
    "StateNames", "Text", "TimerName", "TopicName", "Value", "alike", "fault", "is_recorded", "one_or_many",
    "refuse",
)  # fmt: skip

NAME = r"^[a-z][a-z0-9_]*(/[a-z][a-z0-9_]*)*$"
PATH_PATTERN = r"^[a-z][a-z0-9_]*(/[a-z][a-z0-9_]*)*(\.[A-Za-z_][A-Za-z0-9_]*)*$"


def fault(kind: str, sentence: str, *, at: tuple[str | int, ...] = ()) -> PydanticCustomError:
    """A fault of the author, as pydantic wants it raised in a validator; the sentence reaches the author as it is.

    Args:
        kind: What pydantic calls it.
        sentence: What is wrong, and what would be right.
        at: The steps to its place, from what the validator is given.
    """
    return PydanticCustomError(kind, "{sentence}", {"sentence": sentence, "at": at})


def refuse(found: Iterable[PydanticCustomError]) -> None:
    """Raise all faults that a validator found as one error, which is how pydantic takes them; none, if there are none.

    Args:
        found: As `fault` makes them.
    """
    if faults := tuple(found):
        first, *more = faults
        raise PydanticCustomError(first.type, "{sentence}", {**(first.context or {}), "more": more})


RECORDED: Mapping[str, bool] = {"is_recorded": True}
"""The context in which what a journal holds is validated: a run was made with it, by the rules of its day."""


def is_recorded(info: ValidationInfo) -> bool:
    """Whether what is validated was recorded; a rule that came after the first release asks it."""
    return bool((info.context or {}).get("is_recorded"))


def _key_text(value: Any) -> Any:
    """A reference made by `Keys` reads as its path."""
    return getattr(value, "__path__", value) if not isinstance(value, str) else value


def _tuple(value: Any) -> Any:
    if type(value) is str:  # as most are written
        return (value,)
    value = _key_text(value)
    return tuple(value) if isinstance(value, list | tuple) else (value,)


def _shorter(value: tuple[Any, ...]) -> Any:
    return value[0] if len(value) == 1 else list(value)


class _OneOrManySchema(OneOrMany):
    """States in a JSON Schema that a word may be written without its list."""

    def __get_pydantic_json_schema__(self, core_schema: Any, handler: Any) -> dict[str, Any]:
        listed = handler(core_schema)
        return {"anyOf": [listed["items"], listed]}


one_or_many = (BeforeValidator(_tuple), PlainSerializer(_shorter, return_type=Any), _OneOrManySchema())
"""A word or a list of words in JSON, always a tuple here."""

Text = Annotated[str, Strict()]


def _filled(value: str, info: ValidationInfo) -> str:
    if not value and not is_recorded(info):
        raise PydanticKnownError("string_too_short", {"min_length": 1})
    return value


Word = Annotated[Text, AfterValidator(_filled), Field(json_schema_extra={"minLength": 1})]
"""A text that is not empty, as the name of a topic."""
Name = Annotated[str, Strict(), Field(pattern=NAME), BeforeValidator(_key_text)]
"""Lower case, digits and underscores; `/` only in what an inclusion brought."""
Path = Annotated[str, PATH, Strict(), Field(pattern=PATH_PATTERN), BeforeValidator(_key_text)]
"""A key, or a field within one: `obstacle.height_m`; `event.…` and `answer.…` are of the trigger."""
StateName = Annotated[Name, STATE]
KeyName = Annotated[Name, KEY]
EventName = Annotated[Name, EVENT]
TimerName = Annotated[Name, TIMER]
ActionName = Annotated[Name, Refers("action")]
"""An action of the robot's profile."""
ServiceName = Annotated[Name, Refers("service")]
TopicName = Annotated[Name, Refers("topic")]
StateNames = Annotated[tuple[StateName, ...], Field(min_length=1), *one_or_many]
Bool = Annotated[bool, Strict()]
Integer = Annotated[int, Strict()]
Number = Annotated[int, Strict()] | Annotated[float, Strict(), Field(allow_inf_nan=False)]
Seconds = Annotated[
    float,
    Strict(),
    Field(ge=0, allow_inf_nan=False),
    PlainSerializer(lambda value: int(value) if isinstance(value, float) and value.is_integer() else value),
]


def _whole(value: Any) -> Any:
    if type(value) in (bool, float):  # true and 1.0 are equal to 1
        raise PydanticKnownError("literal_error", {"expected": "1"})
    return value


Format = Annotated[Literal[1], BeforeValidator(_whole)]
"""The version of the format of a file."""


def _frozen(value: Any) -> Any:
    """JSON values as they compare: lists as lists, finite numbers only."""
    if isinstance(value, float) and (value != value or value in (float("inf"), float("-inf"))):
        raise fault("finite", f"{value} is not a number that JSON has; give a finite one")
    if isinstance(value, Mapping):
        return {str(_key_text(name)): _frozen(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        return [_frozen(item) for item in value]
    if value is None or isinstance(value, str | int | float):
        return value
    text = _key_text(value)
    if isinstance(text, str):
        return {"from": text}
    raise fault("json", f"{value!r} is not JSON; give text, a number, true, false, a list or an object")


Json = Annotated[Any, AfterValidator(_frozen)]
"""A JSON value; in Python a reference made by `Keys` is read as `{"from": path}`."""


def _as_whole(value: Any) -> Any:
    text = _key_text(value)
    return value if text is value else {"from": text}


WHOLE = BeforeValidator(_as_whole)
"""In Python a reference may be the whole of what is sent."""


def _not_null(value: Any) -> Any:
    if value is None:
        raise fault("null", NULL)
    return value


NOT_NULL = BeforeValidator(_not_null)
"""The validator of a word that may be left out."""


def _listed(value: Any) -> Any:
    return tuple(value) if isinstance(value, list) else value


LISTED = BeforeValidator(_listed)
"""The validator of a tuple, which JSON and Python may write as a list; a word alone is none."""


def alike(one: Any, other: Any) -> bool:
    """Whether two values are equal as JSON is written: 1, 1.0 and true are three values, any mapping is an object."""
    if type(one) is not type(other):
        return isinstance(one, Mapping) and isinstance(other, Mapping) and alike(dict(one), dict(other))
    if isinstance(one, Mapping):
        return one.keys() == other.keys() and all(alike(value, other[name]) for name, value in one.items())
    if isinstance(one, list | tuple):
        return len(one) == len(other) and all(map(alike, one, other))
    return bool(one == other)


class HasPath(Protocol):
    """A reference as `Keys`, `event` and `answer` make it: `k.obstacle.height_m`."""

    @property
    def __path__(self) -> str: ...


KeyPath: TypeAlias = str | HasPath
"""Where an author names a key or a field of one: a reference, or its path as text."""
Value: TypeAlias = object
"""What an author writes in a goal, request or message: a JSON value, with references for what a run will know."""
