# SPDX-License-Identifier: Apache-2.0
"""Numbers that are only counted and compared with constants: a step counts on from any of them.

Rule: a step that adds to such a number asks what guards find out of it before and after each addition, and nothing
else. So it goes the same way from every value of which they find out the same, and what it does to the store is to add
as much as it added here. Past the bounds that `Values.saturating` gives, guards find out the same of all values: only
the sum is brought back to them, as it is after a step that is made. A step that was put forward, or that looked whether
it goes round (`StepCircles`), has compared the values themselves: it is repeated for the same values alone.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping
from typing import Any

from rai_missions.keys import Stamped

__all__ = ("Count", "clamped", "with_counts")

Bounds = Mapping[str, tuple[float, float]]


class Count(int):
    """A number, and how much was added to it in this step."""

    added: int = 0

    def __add__(self, other: int) -> Count:
        made = Count(int(self) + other)
        made.added = self.added + other
        return made


def with_counts(keys: Mapping[str, Any], counters: Collection[str]) -> Mapping[str, Any]:
    """Entries of which the numbers that are counted know how much is added to them."""
    found = dict(keys)
    for key in counters:
        entry = keys.get(key)
        if entry is not None and type(entry[0]) is int:
            found[key] = Stamped(Count(entry[0]), entry[1])
    return found


def clamped(bounds: Bounds, key: str, value: int) -> int:
    """A number within the bounds past which no guard distinguishes it from others."""
    low, high = bounds.get(key, (value, value))
    return int(min(max(value, low), high))
