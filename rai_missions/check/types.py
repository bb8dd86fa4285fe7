# SPDX-License-Identifier: Apache-2.0
"""Types: what is compared, set, iterated and measured is of a type with which that can be done."""

from __future__ import annotations

import json
from collections.abc import Iterator
from typing import Any

from rai_missions.check.index import MissionIndex, Read, Scope, Write
from rai_missions.check.paths import meaning
from rai_missions.check.pointers import pointer, template_reads
from rai_missions.guards import Compare, Near
from rai_missions.keys import Key, fits
from rai_missions.states import Each

__all__ = ("mismatched_comparisons", "mismatched_lists", "mismatched_poses", "mismatched_writes")

Found = Iterator[tuple[str, str]]
NUMBERS = ("number", "integer")
ORDERED = (*NUMBERS, "string")


def _kind(survey: MissionIndex, path: str, scope: Scope) -> str | None:
    return meaning(survey, Read(path, "", scope)).kind


def _fits_together(one: str, other: str) -> bool:
    return one == other or (one in NUMBERS and other in NUMBERS)


def _type_of(value: Any) -> str:
    if isinstance(value, bool):
        return "boolean"
    named = {int: "integer", float: "number", str: "string", list: "list", dict: "object"}
    return named.get(type(value), "value")


def shown(value: Any) -> str:
    """A value as JSON has it, cut short."""
    return f"{json.dumps(value, ensure_ascii=False, default=str):.80}"


def mismatched_comparisons(survey: MissionIndex) -> Found:
    """A comparison is between values of one type, and `<` between numbers or strings."""
    for place, part, ruled in survey.parts:
        if isinstance(part, Compare):
            kind = _kind(survey, part.key, ruled.scope)
            if kind is not None and (sentence := _comparison(survey, part, kind, ruled.scope)):
                yield f"{place}/key" if sentence.startswith(f"'{part.key}'") else pointer(place, part.op), sentence


def _comparison(survey: MissionIndex, part: Compare, kind: str, scope: Scope) -> str:
    """Why a comparison cannot be made; empty if it can."""
    path, op = part.key, part.op
    if kind == "image":
        remedy = f'ask for {{"fresh": "{path}"}}, or compare a key that says what is seen'
        return f"'{path}' is an image, which cannot be compared; {remedy}"
    if op in ("<", "<=", ">", ">=") and kind not in ORDERED:
        return f"'{path}' is of type '{kind}', which has no order; compare it with == or !="
    if part.other is not None:
        other = _kind(survey, part.other, scope)
        if op == "in" and other not in (None, "list"):
            return f"'in' takes a list, and '{part.other}' is of type '{other}'; compare with =="
        if op != "in" and other is not None and not _fits_together(kind, other):
            return f"'{path}' is of type '{kind}' and '{part.other}' of type '{other}'; compare keys of one type"
        return ""
    if op == "in":
        if not isinstance(part.operand, list):
            return f"'in' takes a list of values or a key that holds one, not {shown(part.operand)}"
        wrong = [item for item in part.operand if not _can_be(kind, item)]
        return f"'{path}' is of type '{kind}' and never {shown(wrong[0])}; list values of that type" if wrong else ""
    if not _can_be(kind, part.operand):
        given = f"{shown(part.operand)} is of type '{_type_of(part.operand)}'"
        return f"'{path}' is of type '{kind}', and {given}; compare with a value of its type"
    return ""


def _can_be(kind: str, value: Any) -> bool:
    """Whether a value can be compared with one of a type."""
    if kind in NUMBERS:
        return isinstance(value, int | float) and not isinstance(value, bool)
    if kind in ("object", "pose"):
        return isinstance(value, dict)
    return _type_of(value) == kind


def mismatched_poses(survey: MissionIndex) -> Found:
    """`near` measures between two poses that are given in one frame."""
    for place, part, ruled in survey.parts:
        if not isinstance(part, Near):
            continue
        for index, path in enumerate(part.near):
            kind = _kind(survey, path, ruled.scope)
            if kind not in (None, "pose", "object"):
                yield (
                    f"{place}/near/{index}",
                    f"'{path}' is of type '{kind}', not 'pose'; 'near' measures between two poses",
                )
        frames = {
            key.frame for path in part.near if (key := survey.mission.blackboard.get(path)) is not None and key.frame
        }
        if len(frames) > 1:
            yield (
                f"{place}/near",
                f"the poses are given in different frames, {' and '.join(sorted(frames))}; bring them into one",
            )


def mismatched_lists(survey: MissionIndex) -> Found:
    """`each` goes over a list."""
    for spot in survey.spots:
        if isinstance(spot.state, Each):
            kind = _kind(survey, spot.state.each, Scope(spot))
            if kind not in (None, "list"):
                yield (
                    f"{spot.place}/each",
                    f"'{spot.state.each}' is of type '{kind}', not 'list'; 'each' goes over a list",
                )


def mismatched_writes(survey: MissionIndex) -> Found:
    """What is set, added or copied to a key is of the key's type."""
    for write in survey.writes:
        key = survey.mission.blackboard.get(write.key)
        if key is not None and (found := _written(survey, write, key)):
            yield found


def _written(survey: MissionIndex, write: Write, key: Key) -> tuple[str, str] | None:
    """What is wrong with a write, if anything is."""
    if write.by == "from":
        kind = _kind(survey, write.value, write.scope)
        exact = key.type == "integer" and kind == "number"
        if kind is not None and (
            exact or not (_fits_together(kind, key.type) or {kind, key.type} == {"object", "pose"})
        ):
            return (
                write.place,
                f"'{write.key}' is of type '{key.type}' and '{write.value}' of type '{kind}'; copy a key of its type",
            )
    elif write.by == "add":
        if key.type not in NUMBERS:
            return (
                f"{write.place}/add",
                f"'{write.key}' is of type '{key.type}', to which nothing can be added; use 'value'",
            )
        if key.type == "integer" and write.value != int(write.value):
            return (
                f"{write.place}/add",
                f"'{write.key}' is an integer, and {write.value:g} is none; add a whole number, or make it a number",
            )
    elif write.by == "status" and key.type != "string":
        return write.place, f"'{write.key}' is of type '{key.type}', and a status is a string; write one that is"
    elif write.by == "set" and next(template_reads(write.value, ""), None) is None and (why := fits(key, write.value)):
        return f"{write.place}/value", f"'{write.key}' cannot hold this: {why}; write one that is"
    return None
