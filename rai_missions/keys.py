# SPDX-License-Identifier: Apache-2.0
"""What the mission knows: typed keys, and values with the time at which they were so.

Rule: a value without its stamp does not exist here; anyone who reads it can ask how old it is.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import chain
from typing import Annotated, Any, Literal, NamedTuple, Self, TypeAlias

from pydantic import BeforeValidator, Field, model_validator
from pydantic_core import PydanticCustomError

from rai_missions.errors import suggestion
from rai_missions.image import Image
from rai_missions.model import Bool, Json, MissionModel, Name, Number, Seconds, Text, Value, fault, refuse
from rai_missions.plain_data import is_number
from rai_missions.redaction import clipped, shown

__all__ = (
    "Blackboard", "Key", "PythonType", "Source", "Stamped", "TypeName", "field_type", "is_within", "pose_slip",
    "stale_at", "type_error",
)  # fmt: skip

TypeName = Literal["string", "number", "integer", "boolean", "object", "list", "pose", "image"]
Source = Literal["robot", "argument", "mission", "answer"]

PYTHON_TYPES: Mapping[Any, str] = {
    str: "string",
    float: "number",
    int: "integer",
    bool: "boolean",
    dict: "object",
    list: "list",
    Image: "image",
}


PythonType: TypeAlias = type[str] | type[float] | type[bool] | type[dict[str, Any]] | type[list[Any]] | type[Image]
"""The types of Python that mean a type of the format."""

MEANT = {
    "float": "number", "double": "number", "float32": "number", "float64": "number", "real": "number",
    "int": "integer", "int32": "integer", "int64": "integer", "uint8": "integer", "long": "integer",
    "bool": "boolean", "flag": "boolean", "str": "string", "text": "string", "dict": "object", "map": "object",
    "struct": "object", "array": "list", "tuple": "list", "picture": "image", "camera": "image", "point": "pose",
}  # fmt: skip
"""Types of other languages → ours."""


def _type_name(given: Any) -> Any:
    return field_type(given, example=', as in "type": "{}"')


def field_type(given: Any, *, example: str = "") -> Any:
    """The type of a field, of an object or of an event, which may be one of Python."""
    if isinstance(given, str) and (meant := MEANT.get(given.lower())):
        raise fault("type", f"no type {shown(given, by=clipped)}; did you mean '{meant}'{example.format(meant)}?")
    return PYTHON_TYPES.get(given, given) if isinstance(given, type) else given


class Stamped(NamedTuple):
    """A value and the time at which it was so, in seconds on the run's clock."""

    value: Any
    at: float


Blackboard = dict[str, Stamped]
"""Key → what was last learned of it. A key that is not there was never received."""


RANGE = ("minimum", "maximum")
OWN_WORDS: Mapping[TypeName, tuple[str, ...]] = {
    "pose": ("frame",),
    "object": ("fields",),
    "number": RANGE,
    "integer": RANGE,
    "string": ("enum",),
}
"""Type → the words of a key that describe values of that type alone."""
ALL_OWN = frozenset(chain(*OWN_WORDS.values()))


class Key(MissionModel):
    """One key of the blackboard: its values, who writes it and how long it can be believed."""

    type: Annotated[TypeName, BeforeValidator(_type_name)]
    """`string`, `number`, `integer`, `boolean`, `object`, `list`, `pose`, `image`; in Python also `str`, `float`,
    `int`, `bool`, `dict`, `list`, `Image`. `pose` is `{"x", "y", "z", "yaw"}` in metres and radians with its `frame`;
    `image` a reference."""
    source: Source = "mission"
    """`robot`: written by the robot profile alone. `argument`: given at the start. `mission`: `set`. `answer`: an
    option's parameters."""
    initial: Json = None
    """The value at the start; a robot key has none."""
    max_age_s: Seconds | None = Field(default=None, gt=0)
    """Seconds after which a value is stale: as good as unknown."""
    optional: Bool = False
    """The start does not wait for it."""
    fields: dict[Name, Annotated[TypeName, BeforeValidator(field_type)]] | None = None
    """An object's fields and their types."""
    frame: Text = ""
    """The frame that a pose is given in; one without this frame does not fit."""
    minimum: Number | None = None
    """Of an argument that is a number: the least value that the mission takes."""
    maximum: Number | None = None
    """Of an argument that is a number: the greatest value that the mission takes."""
    enum: tuple[Text, ...] | None = Field(default=None, min_length=1)
    """Of an argument that is a string: the values that the mission takes."""
    about: Text = ""
    """What it means, in a sentence, with its unit; questions and reports show it."""

    def __init__(
        self,
        type: TypeName | PythonType,
        *,
        source: Source = "mission",
        initial: Value = None,
        max_age_s: float | None = None,
        optional: bool = False,
        fields: Mapping[str, TypeName | PythonType] | None = None,
        frame: str = "",
        minimum: float | None = None,
        maximum: float | None = None,
        enum: Sequence[str] | None = None,
        about: str = "",
    ) -> None: ...

    @model_validator(mode="after")
    def _fits_its_source(self) -> Self:
        refuse(self._faults())
        return self

    def _faults(self) -> Iterator[PydanticCustomError]:
        """What does not go together."""
        if self.source == "robot" and self.initial is not None:
            yield fault(
                "initial", "a robot key has no 'initial': it is unknown until the robot reports it", at=("initial",)
            )
        if self.fields is not None and self.type != "object":
            yield fault("fields", f"only an object has 'fields', this is of type '{self.type}'", at=("fields",))
        if self.frame and self.type != "pose":
            yield fault("frame", f"only a pose has a 'frame', this is of type '{self.type}'", at=("frame",))
        yield from self._range_faults()
        yield from self._enum_faults()
        if self.source != "robot" and self.initial is not None and (why := self._unfit_initial()):
            yield fault("initial", f"'initial' does not fit: {why}", at=("initial",))

    def _unfit_initial(self) -> str:
        """Why the value at the start is none of the key's, as far as the other words are of the key's type."""
        own = OWN_WORDS.get(self.type, ())
        foreign = {word: Key.model_fields[word].default for word in ALL_OWN if word not in own}
        key = self.model_copy(update=foreign)
        return type_error(key, self.initial, written=True)

    def _range_faults(self) -> Iterator[PydanticCustomError]:
        """A range is of numbers that a person gives."""
        for name, bound in (("minimum", self.minimum), ("maximum", self.maximum)):
            if bound is not None and (self.source != "argument" or self.type not in ("number", "integer")):
                yield fault(name, f"only an argument of type 'number' or 'integer' has a '{name}'", at=(name,))
        if self.minimum is not None and self.maximum is not None and self.minimum > self.maximum:
            yield fault(
                "maximum",
                f"{self.maximum:g} is less than the minimum, {self.minimum:g}; no value fits",
                at=("maximum",),
            )

    def _enum_faults(self) -> Iterator[PydanticCustomError]:
        """A list of values is of strings that a person gives."""
        if self.enum is not None and (self.source != "argument" or self.type != "string"):
            yield fault("enum", "only an argument of type 'string' has an 'enum'", at=("enum",))
        listed = self.enum or ()
        for at, value in enumerate(listed):
            if value in listed[:at]:
                yield fault("enum", f"'{value}' is there twice; keep one", at=("enum", at))

    @property
    def must_recur(self) -> bool:
        """The robot must report it again and again: what it reported goes stale."""
        return self.source == "robot" and self.max_age_s is not None


