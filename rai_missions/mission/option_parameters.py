# SPDX-License-Identifier: Apache-2.0
"""What an option's parameters must be, in JSON Schema (2020-12), and whether those of an answer are valid.

Rule: a schema comes with a mission and may be anybody's. Judging by it opens nothing, and ends soon: no reference leads
out of it or back to itself, and patterns are matched in linear time.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from functools import cache, lru_cache
from itertools import islice
from typing import Any

from rai_missions.errors import steps_of
from rai_missions.plain_data import is_number, is_numeric
from rai_missions.redaction import clipped, shown

__all__ = ("MOST_PARTS", "listed_parameters", "parameter_faults", "schema_fault")

MOST_PARTS = 10_000
"""Objects and lists of a schema, counted as often as references lead to them, and of what is judged by it."""
MOST_PROBLEMS = 100
REFUSED = frozenset(
    {
        "$anchor", "$dynamicAnchor", "$dynamicRef", "$id", "$recursiveRef", "patternProperties", "unevaluatedItems",
        "unevaluatedProperties",
    }
)  # fmt: skip
"""Words by which a schema leads elsewhere, or takes time without bound."""
ANNOTATIONS = frozenset({"$comment", "$defs", "$schema", "default", "description", "examples", "title"})
"""Words that ask nothing of a value."""


def listed_parameters(schema: Mapping[str, Any] | None) -> Mapping[str, Any] | None:
    """The parameters under `properties`, which alone are written to keys; None where it has no such word: any is.

    Without that word, a schema with `"additionalProperties": false` admits none.

    Args:
        schema: An option's `parameters`; None where it takes none.
    """
    if schema is None:
        return {}
    properties = schema.get("properties", {} if schema.get("additionalProperties") is False else None)
    return properties if isinstance(properties, Mapping) else None


def schema_fault(schema: Mapping[str, Any]) -> str:
    """Why an option's `parameters` are no JSON Schema of an object, or none to judge by; empty if they are one."""
    import jsonschema  # heavy, and most options have no parameters

    kind = schema.get("type", "object")
    if kind != "object":
        return f"its 'type' is {clipped(repr(kind), 80)}, not 'object'"
    if why := _unbounded(schema):
        return why
    if word := _odd_word(schema, jsonschema.Draft202012Validator.VALIDATORS):
        return f"it has no word '{clipped(word, 80)}', so that nothing would be asked of a parameter"
    try:
        jsonschema.Draft202012Validator.check_schema(dict(schema))
    except jsonschema.SchemaError as error:
        return clipped(f"{error.json_path}: {error.message}", 200)
    return ""


def _odd_word(schema: Mapping[str, Any], asking: Iterable[str]) -> str:
    """A parameter's name where a word of the schema should be; empty where there is none.

    Args:
        schema: The schema of an object.
        asking: The words that ask something of a value.
    """
    known = ANNOTATIONS.union(asking)
    odd = (word for word, value in schema.items() if word not in known and isinstance(value, Mapping))
    return next(odd, "" if not schema or known & schema.keys() else next(iter(schema)))


def parameter_faults(schema: Mapping[str, Any], given: Mapping[str, Any]) -> str:
    """Why parameters are not as the schema has them; empty if they are.

    A schema that no check has passed, as in a journal from elsewhere, has none that fit.
    """
    if why := _unbounded(schema):
        return f"nothing fits a schema that is at fault: {why}"
    parts = list(islice(_parts(given), MOST_PARTS + 1))
    if len(parts) > MOST_PARTS:
        return f"they have more than {MOST_PARTS} objects and lists"
    odd = next((each for part in parts for each in _inside(part) if is_numeric(each) and not is_number(each)), None)
    if odd is not None:  # bounds of a schema do not hold it: it is below no number, and above none
        return f"{shown(odd, by=clipped)} is no finite number"
    if not schema:  # it asks nothing, so what judges by schemas need not be loaded
        return ""
    try:
        found = list(islice(_validator()(dict(schema)).iter_errors(dict(given)), MOST_PROBLEMS))
    except Exception as error:  # noqa: BLE001 - whatever jsonschema raises where a schema is none
        return f"nothing fits a schema that is at fault: {type(error).__name__}"
    problems = sorted(found, key=lambda error: list(map(str, error.path)))
    return "; ".join(clipped(f"{problem.json_path}: {problem.message}", 200) for problem in problems[:5])


