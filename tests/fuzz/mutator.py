# SPDX-License-Identifier: Apache-2.0
"""Changes JSON as an adversary would: whole values are moved, repeated, nested, misspelled and exchanged for odd ones.

Rule: the same random source makes the same change.
"""

from __future__ import annotations

import json
import random
from collections.abc import Iterator
from typing import Any

__all__ = ("ODD", "mutated")

ODD: tuple[Any, ...] = (
    None, True, False, 0, -1, 1, 0.5, 1e308, -1e308, 5e-324, 2**63 - 1, -(2**63), 2**64, 10**400, "", " ", "~", "/",
    "*", "..", "../../etc/passwd", "/dev/zero", "a" * 300, "\0", "\ud800", "\u202e", "é", "{{}}", "<script>", "a/b",
    [], {}, [[]], [{}], {"": ""}, {"key": "x"}, {"from": "x"}, {"not": {"not": {"in": "x"}}}, {"$ref": "#"}, "final",
    "succeeded", "NaN", "1e999", {"all": []}, {"any": []}, {"history": "deep"}, {"mission": "mission.json"},
    {"type": "object", "properties": {"a": {"$ref": "http://127.0.0.1/"}}}, {"pattern": "(a+)+$"},
)  # fmt: skip
MOST_PLACES = 5_000
Place = tuple[Any, Any]
"""Something that holds values, and the word or number under which it holds one."""


def mutated(value: Any, source: random.Random) -> Any:
    """The value with one to four changes."""
    root = [json.loads(json.dumps(value))]
    for _ in range(source.choice((1, 1, 2, 4))):
        _change(root, source)
    return root[0]


def _change(root: list[Any], source: random.Random) -> None:
    places = list(_places(root))
    holder, word = source.choice(places)
    other, where = source.choice(places)
    value = holder[word]
    kind = source.randrange(10)
    if kind == 0:
        holder[word] = source.choice(ODD)
    elif kind == 1:
        holder[word] = json.loads(json.dumps(other[where]))
    elif kind == 2 and holder is not root:
        del holder[word]
    elif kind == 3:
        holder[word] = _nested(value, source)
    elif kind == 4 and isinstance(holder, dict):
        holder[source.choice(_words(places) or ["x"])] = holder.pop(word)
    elif kind == 5 and isinstance(value, dict):
        value[source.choice(_words(places) or ["x"])] = json.loads(json.dumps(other[where]))
    elif kind == 6 and isinstance(value, list) and value:
        value.extend(value * source.choice((1, 3, 20)))
        del value[400:]
    elif kind == 7 and isinstance(value, str):
        holder[word] = _misspelled(value, source)
    elif kind == 8 and isinstance(value, dict):
        holder[word] = [*value, source.choice(_words(places) or ["x"]).title()]
    elif isinstance(value, int | float):
        holder[word] = source.choice((value + 1, -value, value * 10**9, str(value)[:300], 1 - value))
    else:
        holder[word] = source.choice(ODD)


def _nested(value: Any, source: random.Random) -> Any:
    for _ in range(source.choice((1, 2, 50))):
        value = source.choice(([value], {"not": value}, {"all": [value]}, {"sequence": [value]}))
    return value


def _misspelled(text: str, source: random.Random) -> str:
    at = source.randrange(len(text) + 1)
    return text[:at] + source.choice(("", "a", "_", "/", "é", "\0", ".", text[:3])) + text[at + 1 :]


def _places(value: Any) -> Iterator[Place]:
    rest, count = [value], 0
    while rest:
        holder = rest.pop()
        for word, item in list(holder.items() if isinstance(holder, dict) else enumerate(holder)):
            yield holder, word
            count += 1
            if count == MOST_PLACES:
                return
            if isinstance(item, dict | list):
                rest.append(item)


def _words(places: list[Place]) -> list[str]:
    return [word for _, word in places if isinstance(word, str)]
