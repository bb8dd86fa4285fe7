# SPDX-License-Identifier: Apache-2.0
"""How a run begins, and who follows it: values that a `Runner` is given."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, NamedTuple, TypeVar

from rai_missions.engine import Named
from rai_missions.engine.activities.ticker import Trees
from rai_missions.engine.step import Step
from rai_missions.given import given_names
from rai_missions.redaction import logger
from rai_missions.runtime.lifecycle import Status

__all__ = ("HarmlessObserver", "NewRun", "RunObserver")

log = logger(__name__)

T = TypeVar("T")


@dataclass(frozen=True)
class NewRun:
    """A run that begins with the mission's first state; one that was cut short begins with its `Resumption`."""

    arguments: Mapping[str, Any] = field(default_factory=dict)
    """Values for the mission's argument keys."""
    named: Named | None = None
    """The predicates that the mission's guards name."""
    ticker: Trees | None = None
    """Ticks the mission's trees, if not as compiled by the chart."""
    run: str = ""
    """The run's identity; made up where it is empty."""
    waits: bool = False
    """Once the robot has reported what the mission needs, it waits, ready, for the command to start."""
    moved_aside: str | None = None
    """Where the journal of an earlier run is now, whose name this one's took; for the result."""

    def __post_init__(self) -> None:
        """Hold the arguments to their type.

        Raises:
            UsageError: They are no mapping.
        """
        given_names(self.arguments, "arguments", "values")


class RunObserver(NamedTuple):
    """Follows a run, on the runner's thread; what it raises is logged once and harms nothing."""

    on_step: Callable[[Step], None] | None = None
    """Called with each step, after its effects."""
    on_status: Callable[[Status], None] | None = None
    """Called with each change of mode, control or active states."""

    def before(self, other: RunObserver) -> RunObserver:
        """An observer that passes each step and each status on to both, to this one first."""
        return RunObserver(_both(self.on_step, other.on_step), _both(self.on_status, other.on_status))


class HarmlessObserver:
    """Calls an observer: what it raises harms nothing, and the first thing that each callback raises is logged.

    Args:
        observer: Whose callbacks are called.
    """

    def __init__(self, observer: RunObserver) -> None:
        self._observer = observer
        self._failed: set[str] = set()

    def on_step(self, step: Step) -> None:
        self._call("on_step", self._observer.on_step, step)

    def on_status(self, status: Status) -> None:
        self._call("on_status", self._observer.on_status, status)

    def _call(self, name: str, callback: Callable[[T], None] | None, what: T) -> None:
        try:
            if callback is not None:
                callback(what)
        except Exception:
            if name not in self._failed:
                self._failed.add(name)
                log.exception("%s raised; the run continues", name)


def _both(first: Callable[[T], None] | None, second: Callable[[T], None] | None) -> Callable[[T], None] | None:
    if first is None or second is None:
        return first or second

    def notify(what: T) -> None:
        first(what)
        second(what)

    return notify