@cache
def _validator() -> Any:
    """The class that judges by a schema; to make it takes longer than to judge."""
    import jsonschema  # heavy, and most options have no parameters

    extend: Any = jsonschema.validators.extend
    return extend(jsonschema.Draft202012Validator, {"pattern": _pattern})


def _pattern(_: Any, pattern: str, given: Any, __: Any) -> Iterable[Any]:
    import jsonschema

    if isinstance(given, str) and not _matches(pattern, given):
        yield jsonschema.ValidationError(f"{shown(given, by=clipped)} does not match {shown(pattern, by=clipped)}")


def _matches(pattern: str, text: str) -> bool:
    from pydantic import ValidationError

    try:
        _linear(pattern).validate_python(text)
    except ValidationError:
        return False
    return True


@lru_cache(256)
def _linear(pattern: str) -> Any:
    """What matches a pattern in a time that grows with the text and no faster: the engine that pydantic brings along.

    Raises:
        pydantic_core.SchemaError: It is no pattern, or one of those that take longer (looking around, looking back).
    """
    from pydantic_core import SchemaValidator
    from pydantic_core.core_schema import str_schema

    return SchemaValidator(str_schema(pattern=pattern, regex_engine="rust-regex"))


def _unbounded(schema: Mapping[str, Any]) -> str:
    """What in a schema leads out of it, or on and on."""
    rest: list[tuple[Any, frozenset[str]]] = [(schema, frozenset())]
    for _ in range(MOST_PARTS):
        if not rest:
            return ""
        part, trail = rest.pop()
        inside = list(part.values()) if isinstance(part, Mapping) else part
        if isinstance(part, Mapping):
            if why := _forbidden(part):
                return why
            if isinstance(way := part.get("$ref"), str):
                if way in trail:
                    return f"its reference {shown(way, by=clipped)} leads back to itself; write it out"
                try:
                    rest.append((_at(schema, way), trail | {way}))
                except (KeyError, IndexError, ValueError, TypeError):
                    there = "name a place of its own: '#/$defs/…'"
                    return f"its reference {shown(way, by=clipped)} leads nowhere in it; {there}"
        rest += [(each, trail) for each in inside if isinstance(each, Mapping | list | tuple)]
    return f"it has more than {MOST_PARTS} parts, where its references lead counted too; make it smaller"


def _forbidden(part: Mapping[str, Any]) -> str:
    if words := sorted(REFUSED & part.keys()):
        return f"it uses '{words[0]}', which is not judged by here; name its properties and give their types"
    pattern = part.get("pattern")
    if isinstance(pattern, str):
        from pydantic_core import SchemaError

        try:
            _linear(pattern)
        except SchemaError:
            given = shown(pattern, by=clipped)
            return f"its pattern {given} is none, or not one that is matched in linear time; write a simpler one"
    return ""


def _at(schema: Any, way: str) -> Any:
    """What a reference within a schema leads to (RFC 6901)."""
    if way != "#" and not way.startswith("#/"):
        raise ValueError(way)
    for name in steps_of(way):
        schema = schema[name] if isinstance(schema, Mapping) else schema[int(name)]
    return schema


def _parts(value: Any) -> Iterator[Any]:
    rest = [value]
    while rest:
        part = rest.pop()
        yield part
        rest += [each for each in _inside(part) if isinstance(each, Mapping | list | tuple)]


def _inside(part: Any) -> Iterable[Any]:
    return part.values() if isinstance(part, Mapping) else part
