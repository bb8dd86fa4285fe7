# SPDX-License-Identifier: Apache-2.0
"""What a type or a message has no place for, along a path, in a sentence."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from difflib import get_close_matches
from typing import Any, Literal

from rai_missions.connectors.field_types import is_list_type

__all__ = ("MANY", "FieldsOf", "TypePart", "inside", "is_list", "lack")

MANY = 20
"""The fields of one message."""
TypePart = Literal["msg", "srv", "request", "goal", "result"]
"""A message; of a service its reply (`srv`) or its request; of an action its goal or its result."""
FieldsOf = Callable[[str, TypePart], Mapping[str, Any] | None]
"""The fields of a part of a type: name → a plain type's name, the fields of a message, or a list of what one item
holds. None where the type is not here."""


def lack(there: Any, path: str) -> str:
    """What is not there on the way along a path, in what a type or a message holds; empty if all may be."""
    behind: list[str] = []
    for word in path.split("."):
        around = f" in '{'.'.join(behind)}'" if behind else ""
        if isinstance(there, Mapping):
            if word not in there:
                return f"has no field '{word}'{around}{_known(word, there)}"
            there = there[word]
        elif is_list(there):
            if not word.isdecimal():
                return f"has no field '{word}'{around}, which is a list; an item is named by its number, counted from 0"
            there = _item(there, int(word))
        elif isinstance(there, str | bool | int | float) and "/" not in str(there):
            return f"has no field '{word}'{around}, which is one value"
        else:
            return ""
        behind.append(word)
    return ""


def inside(there: Any, path: str) -> Any:
    """What is at the end of a path along which nothing lacks; None where nothing is known of it."""
    for word in path.split("."):
        if isinstance(there, Mapping):
            there = there[word]
        else:
            there = _item(there, int(word)) if is_list(there) else None
    return there


def is_list(there: Any) -> bool:
    """A list, or the name of a type of lists: `sequence<double>`, `double[36]`."""
    if isinstance(there, str):
        return is_list_type(there)
    return isinstance(there, list | tuple)


def _item(there: Any, number: int) -> Any:
    """What an item of a list holds; None where nothing is known of it."""
    if isinstance(there, str) or not there:
        return None
    return there[min(number, len(there) - 1)]


def _known(word: str, there: Mapping[str, Any]) -> str:
    close = get_close_matches(word, there, n=1, cutoff=0.6)
    near = f" (did you mean '{close[0]}'?)" if close else ""
    names = ", ".join(list(there)[:MANY]) + (", …" if len(there) > MANY else "")
    return f"{near}; it has: {names}" if names else f"{near}; it has none"