def _is_pose(value: Any) -> bool:
    return (
        isinstance(value, Mapping)
        and all(is_number(value.get(axis, 0.0)) for axis in ("x", "y", "z", "yaw"))
        and ("x" in value and "y" in value)
    )


_FITS: Mapping[str, Callable[[Any], bool]] = {
    "string": lambda value: isinstance(value, str),
    "number": is_number,
    "integer": lambda value: isinstance(value, int) and is_number(value),
    "boolean": lambda value: isinstance(value, bool),
    "object": lambda value: isinstance(value, Mapping),
    "list": lambda value: isinstance(value, list | tuple),
    "pose": _is_pose,
    "image": lambda value: isinstance(value, Image),
}


def is_within(value: Any, minimum: float | None, maximum: float | None) -> bool:
    """Whether a value is in a range; None is no bound, and without bounds any value is."""
    return (minimum is None or value >= minimum) and (maximum is None or value <= maximum)


def _range(least: str, most: str) -> str:
    return f"from {least} to {most}" if least and most else f"{least} or more" if least else f"{most} or less"


LIKE: Mapping[str, str] = {
    "string": 'a string is like "north"',
    "number": "a number is like 1.5",
    "integer": "an integer is like 3",
    "boolean": "a boolean is true or false",
    "object": 'an object is like {"speed": 1.5}',
    "list": "a list is like [1, 2]",
    "pose": 'a pose is {"x": 1.5, "y": 2, "yaw": 0}, in metres and radians',
    "image": "the robot alone has images",
}
"""What a value of each type looks like, for one who wrote another."""


def type_error(key: Key, value: Any, *, written: bool = False) -> str:
    """Why a value does not fit a key; empty if it does.

    Args:
        key: Whose value it is to be.
        value: Any value.
        written: A person wrote it, who is to read what would fit.
    """
    if not _FITS[key.type](value):
        return _not_of(key.type, value, written=written)
    if not is_within(value, key.minimum, key.maximum):
        least, most = ("" if each is None else f"{each:g}" for each in (key.minimum, key.maximum))
        return f"{value:g} is out of range; it must be {_range(least, most)}"
    if key.enum is not None and value not in key.enum:
        return f"there is no {clipped(repr(value), 80)}{suggestion(value, key.enum)}"
    if key.frame and value.get("frame") != key.frame:
        return f'{clipped(repr(value), 80)} is not in the frame of this key; it needs "frame": "{key.frame}"'
    for name, kind in (key.fields or {}).items():
        if name in value and value[name] is not None and not _FITS[kind](value[name]):
            return f"field '{name}': {_not_of(kind, value[name], written=written)}"
    return ""


POSE_WORDS = ("x", "y", "z", "yaw", "frame")
TURN = 2 * math.pi


def pose_slip(key: Key, value: Any) -> str:
    """Why a pose that a person wrote is most likely another than was meant; empty otherwise.

    A robot may report more words, and a heading that has gone round several times.

    Args:
        key: Whose value it is to be.
        value: One that fits it.
    """
    if key.type != "pose":
        return ""
    if word := next((each for each in value if each not in POSE_WORDS), ""):
        return f"a pose has no {shown(word, by=clipped)}{suggestion(word, POSE_WORDS)}"
    yaw = value.get("yaw", 0.0)
    if abs(yaw) > TURN:
        return f"yaw {yaw:g} is more than a turn; it is in radians: {yaw:g}° are {math.radians(yaw):.4g}"
    return ""


def _not_of(kind: TypeName, value: Any, *, written: bool) -> str:
    like = f"; {LIKE[kind]}" if written or kind == "pose" else ""
    given = shown(value, 80, by=clipped) if written else clipped(repr(value), 80)
    return f"{given} is not of type '{kind}'{like}"


def stale_at(key: Key | None, entry: Stamped) -> float:
    """The instant from which an entry is stale; infinity for one that lasts."""
    return entry.at + key.max_age_s if key is not None and key.max_age_s is not None else math.inf
