# SPDX-License-Identifier: Apache-2.0
"""What a path means where it is: which key or payload it reads, of which type, or why it reads nothing."""

from __future__ import annotations

from collections.abc import Mapping
from typing import NamedTuple

from rai_missions.check.index import MissionIndex, PathUse, Scope
from rai_missions.check.name_table import NameTable
from rai_missions.keys import Key
from rai_missions.mission.option_parameters import listed_parameters
from rai_missions.states import Option
from rai_missions.states.transition import ANY_EVENT

__all__ = ("Meaning", "key_of", "meaning", "parameter_types")

POSE = {"x": "number", "y": "number", "z": "number", "yaw": "number", "frame": "string"}
SCHEMA_TYPES = {"array": "list"}


class Meaning(NamedTuple):
    """What a path reads."""

    kind: str | None = None
    """Its type, where it is known."""
    fault: str = ""
    """Why it reads nothing."""


def key_of(index: MissionIndex, path: str) -> str | None:
    """The key that a path reads; None for a payload, and for a name that nothing resembles."""
    root = path.partition(".")[0]
    if root in ("event", "answer") and root not in index.keys:
        return None
    return index.keys.meant(root)


def meaning(index: MissionIndex, read: PathUse) -> Meaning:
    """What a path means where it is."""
    root, *fields = read.path.split(".")
    key = index.mission.blackboard.get(root)
    if key is not None:
        return _field(root, key, fields)
    if root == "event":
        return _event(index, read.scope, fields)
    if root == "answer":
        return _answer(index, read.scope, fields)
    return Meaning(None, index.keys.missing(root))


def _field(name: str, key: Key, fields: list[str]) -> Meaning:
    """A key, or a field within it."""
    kind: str | None = key.type
    known: Mapping[str, str] | None = key.fields
    for field in fields:
        known = POSE if kind == "pose" else known
        if kind not in ("object", "pose"):
            return Meaning(
                None, f"'{name}' is of type '{kind}', which has no fields, so no '{field}'; read '{name}' itself"
            )
        if known is None:
            return Meaning()
        if field not in known:
            return Meaning(None, NameTable(f"field of '{name}'", known).missing(field))
        name, kind, known = f"{name}.{field}", known[field], None
    return Meaning(kind)


def _event(index: MissionIndex, scope: Scope, fields: list[str]) -> Meaning:
    """The payload of what fires the transition."""
    if scope.transition is None or not scope.transition.definition.on:
        return Meaning(
            None,
            "'event.…' reads what fires a transition, and nothing does here; "
            "'set' a key in a transition with 'on', and read that",
        )
    words = scope.transition.definition.on
    declared = index.mission.events
    events = [(word, declared[word]) for word in (declared if ANY_EVENT in words else words) if word in declared]
    if len(fields) != 1 or any(word not in declared and word != ANY_EVENT for word in words):
        return Meaning()  # an outcome brings whatever its server reports
    if any(not event.fields for _, event in events):
        return Meaning()
    kinds = {event.fields[fields[0]] for _, event in events if fields[0] in event.fields}
    if events and not kinds:
        known = NameTable(f"field of event '{events[0][0]}'", events[0][1].fields)
        return Meaning(None, known.missing(fields[0]))
    return Meaning(kinds.pop() if len(kinds) == 1 else None)


def _answer(index: MissionIndex, scope: Scope, fields: list[str]) -> Meaning:
    """The parameters of the option that fires the transition."""
    options = _options(index, scope)
    if not options:
        return Meaning(
            None,
            "'answer.…' reads an option's parameters, and this is no transition of one; "
            "'set' a key in the option's transition, and read that",
        )
    if not fields:
        return Meaning("object")
    kinds: set[str | None] = set()
    for option in options.values():
        known = parameter_types(option)
        if known is None:
            return Meaning()
        if fields[0] in known:
            kinds.add(known[fields[0]])
    if not kinds:
        name, option = next(iter(options.items()))
        table = NameTable(
            f"parameter of option '{name}'", parameter_types(option) or {}, "add it to the option's 'parameters'"
        )
        return Meaning(None, table.missing(fields[0]))
    return Meaning(kinds.pop() if len(kinds) == 1 and len(fields) == 1 else None)


def _options(index: MissionIndex, scope: Scope) -> dict[str, Option]:
    """The options whose answer may be in hand."""
    if scope.option is not None:
        return {"": scope.option}
    if scope.transition is None:
        return {}
    transition = scope.transition.definition
    source = index.spot(transition.of) if transition.of is not None else scope.transition.owner
    options = source.options if source is not None else {}
    return {word: options[word] for word in transition.on if word in options}


def parameter_types(option: Option) -> dict[str, str | None] | None:
    """The names of an option's parameters and their types; None where any name will do."""
    listed = listed_parameters(option.parameters)
    if listed is None:
        return None
    found: dict[str, str | None] = {}
    for name, schema in listed.items():
        kind = schema.get("type") if isinstance(schema, Mapping) else None
        found[name] = SCHEMA_TYPES.get(kind, kind) if isinstance(kind, str) else None
    return found
