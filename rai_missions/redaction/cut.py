# SPDX-License-Identifier: Apache-2.0
"""What somebody gave, in so many characters: the one door by which a text from outside is cut.

Rule: secrets are taken out first, of the whole text, and then it is cut; no half of a secret is left. What is a part of
a step was redacted before it became one, and the chart depends on nothing but its events: there, and there alone,
`clipped` cuts without asking for secrets.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping
from typing import Any

from rai_missions.error_text import in_words
from rai_missions.redaction.redact import longest_secret, redacted

__all__ = ("clipped", "cut", "cut_repr", "first_line", "shown")

MARGIN = 1_000
"""Characters beyond the longest secret that are looked at, for those that are known by their shape."""


def cut(what: object, length: int) -> str:
    """A thing in words, without secrets, in so many characters at the most.

    Args:
        what: A text, an exception, or whatever somebody gave.
        length: Characters.
    """
    text = in_words(what)
    beyond = longest_secret() + MARGIN
    window = length + beyond
    while True:
        clean = redacted(text[:window])
        if window >= len(text) or len(clean) >= length + beyond:
            return clean[:length]
        window *= 2


def cut_repr(what: object, length: int) -> str:
    """As Python writes it, without secrets, in so many characters at the most."""
    try:
        text = repr(what)
    except Exception:  # noqa: BLE001 - it may be anything, and raise anything
        text = f"<{type(what).__name__}>"
    return cut(text, length)


def first_line(what: object, length: int = 300) -> str:
    """The first line of an exception or a text, without secrets; empty where there is none."""
    lines = cut(what, 10 * length).strip().splitlines()
    return lines[0][:length] if lines else ""


def clipped(text: str, length: int) -> str:
    """The beginning of a text in which there is no secret any more, since it is a part of a step."""
    return text[:length]


def shown(value: Any, length: int = 60, *, by: Callable[[str, int], str] = cut) -> str:
    """A value as its author wrote it, cut short; text in single quotes.

    Args:
        value: Plain data.
        length: Characters.
        by: How it is cut: `clipped` inside a step.
    """
    if isinstance(value, str):
        return f"'{_short(value, length, by)}'"
    if isinstance(value, Mapping | list | tuple):
        kind, count = ("an object", "words") if isinstance(value, Mapping) else ("a list", "items")
        if len(value) > 4:
            return f"{kind} of {len(value)} {count}"
    try:
        text = json.dumps(value, ensure_ascii=False)
    except (TypeError, ValueError, RecursionError):
        text = repr(value)
    return _short(text, length, by)


def _short(text: str, length: int, by: Callable[[str, int], str]) -> str:
    """Half a surrogate pair, which no output can show, stands as its escape."""
    text = text.encode("utf-8", "backslashreplace").decode()
    found = by(text, length + 1)
    return found if len(found) <= length else found[: length - 1] + "…"
