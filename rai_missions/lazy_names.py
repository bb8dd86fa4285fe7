# SPDX-License-Identifier: Apache-2.0
"""The public names of a package, each imported when it is first used (PEP 562)."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from importlib import import_module
from typing import Any

__all__ = ("lazy_names",)


def lazy_names(
    scope: dict[str, Any], rooms: Mapping[str, Iterable[str]]
) -> tuple[Callable[[str], Any], Callable[[], list[str]]]:
    """The `__getattr__` and `__dir__` of a package, or of a module, that offers names of others.

    Args:
        scope: Its `globals()`, where a name is kept once it was used.
        rooms: Module below the package → the names that it offers; `Call as CallEffect` has another name here.
    """
    homes = {each.rpartition(" as ")[2]: (room, each.partition(" as ")[0]) for room, names in rooms.items()
             for each in names}  # fmt: skip

    def load(name: str) -> Any:
        if name not in homes:
            raise AttributeError(f"module {scope['__name__']!r} has no attribute {name!r}")
        room, own = homes[name]
        return scope.setdefault(name, getattr(import_module(f".{room}", scope["__package__"]), own))

    return load, lambda: sorted({*scope, *homes})
