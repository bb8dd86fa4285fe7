# SPDX-License-Identifier: Apache-2.0
"""The keys that a model was made with, so that they can be hidden."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import SecretBytes, SecretStr

from rai_missions.redaction import is_secret_name, passwords_in

__all__ = ("secrets_of",)

DEEPEST = 4
"""Objects inside each other in which keys are looked for."""
MOST_PARTS = 200
"""Parts of one object that are looked at."""


def secrets_of(thing: Any, depth: int = 0, name: str = "") -> Iterator[str]:
    """The keys in a model: by their type, by the name of their field, and in addresses.

    Args:
        thing: A model, or what one holds.
        depth: How deep in it this is.
        name: The name of the field that holds it.
    """
    if isinstance(thing, SecretStr):
        yield thing.get_secret_value()
    elif isinstance(thing, SecretBytes):
        yield thing.get_secret_value().decode("utf-8", "replace")
    elif isinstance(thing, str):
        name = name.upper().replace("-", "_")
        if is_secret_name(name) or name.endswith("AUTHORIZATION"):
            yield from {thing, thing.rpartition(" ")[2]}
        elif "://" in thing:
            yield from passwords_in(thing)
    elif depth < DEEPEST:
        for inner, item in _parts(thing)[:MOST_PARTS]:
            yield from secrets_of(item, depth + 1, str(inner))


def _parts(thing: Any) -> list[tuple[Any, Any]]:
    """The named parts of an object that may hold a key."""
    if isinstance(thing, Mapping):
        return list(thing.items())
    if isinstance(thing, list | tuple):
        return [("", item) for item in thing]
    if hasattr(type(thing), "model_fields") or hasattr(type(thing), "__dataclass_fields__"):
        return list(getattr(thing, "__dict__", {}).items())
    return []
