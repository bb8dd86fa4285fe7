# SPDX-License-Identifier: Apache-2.0
"""The values that a choice takes: each with its type, what it is taken to be, and how it is read from a text.

Rule: a value is named by its path: of a key `battery`, of a field of it `obstacle.kind`.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any, Literal, NamedTuple

from rai_missions.errors import UsageError, suggestion
from rai_missions.guards.compare import Compare
from rai_missions.guards.goal import GoalIs
from rai_missions.image import Image
from rai_missions.keys import Key, TypeName
from rai_missions.mission.mission import Mission
from rai_missions.plain_data import is_number
from rai_missions.planning.examples import GOALS, REQUESTS, SIGHTS
from rai_missions.redaction import cut

__all__ = ("Field", "FieldType", "arguments_of", "assembled", "key_fields", "operands", "parameter_fields", "read_text")

FieldType = Literal[TypeName, "json"]
"""A key's types, and `json` for any value."""
SUGGESTED: Mapping[str, Any] = {
    "string": "", "number": 1.0, "integer": 0, "boolean": False, "object": {}, "list": [], "json": None,
    "image": "a test picture",
}  # fmt: skip
POSE = ("x", "y", "z", "yaw")
KINDS: Mapping[str, FieldType] = {
    "string": "string", "number": "number", "integer": "integer", "boolean": "boolean", "object": "object",
    "array": "list",
}  # fmt: skip
"""A word of JSON Schema → ours."""
MOST_OPERANDS = 8
GREY = bytes((128, 128, 128)) * 64
"""The pixels of the picture that a played camera takes: 8 x 8."""


class Field(NamedTuple):
    """One value that a choice takes."""

    name: str
    type: FieldType
    suggested: Any = None
    """What it is where nothing else is given; None for none."""
    is_required: bool = True
    among: tuple[Any, ...] = ()
    """All values that it can have, where these are few."""
    examples: tuple[Any, ...] = ()
    """Values with which the mission compares it."""
    about: str = ""

    def data(self) -> dict[str, Any]:
        """As JSON has it."""
        return self._asdict()


def operands(mission: Mission) -> Mapping[str, tuple[Any, ...]]:
    """Path of a key or of a field → the values with which the mission's guards compare it."""
    found: dict[str, list[Any]] = {}
    for each in mission.everything():
        if not isinstance(each, Compare) or each.other is not None:
            continue
        values = each.operand if each.op == "in" and isinstance(each.operand, list) else [each.operand]
        here = found.setdefault(each.key, [])
        here += [value for value in values if value not in here and not isinstance(value, Mapping | list)]
    for path, examples in _of_goals(mission):
        here = found.setdefault(path, [])
        here += [value for value in examples if value not in here]
    return {path: tuple(values[:MOST_OPERANDS]) for path, values in found.items()}


def _of_goals(mission: Mission) -> Iterator[tuple[str, Sequence[Any]]]:
    """The paths of goals, of what is seen and of requests, with examples that go together."""
    for each in mission.everything():
        if isinstance(each, GoalIs):
            yield from (
                (path, values)
                for path, values in (
                    (each.goal, GOALS[:1]),
                    (each.over, SIGHTS),
                    (each.in_, REQUESTS[:1]),
                )
                if path is not None
            )


def key_fields(name: str, key: Key, now: Any, examples: Mapping[str, tuple[Any, ...]]) -> tuple[Field, ...]:
    """The fields of a key.

    Args:
        name: The key's name.
        key: The key.
        now: Its value; None where it was never received.
        examples: As `operands` has them.
    """
    if key.type == "object" and key.fields:
        known = now if isinstance(now, Mapping) else {}
        parts = [(each, kind, known.get(each)) for each, kind in key.fields.items()]
        return tuple(_field(f"{name}.{each}", kind, value, examples, "") for each, kind, value in parts)
    if key.type == "pose":
        known = now if isinstance(now, Mapping) else {}
        return tuple(Field(f"{name}.{axis}", "number", known.get(axis, 0.0), axis in "xy") for axis in POSE)
    return (_field(name, key.type, now, examples, key.about),)


