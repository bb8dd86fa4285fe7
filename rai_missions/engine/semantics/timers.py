# SPDX-License-Identifier: Apache-2.0
"""Instants and numbers of a run: when what is asked for now begins, what comes later, and what it is called."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from rai_missions.engine.state import RunState, Timer, TimerKey

__all__ = ("begins_at", "drop", "late_s", "next_number", "now_of", "set_timer")


def late_s(state: RunState) -> float:
    """How far a resumed run has yet to catch up, in seconds."""
    return max(0.0, state.present - state.at)


def begins_at(state: RunState) -> float:
    """When what is asked for now is carried out, and all that the robot reports is received.

    Now, or once a resumed run has caught up.
    """
    return state.at + late_s(state)


def now_of(state: RunState, control: str | None) -> float:
    """Now, as the states that need this control count time: it is stopped while they are held."""
    return state.frozen.get(control, state.at) if state.frozen and control is not None else state.at


def set_timer(
    state: RunState, key: TimerKey, after_s: float, name: str, data: Mapping[str, Any] | None, control: str | None
) -> None:
    """Have something come in so many seconds."""
    state.order += 1
    state.timers.pop(key, None)  # in the order in which they were set
    state.timers[key] = Timer(now_of(state, control) + after_s, state.order, name, data or {}, control or "")


def drop(state: RunState, timer: str) -> None:
    """Have an event that was to be raised later never come."""
    state.timers.pop(("raise", timer), None)


def next_number(state: RunState) -> int:
    """A fresh number for a start, a call or a question."""
    state.number += 1
    return state.number
