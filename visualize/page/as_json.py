# SPDX-License-Identifier: Apache-2.0
"""Values of missions and runs as JSON that a browser shows as text.

Rule: a page holds plain data. What JSON has not becomes a word, and a picture the reference by which it is found.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from typing import Any

from rai_missions.image import Image

__all__ = ("Json", "Pool", "plain", "without_empty")

Json = dict[str, Any]


def plain(value: Any) -> Any:
    """A value that `json` can write, in words that a reader knows."""
    if value is None or isinstance(value, bool | int | str):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else "unknown" if math.isnan(value) else f"{value:+}"
    if isinstance(value, Image):
        return {"picture": value.ref, "width": value.width, "height": value.height}
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, list | tuple | set | frozenset):
        return [plain(item) for item in value]
    return str(value)


def without_empty(given: Mapping[str, Any]) -> Json:
    """Less what is empty; the page takes what is not there for that."""
    return {name: item for name, item in given.items() if item not in ("", (), None, False, {}, [])}


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
