# SPDX-License-Identifier: Apache-2.0
"""Where two steps part, in words."""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from rai_missions.engine.step import Step
from rai_missions.model import alike
from rai_missions.redaction import cut_repr

__all__ = ("difference",)

Writes = tuple[tuple[str, Any], ...]
MISSING = object()
LATER = ("mode", "holder", "verdicts", "refusal", "kept")
"""Fields that a row has only if it was written by a version that knew them; then it has a mode."""


def difference(expected: Step, got: Step, *, without: Collection[str] = ()) -> str:
    """The first difference between two steps, in the order of their fields; empty where there is none.

    A step that was stored before steps had a mode is compared by the fields that it has. Those of `without` are
    left out. A write that repeats the value which its key has from the same step counts for nothing: earlier versions
    wrote the first item of an `each` twice.

    Such as `step 12 (anomaly, 3.2 s): moves[0].entered[1] was 'driving', now it is 'assessing'`.
    """
    left_out = {*without, *(LATER if expected.mode is None else ())}
    for name in [name for name in Step._fields if name not in left_out]:
        old, new = getattr(expected, name), getattr(got, name)
        if name == "writes" and len(old) != len(new):
            old, new = _without_repeats(old), _without_repeats(new)
        found = _parted(name, old, new)
        if found:
            return f"step {expected.seq} ({expected.event.name}, {expected.at:g} s): {found}"
    return ""


def _without_repeats(writes: Writes) -> Writes:
    """The writes of a step that gave a key another value than it had from that step."""
    newest: dict[str, Any] = {}
    kept: list[tuple[str, Any]] = []
    for key, value in writes:
        if key not in newest or not alike(newest[key], value):
            kept.append((key, value))
        newest[key] = value
    return tuple(kept)


def _parted(place: str, expected: Any, got: Any) -> str:
    if alike(expected, got):
        return ""
    if type(expected) is type(got):
        if hasattr(expected, "_fields"):
            pairs = [(f".{name}", getattr(expected, name), getattr(got, name)) for name in expected._fields]
            return _first(place, pairs)
        if isinstance(expected, Mapping):
            names = [*expected, *(name for name in got if name not in expected)]
            return _first(place, [(f".{name}", expected.get(name, MISSING), got.get(name, MISSING)) for name in names])
        if isinstance(expected, list | tuple):
            longest = range(max(len(expected), len(got)))
            return _first(place, [(f"[{index}]", _at(expected, index), _at(got, index)) for index in longest])
    return f"{place} was {_shown(expected)}, now it is {_shown(got)}"


def _first(place: str, pairs: list[tuple[str, Any, Any]]) -> str:
    return next((found for part, old, new in pairs if (found := _parted(f"{place}{part}", old, new))), "")


def _at(items: Any, index: int) -> Any:
    return items[index] if index < len(items) else MISSING


def _shown(value: Any) -> str:
    return "absent" if value is MISSING else f"{cut_repr(value, 120)}"
