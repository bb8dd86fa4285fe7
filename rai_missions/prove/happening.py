# SPDX-License-Identifier: Apache-2.0
"""One thing that can happen to a mission, whoever brings it about."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal, NamedTuple

__all__ = ("KINDS", "Happening", "HappeningKind")

HappeningKind = Literal["start", "event", "robot", "answer", "write", "time", "command"]
KINDS: tuple[HappeningKind, ...] = ("start", "event", "robot", "answer", "write", "time", "command")
"""`robot`: a goal's, call's or behaviour's report, or a handover. `write`: something known changes."""


class Happening(NamedTuple):
    """One thing that can happen."""

    words: str
    """As a person would say it."""
    kind: HappeningKind
    do: Callable[[], None]
    number: int = 0
    """Of the goal, call, question or behaviour that it is about."""
    stale: str = ""
    """The key that goes stale."""
