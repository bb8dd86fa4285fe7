# SPDX-License-Identifier: Apache-2.0
"""Who follows a run: its recording first, then another observer."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeVar

from rai_missions.recording.recording import Recording
from rai_missions.runtime.run_options import RunObserver

__all__ = ("observers",)

T = TypeVar("T")


def observers(recording: Recording, other: RunObserver) -> RunObserver:
    """An observer that passes each step and each status on to both."""
    return RunObserver(_both(recording.step, other.on_step), _both(recording.status, other.on_status))


def _both(first: Callable[[T], None], second: Callable[[T], None] | None) -> Callable[[T], None]:
    if second is None:
        return first

    def notify(what: T) -> None:
        first(what)
        second(what)

    return notify
