# SPDX-License-Identifier: Apache-2.0
"""Which number of a command no actuator should be told: one that is NaN or infinite."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from typing import Any

__all__ = ("no_finite",)


def no_finite(data: Any, path: str = "") -> str:
    """Which field holds no finite number, in a sentence; empty if none does."""
    if isinstance(data, float):
        return "" if math.isfinite(data) else f"'{path}' is {data}, which is no finite number"
    items: Iterable[tuple[object, Any]] = ()
    if isinstance(data, Mapping):
        items = data.items()
    elif isinstance(data, list | tuple):
        items = enumerate(data)
    elif hasattr(data, "tolist"):  # arrays and their numbers, of the standard library and of numpy
        plain = data.tolist()
        return no_finite(plain, path)
    return next((why for name, item in items if (why := no_finite(item, f"{path}.{name}".lstrip(".")))), "")
