# SPDX-License-Identifier: Apache-2.0
"""Where the parts of guards and the names of a list are: JSON pointers (RFC 6901) in the mission."""

from __future__ import annotations

from collections.abc import Iterator

from rai_missions.errors import escaped
from rai_missions.guards import Guard

__all__ = ("guard_parts", "listed_names", "pointer")


def pointer(place: str, *words: object) -> str:
    """A place inside another."""
    return "/".join([place, *map(escaped, words)])


def listed_names(place: str, names: tuple[str, ...]) -> Iterator[tuple[str, str]]:
    """Each name with its place: one alone is at the place itself, several are in a list."""
    for number, name in enumerate(names):
        yield (place if len(names) == 1 else f"{place}/{number}"), name


def guard_parts(guard: Guard, place: str) -> Iterator[tuple[str, Guard]]:
    """The guard and all inside it, outermost first, each with its place."""
    stack = [(place, guard)]
    while stack:
        here, part = stack.pop()
        yield here, part
        stack += reversed(list(part.inside(here)))
