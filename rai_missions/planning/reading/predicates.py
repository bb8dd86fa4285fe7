# SPDX-License-Identifier: Apache-2.0
"""Predicates of a goal as plain data, as the reading writes them."""

from __future__ import annotations

from typing import Any

from rai_missions.planning.reading.things import Names

__all__ = ("Plain", "each_of", "moved_by")

Plain = dict[str, Any]


def each_of(word: str, names: Names, target: str) -> list[Plain]:
    """A relation of each of these to another thing."""
    return [{word: [name, target]} for name in names]


def moved_by(predicate: Plain) -> tuple[str, ...]:
    """The things that a predicate brings somewhere."""
    if alone := predicate.keys() & {"at", "shifted"}:
        return (predicate[alone.pop()],)
    names = next(each for each in predicate.values() if isinstance(each, list))
    return tuple(names[:1] if predicate.keys() & {"on", "in", "left_of", "behind", "between"} else names)
