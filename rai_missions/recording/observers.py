# SPDX-License-Identifier: Apache-2.0
"""Who looks on at a run: its recording first, then any other observer."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rai_missions.engine.step import Step
from rai_missions.recording.recording import Recording
from rai_missions.runtime.lifecycle import Status

__all__ = ("OnStatus", "OnStep", "observers")

T = TypeVar("T")
OnStep = Callable[[Step], None] | None
OnStatus = Callable[[Status], None] | None


def observers(recording: Recording | None, on_step: OnStep, on_status: OnStatus) -> tuple[OnStep, OnStatus]:
    """What a runner is to report of steps and of statuses."""
    if recording is None:
        return on_step, on_status
    return _both(recording.step, on_step), _both(recording.status, on_status)


def _both(first: Callable[[T], None], second: Callable[[T], None] | None) -> Callable[[T], None]:
    if second is None:
        return first

    def notify(what: T) -> None:
        first(what)
        second(what)

    return notify
