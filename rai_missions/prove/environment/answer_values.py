# SPDX-License-Identifier: Apache-2.0
"""What an answer may bring along: the values that an option's schema allows, as far as guards distinguish them.

Rule: a schema asks for more than values can be made for (patterns, formats); what no one can make is not judged by it
here. That gives more answers, never fewer.

Why parameters that are chosen when someone looks lose no run, and add none: what a step does depends on an answer
through the parameters that it looks at. So answers that agree in these lead to the same step, and each value that one
has is an alternative of the look. At the end of the step those are chosen that may be read before the next answer
(`Later.answers`); what is left of an answer is plain data then, and the others no rule can read any more. An answer
that waits for a hand-back is copied, which chooses all of it.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from itertools import pairwise
from typing import Any

from rai_missions.errors import unescaped
from rai_missions.keys import Key
from rai_missions.mission.option_parameters import listed_parameters, parameter_faults
from rai_missions.plain_data import is_number
from rai_missions.prove.abstraction.nondeterminism import Payload
from rai_missions.prove.analysis.representatives import OTHER, Values

__all__ = ("AnswerValues", "Parameters")

KINDS = {"array": "list"}
"""JSON Schema's word → ours, where they differ."""
DEEPEST = 16
"""References inside each other, at the most."""
Schema = Mapping[str, Any]


class Parameters(Payload):
    """What an answer brings along, chosen parameter by parameter when someone looks.

    Args:
        fields: All that it may bring.
        choose: A parameter's value; None where it is left out.
        needed: Parameter that the schema asks for → a value of it.
    """

    def __init__(self, fields: Sequence[str], choose: Callable[[str], Any], needed: Mapping[str, Any]) -> None:
        super().__init__(fields, choose)
        self._needed = needed

    def example(self) -> dict[str, Any]:
        """One answer that brings what was chosen; nothing is chosen by that."""
        return {**self._needed, **self.known()}


class AnswerValues:
    """The parameters that an answer can have.

    Args:
        keys: The blackboard; a parameter that is called as a key of the source `answer` is written there.
        values: What guards distinguish.
    """

    def __init__(self, keys: Mapping[str, Key], values: Values) -> None:
        self._keys, self._values = keys, values
        self._made: dict[tuple[int, str], list[Any]] = {}
        self._kept: list[Schema] = []

    def parameters(self, schema: Schema, pick: Callable[[Sequence[Any]], Any]) -> Parameters:
        """What a schema allows; a parameter that is written to a key is chosen at once."""
        names = self.names(schema)

        def choose(name: str) -> Any:
            values = self.of(schema, name)
            is_looked_at = name in self._keys or name in self._values.fields("answer")
            return pick((None, *values) if names[name] and is_looked_at else values)

        needed = {name: self.of(schema, name)[0] for name, can_lack in names.items() if not can_lack}
        made = Parameters(tuple(names), choose, needed)
        for name in names:
            if name in self._keys and self._keys[name].source == "answer":
                made.get(name)
        return made

    def names(self, schema: Schema) -> dict[str, bool]:
        """Parameter → whether it may be left out; those that the schema does not name count if anybody looks."""
        required = set(schema.get("required", ()))
        named = dict.fromkeys([*(schema.get("properties") or {}), *schema.get("required", ())])
        if schema.get("additionalProperties", True) is not False:
            named |= dict.fromkeys(sorted(self._looked(schema) - named.keys()))
        return {name: name not in required for name in named}

    def _looked(self, schema: Schema) -> set[str]:
        learned, any_is_written = self._values.learned, listed_parameters(schema) is None
        written = {name for name, key in self._keys.items() if key.source == "answer" and any_is_written}
        return {*self._values.fields("answer"), *(written & (learned.compared | learned.gone_over))}

    def of(self, schema: Schema, name: str) -> list[Any]:
        """The values of a parameter, one at the least."""
        place = (id(schema), name)
        if place not in self._made:
            self._kept.append(schema)  # so that its id does not become another's
            self._made[place] = list(self._all(schema, name))
        return self._made[place]

    def _all(self, schema: Schema, name: str) -> Iterator[Any]:
        own = (schema.get("properties") or {}).get(name, schema.get("additionalProperties", {}))
        made = list(_once(self._of(own if isinstance(own, Mapping) else {}, schema, name, 0)))
        judged = {**schema, "type": "object", "properties": {name: own}, "required": [], "minProperties": 0}
        fitting = [each for each in made if _is_opaque(each) or not parameter_faults(judged, {name: each})]
        yield from fitting or made

    def _of(self, part: Schema, whole: Schema, name: str, depth: int) -> Iterator[Any]:
        if isinstance(way := part.get("$ref"), str) and depth < DEEPEST:
            yield from self._of(_at(whole, way), whole, name, depth + 1)
            return
        if "enum" in part or "const" in part:
            yield from (each for each in part.get("enum", [part.get("const")]) if each is not None)
            return
        branches = [each for word in ("anyOf", "oneOf", "allOf") for each in part.get(word, ())]
        for each in branches if depth < DEEPEST else ():
            if isinstance(each, Mapping):
                yield from self._of(each, whole, name, depth + 1)
        kinds = part.get("type", [] if branches else "")
        for kind in [kinds] if isinstance(kinds, str) else kinds:
            yield from self._of_kind(part, KINDS.get(kind, kind), name)

    def _of_kind(self, part: Schema, kind: str, name: str) -> Iterator[Any]:
        values = self._values
        is_key = name in self._keys and name in values.learned.compared | values.learned.gone_over
        path = name if is_key else f"answer.{name}"
        found = [each for each in values.field(path, kind) if each is not None]
        if not any(map(is_number, found)):
            yield from found
            return
        marks = [*found, *filter(is_number, values.learned.operands(path))]
        yield from _numbers(part, marks, whole=kind == "integer")


def _is_opaque(value: Any) -> bool:
    """Whether a value represents many others, of which some may fit."""
    return isinstance(value, Mapping | list) or (isinstance(value, str) and value.startswith(OTHER))


def _numbers(part: Schema, found: Iterable[float], *, whole: bool) -> Iterator[float]:
    """The given numbers, the schema's bounds, and what lies between where it excludes bounds or has multiples."""
    words = ("minimum", "maximum", "exclusiveMinimum", "exclusiveMaximum")
    bounds = [each for word in words if is_number(each := part.get(word))]
    made = sorted({*found, *(each + step for each in bounds for step in ((-1, 0, 1) if whole else (0,)))})
    if not whole and bounds:
        made += [(low + high) / 2 for low, high in pairwise(made)]
    many = part.get("multipleOf")
    if is_number(many) and many > 0:
        made += [many * round_(each / many) for each in made for round_ in (math.floor, math.ceil)]
    yield from sorted(set(made))


def _at(schema: Schema, way: str) -> Schema:
    """The part of a schema that a reference into it names; anything, where it leads nowhere."""
    part: Any = schema
    for word in way.lstrip("#").strip("/").split("/"):
        part = part.get(unescaped(word)) if isinstance(part, Mapping) else None
    return part if isinstance(part, Mapping) else {}


def _once(values: Iterable[Any]) -> Iterator[Any]:
    """Each but once: true is not 1 here."""
    seen: list[tuple[str, Any]] = []
    for value in values:
        kind = "boolean" if isinstance(value, bool) else type(value).__name__
        if (kind, value) not in seen:
            seen.append((kind, value))
            yield value
