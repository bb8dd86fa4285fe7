# SPDX-License-Identifier: Apache-2.0
"""Values for somebody else's hands: equal to the run's own, and none of them.

Rule: whoever is asked, called or commanded is given nothing by which the mission or the blackboard could be changed.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

__all__ = ("apart", "listed")

LEAVES = frozenset({str, int, float, bool, type(None)})


def apart(value: Any) -> Any:
    """The value with objects and lists of its own, at every depth; a picture stays the one it is."""
    if isinstance(value, Mapping):
        return {name: apart(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        made = [item if type(item) in LEAVES else apart(item) for item in value]
        return made if isinstance(value, list) else tuple(made)
    return value


def listed(value: Any) -> str:
    """A value in one line: `pose x 1.5, y 2, speed 1.2`."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {listed(item)}" for name, item in value.items())
    if isinstance(value, list | tuple):
        return "[" + ", ".join(listed(item) for item in value) + "]"
    return ("true" if value else "false") if isinstance(value, bool) else str(value)
