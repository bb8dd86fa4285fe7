# SPDX-License-Identifier: Apache-2.0
"""One thing that can happen to a mission, no matter who brings it about."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, Literal, NamedTuple

__all__ = ("CANCEL", "KILL", "KINDS", "START", "Stimulus", "StimulusKind")

StimulusKind = Literal["start", "event", "robot", "answer", "write", "time", "command"]
KINDS: tuple[StimulusKind, ...] = ("start", "event", "robot", "answer", "write", "time", "command")
"""`robot`: a goal's, call's or behaviour's report, or a handover. `write`: something known changes."""
START, CANCEL, KILL = "the mission starts", "the operator cancels", "the operator gives the e-stop"
"""The words of these three."""


class Stimulus(NamedTuple):
    """One thing that can happen."""

    words: str
    """In words."""
    kind: StimulusKind
    do: Callable[[], None]
    number: int = 0
    """Of the goal, call, question or behaviour that it is about."""
    stale: str = ""
    """The key that goes stale."""
    owner: str = ""
    """The state in which this waits for time: entered again, or its tree gone round, it waits from the beginning."""
    timer: tuple[tuple[str, Any], int] | None = None
    """The timer that runs out: its key, and the order in which it was set; `goal` and a number for a goal's end."""
    is_of_goal: bool = False
    """It is about a goal that nothing pursues."""
    event: str = ""
    """The event that is received, or the one that a timer, or the failure of a call, raises."""
    key: str = ""
    """The key of which something else is known from now on."""
    is_tick: bool = False
    """All trees look again."""
    is_cancel: bool = False
    """The operator cancels."""
