# SPDX-License-Identifier: Apache-2.0
"""The format as JSON Schema (2020-12), made from the models: for editors, and for programs that write missions.

Rule: what the models define is not repeated here; only what pydantic cannot know of them is added.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from rai_missions.guards import Compare, GoalIs, Guard
from rai_missions.guards.compare import OPERATORS
from rai_missions.mission.mission import Mission
from rai_missions.model import FAMILY, MissionModel, TaggedModel
from rai_missions.states import State, Transition
from rai_missions.states.effects import Effect, Set
from rai_missions.states.state import OUTCOMES
from rai_missions.states.tree import TreeNode
from rai_missions.states.tree.leaves import SetLeaf

__all__ = ("mission_schema", "schema_of")

DIALECT = "https://json-schema.org/draft/2020-12/schema"
FAMILIES: Mapping[str, type[TaggedModel]] = {family.__name__: family for family in (Effect, Guard, State, TreeNode)}
STRONGER = {("Guard", "in"): ("key", "goal"), ("State", "states"): ("each",)}
"""A kind's word that is also a word of other kinds, which then decide."""
VALUE = {"type": ["string", "number", "boolean", "object", "array"]}
"""Any JSON value but null, which is no value."""
LISTED = {"type": ["array", "object"]}
"""A list, or a key that holds one."""


def _one_of(*words: str) -> dict[str, Any]:
    """Exactly one of these words, and with a value."""
    return {"oneOf": [{"required": [word]} for word in words]}


SET = _one_of("value", "from", "add") | {"properties": {"value": VALUE}}
ON = {"required": ["on"], "properties": {"on": {"minItems": 1}}}
"""A transition with a trigger: an empty list is none."""
RULES: Mapping[str, Mapping[str, Any]] = {
    Compare.__name__: _one_of(*OPERATORS)
    | {"properties": {word: LISTED if each.takes_list else VALUE for word, each in OPERATORS.items()}},
    GoalIs.__name__: {
        "if": {"properties": {"is": {"const": "said"}}, "required": ["is"]},
        "then": {"required": ["in"]},
        "else": {"required": ["over"], "not": {"required": ["in"]}},
    },
    Set.__name__: SET,
    SetLeaf.__name__: SET,
    Transition.__name__: {
        "anyOf": [ON, {"required": ["after_s"]}, {"required": ["when"]}],
        "not": ON | {"required": ["on", "after_s"]},
        "dependentSchemas": {"of": ON},
    },
    "Key": {
        "properties": {"initial": VALUE},
        "allOf": [
            {"if": {"required": ["fields"]}, "then": {"properties": {"type": {"const": "object"}}}},
            {
                "if": {"properties": {"source": {"const": "robot"}}, "required": ["source"]},
                "then": {"not": {"required": ["initial"]}},
            },
        ],
    },
    "DecisionSpec": {"properties": {"options": {"propertyNames": {"not": {"enum": list(OUTCOMES)}}}}},
    Mission.__name__: {
        "properties": {
            "$schema": {"type": "string"},
            "events": {"type": ["object", "array"], "items": {"type": "string"}},
        }
    },
}
"""Model → what its validators ask beyond the types of its fields; merged into its schema."""


def mission_schema() -> dict[str, Any]:
    """The JSON Schema of a mission file."""
    return schema_of(Mission, "A mission of rai_missions")


def schema_of(model: type[MissionModel], title: str) -> dict[str, Any]:
    """The JSON Schema of a written model, with the families that it refers to spelled out."""
    definitions: dict[str, Any] = {}
    top = _schema(model, definitions)
    _families(top, definitions)
    return {"$schema": DIALECT, "title": title, **top, "$defs": dict(sorted(definitions.items()))}


def _schema(model: type[MissionModel], definitions: dict[str, Any]) -> dict[str, Any]:
    """One model's own schema; those it holds are put among the definitions."""
    raw = model.model_json_schema(ref_template="#/$defs/{model}")
    for name, inner in raw.pop("$defs", {}).items():
        if name not in definitions:
            definitions[name] = _ruled(_tidied(inner), name)
            _families(definitions[name], definitions)
    return _ruled(_tidied(raw), model.__name__)


def _families(schema: Any, definitions: dict[str, Any]) -> None:
    """Put the families that a schema refers to, and their kinds, among the definitions."""
    for name in _referred(schema):
        if name in FAMILIES and name not in definitions:
            definitions[name] = _by_word(name, FAMILIES[name])
            for word, kind in FAMILIES[name].kinds.items():
                definitions[_member(name, word)] = _schema(kind, definitions)
                _families(definitions[_member(name, word)], definitions)


def _member(family: str, word: str) -> str:
    return f"{family}.{word or 'plain'}"


def _by_word(name: str, family: type[TaggedModel]) -> dict[str, Any]:
    """A family: whatever has a kind's word is that kind. A `oneOf` would try every kind at every depth."""
    words = [word for word in family.kinds if word]
    members = {word: {"$ref": f"#/$defs/{_member(name, word)}"} for word in family.kinds}
    cases: list[dict[str, Any]] = []
    for word in words:
        decides: dict[str, Any] = {"required": [word]}
        if (stronger := STRONGER.get((name, word))) is not None:
            others = [{"required": [each]} for each in stronger]
            decides["not"] = others[0] if len(others) == 1 else {"anyOf": others}
        cases.append({"if": decides, "then": members[word]})
    some = {"anyOf": [{"required": [word]} for word in words]}
    known = {word: {"description": family.kinds[word].summary()} for word in words}
    if "" in members:
        return {"type": "object", "properties": known, "allOf": [*cases, {"if": {"not": some}, "then": members[""]}]}
    return {"type": "object", "properties": known, **some, "allOf": cases}


def _referred(schema: Any) -> Iterable[str]:
    if isinstance(schema, dict):
        if isinstance(schema.get("$ref"), str):
            yield schema["$ref"].rpartition("/")[2]
        for item in schema.values():
            yield from _referred(item)
    elif isinstance(schema, list):
        for item in schema:
            yield from _referred(item)


def _ruled(schema: dict[str, Any], name: str) -> dict[str, Any]:
    """A schema with the rules of its model merged in."""
    rules = RULES.get(name, {})
    merged = {word: rule for word, rule in rules.items() if word != "properties"}
    properties = dict(schema.get("properties", {}))
    for word, more in rules.get("properties", {}).items():
        properties[word] = properties.get(word, {}) | more
    return schema | {"properties": properties} | merged


def _tidied(schema: Any) -> Any:
    """Without titles that repeat names and without nulls; closed, and with families as references."""
    if isinstance(schema, list):
        return [_tidied(item) for item in schema]
    if not isinstance(schema, dict):
        return schema
    if FAMILY in schema:
        return {"$ref": f"#/$defs/{schema[FAMILY]}"}
    tidy = {word: _tidied_word(word, item) for word, item in schema.items() if word != "title"}
    if tidy.get("default", ...) is None:
        del tidy["default"]
    choices = [choice for choice in tidy.get("anyOf", ()) if choice != {"type": "null"}]
    if len(choices) == 1:
        del tidy["anyOf"]
        tidy = choices[0] | tidy
    if "patternProperties" in tidy:
        tidy["additionalProperties"] = False
    if tidy.get("type") == "array" and "minLength" in tidy:
        tidy["minItems"] = tidy.pop("minLength")
    return tidy


def _tidied_word(word: str, item: Any) -> Any:
    if word in ("properties", "patternProperties", "$defs"):
        return {name: _tidied(inner) for name, inner in item.items()}
    return item if word in ("default", "enum", "const", "required") else _tidied(item)