def _field(name: str, kind: TypeName, now: Any, examples: Mapping[str, tuple[Any, ...]], about: str) -> Field:
    among = (True, False) if kind == "boolean" else ()
    known = examples.get(name, ())
    first = known[0] if kind == "object" and known else SUGGESTED.get(kind)
    return Field(name, kind, first if now is None or kind == "image" else now, True, among, known, about)


def arguments_of(kinds: Mapping[str, str]) -> tuple[Field, ...]:
    """The fields of an event's payload, none of which it must have.

    Args:
        kinds: Name → its type, or `json`.
    """
    types: Mapping[str, FieldType] = {**KINDS, "list": "list"}
    return tuple(
        Field(name, types.get(kind, "json"), None, False, (True, False) if kind == "boolean" else ())
        for name, kind in kinds.items()
    )


def parameter_fields(schema: Mapping[str, Any] | None) -> tuple[Field, ...]:
    """The fields that an option's JSON Schema names."""
    if not schema:
        return ()
    needed, named = schema.get("required", ()), schema.get("properties") or {}
    whole = {**{name: {} for name in needed}, **named}
    return tuple(_parameter(name, of if isinstance(of, Mapping) else {}, name in needed) for name, of in whole.items())


def _parameter(name: str, of: Mapping[str, Any], is_required: bool) -> Field:
    word = of.get("type")
    kind = KINDS.get(word, "json") if isinstance(word, str) else "json"
    among = (True, False) if kind == "boolean" else ()
    values = of.get("enum", [of["const"]] if "const" in of else among)
    suggested = of.get("default", values[0] if values and is_required else None)
    if suggested is None and is_required:
        bounds = [of[each] for each in ("minimum", "maximum") if is_number(of.get(each))]
        suggested = bounds[0] if bounds else SUGGESTED.get(kind)
    return Field(name, kind, suggested, is_required, tuple(values), (), str(of.get("description", "")))


def read_text(field: Field, text: str) -> Any:
    """The value that a text means for a field.

    Raises:
        UsageError: It means none of its type.
    """
    if field.type in ("string", "image"):
        return text
    try:
        value = json.loads(text)
    except ValueError:
        if field.type == "json":
            return text
        raise UsageError(
            f"'{field.name}' is of type {field.type}; '{cut(text, 60)}' is not, {_example(field)}"
        ) from None
    return value


def _example(field: Field) -> str:
    shown = field.suggested if field.suggested is not None else SUGGESTED.get(field.type)
    return f"write it like {json.dumps(shown)}"


def assembled(fields: Iterable[Field], given: Mapping[str, Any]) -> dict[str, Any]:
    """The values of fields by name, those that are not given as suggested; what is None is left out.

    Raises:
        UsageError: A value has no field, or one that must be there has none.
    """
    known = {field.name: field for field in fields}
    for name in (each for each in given if each not in known):
        raise UsageError(f"there is no value '{name}' here{suggestion(name, known)}")
    values = {name: given.get(name, field.suggested) for name, field in known.items()}
    for name, field in known.items():
        if values[name] is None and field.is_required:
            raise UsageError(f"'{name}' is missing; give a value of type {field.type}")
    return {name: value for name, value in values.items() if value is not None}


def key_values(keys: Mapping[str, Key], values: Mapping[str, Any], at: float) -> Iterator[tuple[str, Any]]:
    """The keys that values make, each with its whole value.

    Args:
        keys: Those that are written.
        values: Values by path.
        at: Now; a played picture is known by it.
    """
    for name, key in keys.items():
        inside = {path.partition(".")[2]: value for path, value in values.items() if path.partition(".")[0] == name}
        if not inside:
            continue
        if key.type == "image":
            yield name, Image(f"{name}@{at:.3f}", 8, 8, "rgb8", GREY)
        elif key.type == "pose":
            yield name, {**inside, **({"frame": key.frame} if key.frame else {})}
        else:
            yield name, inside.get("", inside) if not (key.type == "object" and key.fields) else inside
