# SPDX-License-Identifier: Apache-2.0
"""What a tool reports: words and a picture for a model, data for a program.

Rule: what came from the robot is between <facts> and </facts>, which no fact can close; only our own words are
outside.
"""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from itertools import islice
from typing import Any, NamedTuple

from rai_missions.errors import UsageError
from rai_missions.image import Image
from rai_missions.redaction import closed, cut, cut_repr

__all__ = ("LONGEST", "ToolResult", "field_at", "outline")

LONGEST = 4_000
"""Characters of facts that a model is shown."""
ITEMS, FIELDS, CHARACTERS, LONGEST_NAME, DEEPEST = 20, 100, 1_000, 200, 12
"""How much of a list, a mapping, a text, a field's name and of what lies inside one another is shown."""


class ToolResult(NamedTuple):
    """The result of one use of a tool."""

    words: str
    """Ours: what was done and how it ended."""
    data: Mapping[str, Any]
    """For programs: everything, uncut; bytes and `Image` as they are."""
    facts: Any = None
    """Of the robot: what a model is shown of it; None: nothing besides the words."""
    picture: Mapping[str, Any] | None = None
    """A content block that shows a picture."""

    def text(self) -> str:
        """For a model: the words, and the facts marked as data."""
        return self.words if self.facts is None else f"{self.words}\n<facts>\n{_quoted(self.facts)}\n</facts>"

    def content(self) -> str | list[dict[str, Any]]:
        """The text, and the picture if there is one, as a message carries it."""
        return self.text() if self.picture is None else [{"type": "text", "text": self.text()}, dict(self.picture)]


def field_at(message: Any, path: str) -> Any:
    """The field at a path, `pose.position.x`, or an item of a list, `ranges.0`.

    Raises:
        UsageError: There is none; the text names what there is instead.
    """
    for word in path.split(".") if path else ():
        if isinstance(message, Mapping) and word in message:
            message = message[word]
        elif isinstance(message, list | tuple) and word.isdecimal() and int(word) < len(message):
            message = message[int(word)]
        else:
            known = ", ".join(map(str, message)) if isinstance(message, Mapping) else f"a {type(message).__name__}"
            raise UsageError(f"no field {cut_repr(word, 60)} of {cut_repr(path, 60)}; there is: {cut(known, 200)}")
    return message


def outline(value: Any, depth: int = 0) -> Any:
    """A value as JSON takes it, with long things cut short, each with a note."""
    if value is None or isinstance(value, bool | int):
        return value if not isinstance(value, int) or abs(value) < 2**64 else "a number too great to show"
    if isinstance(value, float):
        return value if math.isfinite(value) else str(value)
    if isinstance(value, str):
        return _shortened(value, CHARACTERS)
    if isinstance(value, bytes | bytearray | memoryview):
        return f"{len(value)} bytes"
    if isinstance(value, Image):
        size = f"{value.width} × {value.height}" if value.width else value.encoding
        return f"a picture, {size}"
    if depth >= DEEPEST:
        return "…"
    if isinstance(value, Mapping):
        return _outline_fields(value, depth)
    if hasattr(value, "tolist"):  # numpy's, without knowing numpy
        value = value.tolist()
    if isinstance(value, list | tuple):
        shown = [outline(item, depth + 1) for item in islice(value, ITEMS)]
        return shown if len(value) <= ITEMS else [*shown, f"… {len(value) - ITEMS} more"]
    return cut(value, 80)


def _outline_fields(value: Mapping[Any, Any], depth: int) -> dict[str, Any]:
    shown = {
        _shortened(f"{name!s}", LONGEST_NAME): outline(item, depth + 1) for name, item in islice(value.items(), FIELDS)
    }
    if len(value) > FIELDS:
        shown["…"] = f"{len(value) - FIELDS} more"
    return shown


def _shortened(text: str, length: int) -> str:
    return text if len(text) <= length else f"{cut(text, length)}… ({len(text)} characters)"


def _quoted(facts: Any) -> str:
    """Facts on one line of JSON that cannot end the block that it is in."""
    text = json.dumps(outline(facts), ensure_ascii=False, allow_nan=False)
    more = "" if len(text) <= LONGEST else f"… (cut: {len(text)} characters; ask for less, such as one field)"
    return closed(cut(text, LONGEST)) + more
