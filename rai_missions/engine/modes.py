# SPDX-License-Identifier: Apache-2.0
"""The modes of a run, and what leads from one to another: the only table of them.

The chart refuses commands by it, the lifecycle that others read is built of it, and its diagram is drawn from it.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Literal, NamedTuple, get_args

from rai_missions.states.final import FinalOutcome

__all__ = (
    "ALIVE",
    "MODES",
    "MODE_TABLE",
    "Mode",
    "ModeChange",
    "RunMode",
    "diagram",
    "mode_of",
    "next_mode",
    "refusal",
)

Alive = Literal["ready", "running", "paused", "canceling"]
"""The modes in which the mission has not ended."""
Mode = Literal[Alive, FinalOutcome]
RunMode = Literal[Alive, "ended"]
"""The mode as a run remembers it, next to its outcome."""
ALIVE: tuple[Alive, ...] = get_args(Alive)
MODES: tuple[Mode, ...] = get_args(Mode)
"""The last four are the outcomes: in each of them the mission has ended."""


class ModeChange(NamedTuple):
    """What leads from some modes to another."""

    trigger: str
    """A command, or the outcome with which the mission ends."""
    sources: tuple[Mode, ...]
    target: Mode
    otherwise: str = "the mission is {mode}; it cannot {trigger} now"
    """Why it is refused in any other mode in which the mission has not ended."""


MODE_TABLE = (
    ModeChange("start", ("ready",), "running"),
    ModeChange("pause", ("ready", "running"), "paused", "only a running mission can be paused; it is {mode}"),
    ModeChange(
        "stop",
        ("ready", "running", "paused"),
        "paused",
        "only a running or paused mission can be stopped; it is {mode}",
    ),
    ModeChange("resume", ("paused",), "running", "only a paused mission can be resumed; it is {mode}"),
    ModeChange("ready", ("paused",), "ready"),
    ModeChange("cancel", ("ready", "running", "paused"), "canceling", "it is being canceled already"),
    ModeChange("kill", ALIVE, "aborted"),
    ModeChange("canceled", ("running", "canceling"), "canceled"),
    ModeChange("succeeded", ("running",), "succeeded"),
    ModeChange("failed", ("ready", "running"), "failed"),
    ModeChange("aborted", ALIVE, "aborted"),
)
"""`aborted` out of any mode: an invariant that is false ends the mission at once. `ready` out of `paused`: a run that
was paused before its start is resumed."""
_CHANGES: Mapping[tuple[str, str], ModeChange] = {
    (source, each.trigger): each for each in MODE_TABLE for source in each.sources
}
_TRIGGERS = {each.trigger: each for each in MODE_TABLE}


def mode_of(mode: RunMode, outcome: FinalOutcome | None, *, held_back: bool) -> Mode:
    """The mode of a run as every reader has it: one that has ended is in its outcome, and one held back is paused."""
    if mode == "ended":
        return outcome or "aborted"
    return "paused" if mode == "ready" and held_back else mode


def next_mode(mode: str, trigger: str) -> Mode | None:
    """Where a trigger leads from a mode; None where it leads nowhere."""
    found = _CHANGES.get((mode, trigger))
    return found.target if found is not None else None


def refusal(mode: str, trigger: str) -> str:
    """Why a command makes no sense in a mode; empty where it does."""
    if (mode, trigger) in _CHANGES:
        return ""
    return _TRIGGERS[trigger].otherwise.format(mode=mode, trigger=trigger) if mode in ALIVE else "the mission has ended"


def diagram() -> Iterator[str]:
    """The table as a Mermaid state diagram, line by line."""
    yield "stateDiagram-v2"
    yield f"    [*] --> {MODES[0]}"
    for trigger, sources, target, _ in MODE_TABLE:
        for source in sources:
            yield f"    {source} --> {target}: {trigger}"
    for mode in MODES:
        if mode not in ALIVE:
            yield f"    {mode} --> [*]"
