# SPDX-License-Identifier: Apache-2.0
"""Values as plain data: copies that share nothing, JSON for readers, and one line of text.

Rule: what a client, a server or an answerer receives is a copy; changing it changes neither mission nor blackboard.
"""

from __future__ import annotations

import base64
import math
from collections.abc import Mapping, Sequence
from collections.abc import Set as AbstractSet
from typing import Any

from rai_missions.image import Image

__all__ = ("apart", "listed", "plain")

LEAVES = frozenset({str, int, float, bool, type(None)})


def apart(value: Any) -> Any:
    """The value with objects and lists of its own, at every depth; a picture stays the one it is."""
    if isinstance(value, Mapping):
        return {name: apart(item) for name, item in value.items()}
    if isinstance(value, list | tuple):
        made = [item if type(item) in LEAVES else apart(item) for item in value]
        return made if isinstance(value, list) else tuple(made)
    return value


def plain(value: Any) -> Any:
    """Any value as JSON has it: bytes in base64, a picture by its reference, NaN and infinity as text."""
    if value is None or isinstance(value, str | int):
        return value
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, Mapping):
        return {str(name): plain(item) for name, item in value.items()}
    if isinstance(value, bytes | bytearray | memoryview):
        return base64.b64encode(value).decode()
    if isinstance(value, Image):
        return {"picture": value.ref, "width": value.width, "height": value.height, "encoding": value.encoding}
    if isinstance(value, Sequence | AbstractSet):
        return [plain(item) for item in value]
    return str(value)


def listed(value: Any) -> str:
    """A value in one line: `pose x 1.5, y 2, speed 1.2`."""
    if isinstance(value, Mapping):
        return ", ".join(f"{name} {listed(item)}" for name, item in value.items())
    if isinstance(value, list | tuple):
        return "[" + ", ".join(listed(item) for item in value) + "]"
    return ("true" if value else "false") if isinstance(value, bool) else str(value)
