# SPDX-License-Identifier: Apache-2.0
"""Values of missions and runs as JSON that a browser shows as text.

Rule: a page holds plain data (`rai_missions.plain_data`).
"""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

__all__ = ("Json", "Pool", "named", "without_empty")

Json = dict[str, Any]


def without_empty(given: Mapping[str, Any]) -> Json:
    """Less what is empty; the page takes what is not there for that."""
    return {name: item for name, item in given.items() if item not in ("", (), None, False, {}, [])}


def named(value: Any) -> Any:
    """Named tuples, however deep, as objects with the names of their fields."""
    if isinstance(value, tuple) and hasattr(value, "_asdict"):
        return {name: named(item) for name, item in value._asdict().items()}
    return [named(item) for item in value] if isinstance(value, tuple) else value


class Pool:
    """Values that are written once however often they are meant."""

    def __init__(self) -> None:
        self.values: list[Any] = []
        self._found: dict[str, int] = {}

    def add(self, value: Any) -> int:
        """The number under which a plain value is kept."""
        text = json.dumps(value, separators=(",", ":"), sort_keys=True)
        number = self._found.setdefault(text, len(self.values))
        if number == len(self.values):
            self.values.append(value)
        return number
