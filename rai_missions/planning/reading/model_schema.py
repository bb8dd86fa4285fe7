# SPDX-License-Identifier: Apache-2.0
"""The JSON Schema in which a model answers with a goal: an option's `parameters`, or a server's response format.

Rule: it is a part of the goal's own schema, written with few words of JSON Schema, since servers that hold a model to a
schema know few. What fits is read by `read_goal`, which decides.
"""

from __future__ import annotations

from typing import Any

from rai_missions.planning.scene import DESK, Scene

__all__ = ("goal_parameters",)

MOST = 16
"""Predicates of a model's goal."""
NAME: dict[str, Any] = {"type": "string", "pattern": "^[a-z][a-z0-9_]*$", "maxLength": 64}


def goal_parameters(scene: Scene | None = None) -> dict[str, Any]:
    """The schema of `{"all": [predicate, …]}`.

    Args:
        scene: What is seen: only its things can then be named. Without it any name can, as in a mission's file.
    """
    seen = [thing.name for thing in scene.things] if scene is not None else []
    name = _one_of(seen)
    pair = _list(name, 2, 2)
    several = _list(name, 2, MOST)
    predicates = [
        _object({"on": _list(_one_of([*seen, DESK]) if seen else NAME, 2, 2)}),
        _object({"at": name, "x": {"type": "number"}, "y": {"type": "number"}}),
        _object({"left_of": pair}),
        _object({"left_of": pair, "gap_m": {"type": "number"}}),
        _object({"behind": pair}),
        _object({"behind": pair, "gap_m": {"type": "number"}}),
        _object({"between": _list(name, 3, 3)}),
        _object({"shifted": name, "dx": {"type": "number"}, "dy": {"type": "number"}}),
        *(_object({each: pair}) for each in ("in", "next_to", "swapped")),
        *(_object({each: several}) for each in ("grouped", "apart")),
    ]
    return _object({"all": {"type": "array", "items": {"anyOf": predicates}, "minItems": 1, "maxItems": MOST}})


def _one_of(names: list[str]) -> dict[str, Any]:
    return {"enum": names} if names else NAME


def _list(item: dict[str, Any], least: int, most: int) -> dict[str, Any]:
    return {"type": "array", "items": item, "minItems": least, "maxItems": most}


def _object(properties: dict[str, Any]) -> dict[str, Any]:
    return {
        "type": "object",
        "properties": properties,
        "required": list(properties),
        "additionalProperties": False,
    }
