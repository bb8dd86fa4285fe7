# SPDX-License-Identifier: Apache-2.0
"""How a fault's sentence says where it is, what was given and what there is."""

from __future__ import annotations

import difflib
from collections.abc import Iterable

__all__ = ("in_words", "pointer", "suggestion")


def suggestion(given: str, known: Iterable[str]) -> str:
    """`; did you mean 'x'?`, or the names that there are, for the end of a sentence."""
    known = sorted(set(known))
    close = difflib.get_close_matches(given, known, n=1, cutoff=0.6)
    if close:
        return f"; did you mean '{close[0]}'?"
    shown = ", ".join(known[:12]) + (", …" if len(known) > 12 else "")
    return f"; there is: {shown}" if shown else ""


def in_words(what: object) -> str:
    """What an exception says, or whatever somebody gave as a reason; one that cannot be told in words says its type."""
    try:
        text = str(what)
    except Exception:  # noqa: BLE001 - it may be anybody's, and raise anything
        text = f"a {type(what).__name__} that cannot be told in words"
    return str.__str__(text)


def pointer(steps: Iterable[str | int]) -> str:
    """A JSON pointer (RFC 6901); a lone surrogate, which no output can show, stands as its escape."""
    text = "".join("/" + str(step).replace("~", "~0").replace("/", "~1") for step in steps)
    return text.encode("utf-8", "backslashreplace").decode()
