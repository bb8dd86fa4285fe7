# SPDX-License-Identifier: Apache-2.0
"""A condition written as text, as other languages have it: which guard it most likely means.

Rule: only a message to the author shows it. No text is ever read as a guard.
"""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

__all__ = ("EXAMPLE", "SIGNS", "WORDS", "meant_guard")

EXAMPLE: Mapping[str, Any] = {"key": "battery", "<": 0.3}
SIGNS = {
    "=": "==", "===": "==", "eq": "==", "is": "==", "equals": "==", "!==": "!=", "<>": "!=", "ne": "!=", "neq": "!=",
    "lt": "<", "less": "<", "below": "<", "=<": "<=", "≤": "<=", "le": "<=", "lte": "<=",
    "gt": ">", "greater": ">", "above": ">", "=>": ">=", "≥": ">=", "ge": ">=", "gte": ">=", "one_of": "in",
}  # fmt: skip
"""Operators of other languages → the format's."""
WORDS = {"and": "all", "&&": "all", "or": "any", "||": "any", "!": "not", "none": "not", "state": "in", "is_in": "in"}
"""Words of other languages for guards → the format's."""
LONGEST = 200
"""A longer text gets an example instead."""
JOINTS = (("any", re.compile(r"\s+or\s+|\|\|")), ("all", re.compile(r"\s+and\s+|&&")))
DENIED = re.compile(r"\s*(?:not\s+|!)(.+)")
PATH = re.compile(r"[a-z][a-z0-9_]*(?:\.[A-Za-z_][A-Za-z0-9_]*)*")
COMPARED = re.compile(
    rf"\s*(?P<key>{PATH.pattern})\s*(?:(?P<sign>[=!<>≤≥]{{1,3}}|\b(?:is|eq|ne|lt|le|gt|ge)\b)\s*(?P<value>\S.*?))?\s*"
)


def meant_guard(text: str) -> Any:
    """The guard as JSON that a text such as `battery < 0.3 and not blocked` means; None where that is not clear."""
    if len(text) > LONGEST:
        return None
    for word, joint in JOINTS:
        if len(parts := joint.split(text)) > 1:
            inner = [meant_guard(part) for part in parts]
            return None if None in inner else {word: inner}
    if (denied := DENIED.fullmatch(text)) is not None and not denied[1].startswith("="):
        negated = meant_guard(denied[1])
        return None if negated is None else {"not": negated}
    found = COMPARED.fullmatch(text)
    if found is None:
        return None
    if found["sign"] is None:
        return {"key": found["key"], "==": True}
    sign = SIGNS.get(found["sign"], found["sign"])
    value = _operand(found["value"])
    return (
        None if value is None or sign not in ("==", "!=", "<", "<=", ">", ">=") else {"key": found["key"], sign: value}
    )


def _operand(text: str) -> Any:
    """A value, or another key; None where it is neither."""
    try:
        value = json.loads({"True": "true", "False": "false"}.get(text, text))
    except ValueError:
        if len(text) > 1 and text[0] == text[-1] == "'":
            return text[1:-1]
        return {"key": text} if PATH.fullmatch(text) else None
    return (
        value
        if isinstance(value, str | int | float) and abs(value if not isinstance(value, str) else 0) < 1e300
        else None
    )
